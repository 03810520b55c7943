"""Functionals as expansions in the parameters that scatter: about the mean, and in polynomials."""
