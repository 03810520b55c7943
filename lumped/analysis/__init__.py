"""Analyses of an assembled system, one verb each."""
