"""Vibrations order by order of a rotation, over its speed."""
