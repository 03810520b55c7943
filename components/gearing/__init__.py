"""Gears, belts, and what shifts them."""
