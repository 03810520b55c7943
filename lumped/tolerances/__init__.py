"""Scatter of results by tolerances of parameters."""

from lumped.support.lazy_names import lazy_names

__all__ = lazy_names(__name__)
