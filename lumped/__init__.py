"""Acausal lumped-parameter modelling of drive trains on CasADi."""

__version__ = "0.1.0"
