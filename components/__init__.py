"""Component library.

The rotational parts, the sensors of rotation and the signals stand here; those of straight-line
motion have the same names and stand in `lumped.components.translation`.
"""

if not __name__.startswith("lumped."):
    raise ImportError(
        f"The component library was imported as {__name__!r}; its name is 'lumped.components'. "
        "Install the project and write 'from lumped.components import ...'."
    )

from lumped.components import translation
from lumped.components.characteristic import Stribeck
from lumped.components.compliance import Damper, Spring, SpringDamper
from lumped.components.friction import BearingFriction, Brake, Clutch, OneWayClutch
from lumped.components.gears import IdealGear, RackAndPinion
from lumped.components.inertia import Inertia
from lumped.components.sensors import (
    AccelerationSensor,
    AngleSensor,
    PowerSensor,
    RelativeAngleSensor,
    RelativeSpeedSensor,
    SpeedSensor,
    TorqueSensor,
)
from lumped.components.signals import Constant, Expression, Ramp, Sine, Step, Table
from lumped.components.sources import Fixed, Position, Speed, Torque

__all__ = [
    "AccelerationSensor",
    "AngleSensor",
    "BearingFriction",
    "Brake",
    "Clutch",
    "Constant",
    "Damper",
    "Expression",
    "Fixed",
    "IdealGear",
    "Inertia",
    "OneWayClutch",
    "Position",
    "PowerSensor",
    "RackAndPinion",
    "Ramp",
    "RelativeAngleSensor",
    "RelativeSpeedSensor",
    "Sine",
    "Speed",
    "SpeedSensor",
    "Spring",
    "SpringDamper",
    "Step",
    "Stribeck",
    "Table",
    "Torque",
    "TorqueSensor",
    "translation",
]
