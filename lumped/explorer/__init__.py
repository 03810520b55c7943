"""A page on which one moves parameters and sees what changes."""

from lumped.support.lazy_names import lazy_names

__all__ = lazy_names(__name__)
