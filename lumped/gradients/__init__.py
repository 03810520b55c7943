"""Derivatives of runs, and the numbers that sum up a run."""

from lumped.support.lazy_names import lazy_names

__all__ = lazy_names(__name__)
