"""Parts of straight-line motion.

The names are deliberately those of the rotational twins, so import the module:
``from lumped.components import translation``. All positions of a model count along one axis, and
a force is positive along it.
"""

from lumped.components.translation.basic import (
    AccelerationSensor,
    Damper,
    ForceSensor,
    Mass,
    MassWithLength,
    NonlinearSpring,
    PositionSensor,
    PowerSensor,
    RelativePositionSensor,
    RelativeSpeedSensor,
    Rod,
    SpeedSensor,
    Spring,
    SpringDamper,
)
from lumped.components.translation.contact import (
    Backlash,
    Coupling,
    ElastoGap,
    MassWithStops,
    PickUp,
    Stop,
)
from lumped.components.translation.friction import (
    Brake,
    FrictionPair,
    GuideFriction,
    MassWithStopAndFriction,
    SupportFriction,
)
from lumped.components.translation.loads import (
    EddyCurrentBrake,
    InverseForce,
    LinearForce,
    QuadraticForce,
    SignForce,
)
from lumped.components.translation.sources import (
    Acceleration,
    FilteredPosition,
    FilteredSpeed,
    Fixed,
    Force,
    Position,
    RelativeSpeed,
    Speed,
)

__all__ = [
    "Acceleration",
    "AccelerationSensor",
    "Backlash",
    "Brake",
    "Coupling",
    "Damper",
    "EddyCurrentBrake",
    "ElastoGap",
    "FilteredPosition",
    "FilteredSpeed",
    "Fixed",
    "Force",
    "ForceSensor",
    "FrictionPair",
    "GuideFriction",
    "InverseForce",
    "LinearForce",
    "Mass",
    "MassWithLength",
    "MassWithStopAndFriction",
    "MassWithStops",
    "NonlinearSpring",
    "PickUp",
    "Position",
    "PositionSensor",
    "PowerSensor",
    "QuadraticForce",
    "RelativePositionSensor",
    "RelativeSpeed",
    "RelativeSpeedSensor",
    "Rod",
    "SignForce",
    "Speed",
    "SpeedSensor",
    "Spring",
    "SpringDamper",
    "Stop",
    "SupportFriction",
]
