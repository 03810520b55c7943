"""Periodic motions."""
