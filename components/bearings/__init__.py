"""Rolling bearings, shaft seals and windage."""
