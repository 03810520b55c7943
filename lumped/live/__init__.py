"""A page that computes runs in the browser."""

from lumped.support.lazy_names import lazy_names

__all__ = lazy_names(__name__)
