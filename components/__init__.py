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
from lumped.components.contact import ElastoBacklash
from lumped.components.friction import BearingFriction, Brake, Clutch, OneWayClutch
from lumped.components.gears import IdealGear, Planetary, RackAndPinion
from lumped.components.impact import Backlash, Coupling, PickUp, Stop
from lumped.components.inertia import Inertia
from lumped.components.loads import (
    EddyCurrentBrake,
    InverseTorque,
    LinearTorque,
    QuadraticTorque,
    SignTorque,
)
from lumped.components.lossy_gear import EfficientGear, LossyGear
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
from lumped.components.thermal import (
    FixedTemperature,
    HeatCapacitor,
    Heated,
    HeatFlow,
    ThermalConductor,
)
from lumped.components.vehicle import Vehicle

__all__ = [
    "AccelerationSensor",
    "AngleSensor",
    "Backlash",
    "BearingFriction",
    "Brake",
    "Clutch",
    "Constant",
    "Coupling",
    "Damper",
    "EddyCurrentBrake",
    "EfficientGear",
    "ElastoBacklash",
    "Expression",
    "Fixed",
    "FixedTemperature",
    "HeatCapacitor",
    "HeatFlow",
    "Heated",
    "IdealGear",
    "Inertia",
    "InverseTorque",
    "LinearTorque",
    "LossyGear",
    "OneWayClutch",
    "PickUp",
    "Planetary",
    "Position",
    "PowerSensor",
    "QuadraticTorque",
    "RackAndPinion",
    "Ramp",
    "RelativeAngleSensor",
    "RelativeSpeedSensor",
    "SignTorque",
    "Sine",
    "Speed",
    "SpeedSensor",
    "Spring",
    "SpringDamper",
    "Step",
    "Stop",
    "Stribeck",
    "Table",
    "ThermalConductor",
    "Torque",
    "TorqueSensor",
    "Vehicle",
    "translation",
]
