"""Many runs of one system at once, and the numbers that sum them up."""

from lumped.support.lazy_names import lazy_names

__all__ = lazy_names(__name__)
