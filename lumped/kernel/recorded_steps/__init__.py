"""Recorded steps of a run, made again and differentiated backwards."""
