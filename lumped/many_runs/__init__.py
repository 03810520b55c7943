"""Runs of variants in the time loop, and functionals that it collects on the way."""
