"""Acausal lumped-parameter modelling of drive trains on CasADi."""

from lumped.support.lazy_names import lazy_names

__version__ = "0.2.0"

__all__ = lazy_names(__name__)
