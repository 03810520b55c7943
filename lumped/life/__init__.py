"""Life under varying loads: cycles, damage, bearings, gears, couplings."""

from lumped.support.lazy_names import lazy_names

__all__ = lazy_names(__name__)
