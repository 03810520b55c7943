"""Analyses of an assembled system, one module each."""
