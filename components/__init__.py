"""Component library.

Import the rotational and electrical parts, motors, controllers and signals from here; the parts of
straight-line motion have the names of the rotational ones and are in
`lumped.components.translation`.
"""

import types

if not __name__.startswith("lumped."):
    raise ImportError(
        f"The component library was imported as {__name__!r}; its name is 'lumped.components'. "
        "Install the project and write 'from lumped.components import ...'."
    )

from lumped.components import translation as translation
from lumped.components.cams import *
from lumped.components.characteristic import Stribeck as Stribeck
from lumped.components.compliance import *
from lumped.components.contact import *
from lumped.components.control.controllers import *
from lumped.components.control.fmu import *
from lumped.components.control.linear_blocks import *
from lumped.components.control.sampled import *
from lumped.components.control.sensors import *
from lumped.components.control.sequence import *
from lumped.components.control.signals import *
from lumped.components.couplings.elastic_coupling import *
from lumped.components.couplings.maxwell_coupling import *
from lumped.components.couplings.pendulum import *
from lumped.components.couplings.torsional_dampers import (
    TunedDamper as TunedDamper,
)
from lumped.components.couplings.torsional_dampers import (
    TunedLossDamper as TunedLossDamper,
)
from lumped.components.couplings.torsional_dampers import (
    ViscousDamper as ViscousDamper,
)
from lumped.components.electric.air_gap import *
from lumped.components.electric.circuit import *
from lumped.components.electric.dc_motors import *
from lumped.components.electric.drives import *
from lumped.components.electric.machine_data import *
from lumped.components.electric.motors import *
from lumped.components.electric.network import *
from lumped.components.electric.synchronous import *
from lumped.components.electric.thermal import *
from lumped.components.engines.crank import *
from lumped.components.engines.crankshaft import *
from lumped.components.engines.engine import Cylinder as Cylinder
from lumped.components.engines.propeller import *
from lumped.components.friction import *
from lumped.components.gearing.belts import *
from lumped.components.gearing.gear_mesh import *
from lumped.components.gearing.gears import *
from lumped.components.gearing.lossy_gear import *
from lumped.components.gearing.noncircular import (
    EllipticalGear as EllipticalGear,
)
from lumped.components.gearing.noncircular import (
    NonCircularGear as NonCircularGear,
)
from lumped.components.gearing.planetary_stage import *
from lumped.components.gearing.synchroniser import *
from lumped.components.gravity import *
from lumped.components.impact import *
from lumped.components.imported.opentorsion import *
from lumped.components.imported.ross import *
from lumped.components.inertia import *
from lumped.components.linkages import *
from lumped.components.loads import *
from lumped.components.rolling import *
from lumped.components.shafts.continuous import ContinuousElement as ContinuousElement
from lumped.components.shafts.element import *
from lumped.components.shafts.materials import Material as Material
from lumped.components.shafts.notch import *
from lumped.components.shafts.notches import *
from lumped.components.shafts.sections import *
from lumped.components.shafts.shaft import Section as Section
from lumped.components.shafts.shaft import Shaft as Shaft
from lumped.components.sources import *
from lumped.components.tyre import *
from lumped.components.vehicle import *
from lumped.components.winding import Coil as Coil
from lumped.components.winding import Strip as Strip
from lumped.components.winding import StripPath as StripPath

__all__ = sorted(
    name
    for name, value in vars().items()
    if name == "translation" or not (name.startswith("_") or isinstance(value, types.ModuleType))
)
