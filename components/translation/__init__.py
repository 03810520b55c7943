"""Parts of straight-line motion.

The names are deliberately those of the rotational twins, so import the module:
``from lumped.components import translation``. All positions of a model count along one axis, and
a force is positive along it.
"""

from lumped.components.translation.basic import *
from lumped.components.translation.contact import *
from lumped.components.translation.friction import *
from lumped.components.translation.loads import *
from lumped.components.translation.sources import *

__all__ = sorted(name for name, value in vars().items() if isinstance(value, type))
