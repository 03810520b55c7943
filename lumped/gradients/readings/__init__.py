"""Readings of a run, and what they owe to its instants."""
