"""Plots, schematics, films and report pages."""
