"""Equations, frequencies and responses of small drives as formulas of their parameters."""
