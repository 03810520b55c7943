"""Readings of a run, and their derivatives through its instants."""
