"""Drives that were entered for other programs."""
