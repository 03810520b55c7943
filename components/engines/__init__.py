"""Cranks, reciprocating engines, and the propeller they drive."""
