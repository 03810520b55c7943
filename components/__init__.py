"""Component library.

Import the rotational and electrical parts, motors, controllers and signals from here; the parts of
straight-line motion have the names of the rotational ones and are in
`lumped.components.translation`.
"""

if not __name__.startswith("lumped."):
    raise ImportError(
        f"The component library was imported as {__name__!r}; its name is 'lumped.components'. "
        "Install the project and write 'from lumped.components import ...'."
    )

from lumped.components import translation
from lumped.components.belts import Belt
from lumped.components.cams import CamSwitch, HarmonicTorque, PeriodicTorque, PulseTorque
from lumped.components.characteristic import Stribeck
from lumped.components.compliance import (
    Damper,
    LossSpring,
    NonlinearSpring,
    Spring,
    SpringDamper,
)
from lumped.components.contact import ElastoBacklash
from lumped.components.control.controllers import (
    CascadeControl,
    CurrentController,
    FedPI,
    Filter,
    Gain,
    Integrator,
    LimitedPI,
    Limiter,
    LoadShare,
    PController,
    PIController,
    PointToPoint,
    RateLimiter,
    SquareRootController,
    Sum,
)
from lumped.components.control.fmu import from_fmu
from lumped.components.control.linear_blocks import (
    LinearBlock,
    SampledLinearBlock,
    SampledStateSpace,
    SampledTransferFunction,
    StateSpaceBlock,
    TransferFunction,
)
from lumped.components.control.sampled import SampledPI, SampleHold
from lumped.components.control.sensors import (
    AccelerationSensor,
    AngleSensor,
    PowerSensor,
    RelativeAngleSensor,
    RelativeSpeedSensor,
    SpeedSensor,
    TorqueSensor,
)
from lumped.components.control.sequence import (
    Latch,
    Minimum,
    PositionSequencer,
    SpeedProfile,
    Switch,
)
from lumped.components.control.signals import Constant, Expression, Ramp, Sine, Step, Table
from lumped.components.crank import CrankSlider, RotatingMass, StrokeLoad
from lumped.components.crankshaft import Engine
from lumped.components.elastic_coupling import ElasticCoupling
from lumped.components.electric.air_gap import AirGap
from lumped.components.electric.circuit import (
    Capacitor,
    CurrentSensor,
    CurrentSource,
    Ground,
    Inductor,
    Inverter,
    Resistor,
    VariableResistor,
    VoltageSensor,
    VoltageSource,
)
from lumped.components.electric.dc_motors import (
    DCMotor,
    QuasiStaticDCMotor,
    QuasiStaticExcitedDCMotor,
    QuasiStaticSeriesDCMotor,
    SeparatelyExcitedDCMotor,
    SeriesDCMotor,
)
from lumped.components.electric.drives import (
    ConverterDrive,
    FieldOrientedMotor,
    MappedMotor,
    SpeedDrive,
)
from lumped.components.electric.machine_data import PerUnit, standard_parameters
from lumped.components.electric.motors import (
    InductionMotor,
    InverterInductionMotor,
    SquirrelCageMotor,
    SynchronousMotor,
)
from lumped.components.electric.network import (
    CircuitBreaker,
    InfiniteBus,
    ShortCircuit,
    ThreePhaseLine,
    wires,
)
from lumped.components.electric.synchronous import SynchronousMotorStart, WoundFieldMachine
from lumped.components.electric.thermal import (
    FixedTemperature,
    HeatCapacitor,
    Heated,
    HeatFlow,
    ThermalConductor,
)
from lumped.components.engine import Cylinder
from lumped.components.friction import (
    BearingFriction,
    Brake,
    Clutch,
    JournalFriction,
    OneWayClutch,
    SlipCoupling,
)
from lumped.components.gear_mesh import GearMesh
from lumped.components.gears import (
    BevelDifferential,
    BevelGear,
    IdealGear,
    Planetary,
    RackAndPinion,
    SelectableGear,
)
from lumped.components.gravity import SwingingMass, Weight
from lumped.components.impact import Backlash, Coupling, PickUp, Stop
from lumped.components.inertia import Inertia
from lumped.components.linkages import Bar, Eccentric, GuidedRod, PlaneSpring
from lumped.components.loads import (
    EddyCurrentBrake,
    InverseTorque,
    LinearTorque,
    QuadraticTorque,
    SignTorque,
)
from lumped.components.lossy_gear import EfficientGear, LossyGear
from lumped.components.maxwell_coupling import MaxwellBranch, MaxwellCoupling
from lumped.components.noncircular import EllipticalGear, NonCircularGear
from lumped.components.opentorsion import from_opentorsion
from lumped.components.pendulum import CentrifugalPendulum
from lumped.components.planetary_stage import ElasticPlanetary
from lumped.components.propeller import Propeller
from lumped.components.rolling import RollingTorque
from lumped.components.ross import from_ross
from lumped.components.shafts.continuous import ContinuousElement
from lumped.components.shafts.element import ShaftElement
from lumped.components.shafts.materials import Material
from lumped.components.shafts.notch import Notch
from lumped.components.shafts.notches import Fillet, Keyway, RadialHole, SplineEnd
from lumped.components.shafts.sections import Disc, Hollow, Keyed, Solid, Splined, Taper
from lumped.components.shafts.shaft import Section, Shaft
from lumped.components.sources import (
    Acceleration,
    FilteredPosition,
    FilteredSpeed,
    Fixed,
    Position,
    RelativeSpeed,
    Speed,
    Torque,
)
from lumped.components.synchroniser import Synchroniser
from lumped.components.torsional_dampers import TunedDamper, TunedLossDamper, ViscousDamper
from lumped.components.tyre import Tyre
from lumped.components.vehicle import Vehicle
from lumped.components.winding import Coil, Strip, StripPath

__all__ = [
    "Acceleration",
    "AccelerationSensor",
    "AirGap",
    "AngleSensor",
    "Backlash",
    "Bar",
    "BearingFriction",
    "Belt",
    "BevelDifferential",
    "BevelGear",
    "Brake",
    "CamSwitch",
    "Capacitor",
    "CascadeControl",
    "CentrifugalPendulum",
    "CircuitBreaker",
    "Clutch",
    "Coil",
    "Constant",
    "ContinuousElement",
    "ConverterDrive",
    "Coupling",
    "CrankSlider",
    "CurrentController",
    "CurrentSensor",
    "CurrentSource",
    "Cylinder",
    "DCMotor",
    "Damper",
    "Disc",
    "Eccentric",
    "EddyCurrentBrake",
    "EfficientGear",
    "ElasticCoupling",
    "ElasticPlanetary",
    "ElastoBacklash",
    "EllipticalGear",
    "Engine",
    "Expression",
    "FedPI",
    "FieldOrientedMotor",
    "Fillet",
    "Filter",
    "FilteredPosition",
    "FilteredSpeed",
    "Fixed",
    "FixedTemperature",
    "Gain",
    "GearMesh",
    "Ground",
    "GuidedRod",
    "HarmonicTorque",
    "HeatCapacitor",
    "HeatFlow",
    "Heated",
    "Hollow",
    "IdealGear",
    "InductionMotor",
    "Inductor",
    "Inertia",
    "InfiniteBus",
    "Integrator",
    "InverseTorque",
    "Inverter",
    "InverterInductionMotor",
    "JournalFriction",
    "Keyed",
    "Keyway",
    "Latch",
    "LimitedPI",
    "Limiter",
    "LinearBlock",
    "LinearTorque",
    "LoadShare",
    "LossSpring",
    "LossyGear",
    "MappedMotor",
    "Material",
    "MaxwellBranch",
    "MaxwellCoupling",
    "Minimum",
    "NonCircularGear",
    "NonlinearSpring",
    "Notch",
    "OneWayClutch",
    "PController",
    "PIController",
    "PerUnit",
    "PeriodicTorque",
    "PickUp",
    "PlaneSpring",
    "Planetary",
    "PointToPoint",
    "Position",
    "PositionSequencer",
    "PowerSensor",
    "Propeller",
    "PulseTorque",
    "QuadraticTorque",
    "QuasiStaticDCMotor",
    "QuasiStaticExcitedDCMotor",
    "QuasiStaticSeriesDCMotor",
    "RackAndPinion",
    "RadialHole",
    "Ramp",
    "RateLimiter",
    "RelativeAngleSensor",
    "RelativeSpeed",
    "RelativeSpeedSensor",
    "Resistor",
    "RollingTorque",
    "RotatingMass",
    "SampleHold",
    "SampledLinearBlock",
    "SampledPI",
    "SampledStateSpace",
    "SampledTransferFunction",
    "Section",
    "SelectableGear",
    "SeparatelyExcitedDCMotor",
    "SeriesDCMotor",
    "Shaft",
    "ShaftElement",
    "ShortCircuit",
    "SignTorque",
    "Sine",
    "SlipCoupling",
    "Solid",
    "Speed",
    "SpeedDrive",
    "SpeedProfile",
    "SpeedSensor",
    "SplineEnd",
    "Splined",
    "Spring",
    "SpringDamper",
    "SquareRootController",
    "SquirrelCageMotor",
    "StateSpaceBlock",
    "Step",
    "Stop",
    "Stribeck",
    "Strip",
    "StripPath",
    "StrokeLoad",
    "Sum",
    "SwingingMass",
    "Switch",
    "Synchroniser",
    "SynchronousMotor",
    "SynchronousMotorStart",
    "Table",
    "Taper",
    "ThermalConductor",
    "ThreePhaseLine",
    "Torque",
    "TorqueSensor",
    "TransferFunction",
    "TunedDamper",
    "TunedLossDamper",
    "Tyre",
    "VariableResistor",
    "Vehicle",
    "ViscousDamper",
    "VoltageSensor",
    "VoltageSource",
    "Weight",
    "WoundFieldMachine",
    "from_fmu",
    "from_opentorsion",
    "from_ross",
    "standard_parameters",
    "translation",
    "wires",
]
