"""Limits that rules and standards set to vibrations."""
