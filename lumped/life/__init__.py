"""Life under varying loads: cycles, S-N curves, duty cycles, damage."""

from lumped.support.lazy_names import lazy_names

__all__ = lazy_names(__name__)
