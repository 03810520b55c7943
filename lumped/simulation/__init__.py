"""Runs in time, and what they are made for: certificates, sweeps, inverse, sizing."""

from lumped.support.lazy_names import lazy_names

__all__ = lazy_names(__name__)
