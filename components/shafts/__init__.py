"""Shafts by geometry and material: sections, notches, and sections in line."""
