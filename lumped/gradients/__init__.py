"""Derivatives of runs, and the numbers that sum up a run."""
