"""Operating points: start, equilibrium, linearisation, and how they change."""

from lumped.support.lazy_names import lazy_names

__all__ = lazy_names(__name__)
