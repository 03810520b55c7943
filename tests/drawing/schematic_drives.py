"""Drives whose schematics are examined: chains, branches, loops, composites, circuits, signals."""

from operator import attrgetter

from genset import genset
from linkages import FourBar
from random_drives import RandomDrive
from rows import in_turn

import lumped as lp
from lumped import components as lib
from lumped.components import IdealGear, Inertia, SpringDamper
from lumped.language.quantity import Input
from lumped.models import MACHINES, machine


def drive(joints: str, library: str = "", **parts: type[lp.Component]) -> lp.Component:
    """Parts and what is joined, a line each: ``a > b > c`` for chains, ``a.p = b.p`` for ports.

    A class stands for a part of this class without values; its inputs are 0 unless joined. Parts of
    the library have their classes by name, as ``"motor Inertia, shaft Spring"``.
    """
    named = dict(pair.split() for pair in library.split(",") if pair)
    parts |= {name: attrgetter(kind)(lib) for name, kind in named.items()}
    ends = {name.strip() for line in joints.splitlines() for name in line.split("=")}

    def made(name: str, cls: type[lp.Component]) -> lp.Component:
        quantities = cls._quantities.items()
        inputs = [key for key, quantity in quantities if isinstance(quantity, Input)]
        return cls(**{key: 0.0 for key in inputs if f"{name}.{key}" not in ends})

    def found(model: lp.Component, name: str) -> object:
        for step in name.strip().split("."):
            model = getattr(model, step)
        return model

    def connections(model: lp.Component):
        for line in joints.strip().splitlines():
            if ">" in line:
                yield from lp.chain(*(found(model, name) for name in line.split(">")))
            else:
                yield lp.connect(*(found(model, name) for name in line.split("=")))

    return lp.compose(
        **{name: made(name, cls) for name, cls in parts.items()}, connections=connections
    )


class Gearbox(lp.Component):
    """Two stages of gears in a housing."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    pinion: Inertia = Inertia()
    first: IdealGear = IdealGear()
    shaft: SpringDamper = SpringDamper()
    wheel: Inertia = Inertia()

    def connections(self):
        yield lp.connect(self.flange_a, self.pinion.flange_a)
        yield from lp.chain(self.pinion, self.first, self.shaft, self.wheel)
        yield lp.connect(self.wheel.flange_b, self.flange_b)


def long_chain(count: int) -> lp.Component:
    """So many bodies with shafts between them."""
    return in_turn([Inertia() for _ in range(count)], [SpringDamper() for _ in range(count - 1)])


CHAINS = {
    "chain": drive(
        "drive > rotor > shaft > table > load",
        "drive Torque, rotor Inertia, shaft SpringDamper, table Inertia, load LinearTorque",
    ),
    "chain declared from the load": drive(
        "drive > rotor > shaft > gear > table > load",
        "load QuadraticTorque, table Inertia, gear IdealGear, shaft SpringDamper, rotor Inertia, "
        "drive Torque",
    ),
    "chain joined from its end": drive(
        """table.flange_b = load.flange
        shaft.flange_b = table.flange_a
        gear.flange_b = shaft.flange_a
        motor.flange = gear.flange_a""",
        "motor InductionMotor, gear IdealGear, shaft SpringDamper, table Inertia, "
        "load LinearTorque",
    ),
    "straight motion": drive(
        "pusher > wagon > buffer > stone > bumper",
        "pusher translation.Force, wagon translation.Mass, buffer translation.SpringDamper, "
        "stone translation.Mass, bumper translation.Fixed",
    ),
    "four bar": drive("crank > linkage > rocker", crank=Inertia, linkage=FourBar, rocker=Inertia),
    "long names": drive(
        "low_pressure_turbine > intermediate_shaft > main_reduction_gear > propeller_shaft "
        "> ship_propeller",
        "low_pressure_turbine Inertia, intermediate_shaft SpringDamper, "
        "main_reduction_gear IdealGear, propeller_shaft SpringDamper, ship_propeller Inertia",
    ),
    "gearboxes in line": drive(
        "motor > box > coupling > second > load",
        motor=lib.InductionMotor,
        box=Gearbox,
        coupling=SpringDamper,
        second=Gearbox,
        load=lib.QuadraticTorque,
    ),
}
"""Each part joined to the next, flange b to flange a."""

BRANCHED = {
    "folded chain": long_chain(18),
    "genset": genset().structure.tree.model,
    "planetary": drive(
        """motor > stage.sun
        stage.carrier > shaft > load > work
        brake.flange_b = stage.ring""",
        "motor Inertia, stage Planetary, brake Brake, shaft SpringDamper, load Inertia, "
        "work LinearTorque",
    ),
    "two planetary stages": drive(
        """turbine > first.sun
        first.carrier > shaft > second.sun
        second.carrier > generator
        first.ring = housing.flange_a = second.ring
        housing > feet > floor""",
        "turbine Inertia, first Planetary, shaft SpringDamper, second Planetary, "
        "generator Inertia, housing Inertia, feet SpringDamper, floor Fixed",
    ),
    "power split": drive(
        """engine > damper > split.carrier
        split.sun > generator
        split.ring > final > car.wheel
        motor.flange = split.ring""",
        "engine Torque, damper SpringDamper, split Planetary, generator ConverterDrive, "
        "motor ConverterDrive, final IdealGear, car Vehicle",
    ),
    "branches": drive(
        """motor > pinion
        pinion.flange_b = upper.flange_a = lower.flange_a
        upper > upper_shaft > upper_roll
        lower > lower_shaft > lower_roll""",
        "motor InductionMotor, pinion Inertia, upper IdealGear, upper_shaft SpringDamper, "
        "upper_roll Inertia, lower IdealGear, lower_shaft SpringDamper, lower_roll Inertia",
    ),
    "differential": drive(
        """motor > propeller_shaft > axle
        axle.left > left_shaft > left_wheel > left_load
        axle.right > right_shaft > right_wheel > right_load""",
        "motor InductionMotor, propeller_shaft SpringDamper, axle BevelDifferential, "
        "left_shaft SpringDamper, left_wheel Inertia, left_load LinearTorque, "
        "right_shaft SpringDamper, right_wheel Inertia, right_load LinearTorque",
    ),
    "wind turbine": drive(
        """wind > hub > main_shaft > stage.carrier
        stage.sun > high_speed > coupling > rotor > generator
        ring.flange_b = stage.ring
        ring.flange_a = tower.flange
        brake.flange_a = high_speed.flange_b
        speed.flange = rotor.flange_b
        speed.w = control.measured
        control.y = generator.wanted""",
        "wind Torque, hub Inertia, main_shaft SpringDamper, stage ElasticPlanetary, "
        "ring SpringDamper, tower Fixed, high_speed Inertia, brake Brake, coupling SpringDamper, "
        "rotor Inertia, generator ConverterDrive, speed SpeedSensor, control LimitedPI",
    ),
    "car": drive(
        """engine > flywheel > clutch > input > first > output > axle
        axle.left > left_wheel > car.wheel
        axle.right > right_wheel > car.wheel
        input > second > output""",
        "engine Torque, flywheel Inertia, clutch Clutch, input Inertia, first SelectableGear, "
        "second SelectableGear, output Inertia, axle BevelDifferential, left_wheel SpringDamper, "
        "right_wheel SpringDamper, car Vehicle",
    ),
    "dampers": drive(
        """engine > crank > shaft > flywheel > load
        viscous.flange = crank.flange_a
        tuned.flange = crank.flange_a
        pendulum.flange = flywheel.flange_a""",
        "engine Torque, crank Inertia, shaft SpringDamper, flywheel Inertia, load LinearTorque, "
        "viscous ViscousDamper, tuned TunedDamper, pendulum CentrifugalPendulum",
    ),
    "springs side by side": drive(
        """motor > spring > rotor > load
        motor > damper > rotor
        motor > play > rotor""",
        "motor Inertia, spring Spring, damper Damper, play ElastoBacklash, rotor Inertia, "
        "load LinearTorque",
    ),
    "star": drive(
        "\n".join(f"hub > shaft_{i} > disc_{i}" for i in range(6)),
        hub=Inertia,
        **{f"shaft_{i}": SpringDamper for i in range(6)},
        **{f"disc_{i}": Inertia for i in range(6)},
    ),
    "press": drive(
        """motor > belt > flywheel > clutch > shaft > gear > crank.flange
        brake.flange_a = shaft.flange_b
        crank.slider = ram.flange_a = die.flange""",
        "motor InductionMotor, belt IdealGear, flywheel Inertia, clutch Clutch, brake Brake, "
        "shaft Inertia, gear EllipticalGear, crank CrankSlider, ram translation.Mass, "
        "die StrokeLoad",
    ),
    "linkage press": drive(
        """motor > flywheel > crank.flange
        x.flange = crank.hub_x
        y.flange = crank.hub_y
        crank.pin_x = rod.pin_x
        crank.pin_y = rod.pin_y
        rod.foot_y = ram.flange_a
        ram.flange_b = force.flange""",
        "motor Torque, flywheel Inertia, crank Eccentric, x translation.Fixed, "
        "y translation.Fixed, rod GuidedRod, ram translation.Mass, force translation.Force",
    ),
    "bar on springs": drive(
        """bar.a_x = left.a_x
        bar.a_y = left.a_y
        bar.b_x = right.a_x
        bar.b_y = right.a_y
        left.b_x = left_x.flange
        left.b_y = left_y.flange
        right.b_x = right_x.flange
        right.b_y = right_y.flange
        turning.flange_a = bar.flange""",
        "bar Bar, turning Inertia, left PlaneSpring, right PlaneSpring, left_x translation.Fixed, "
        "left_y translation.Fixed, right_x translation.Fixed, right_y translation.Fixed",
    ),
    "feed axis": drive(
        """motor > coupling > screw > rack > slide > force
        rack.support = bed.flange_a
        bed > feet > floor
        position.flange = slide.flange_b""",
        "motor ConverterDrive, coupling SpringDamper, screw Inertia, rack RackAndPinion, "
        "slide translation.MassWithStops, force translation.Force, bed translation.Mass, "
        "feet translation.SpringDamper, floor translation.Fixed, "
        "position translation.PositionSensor",
    ),
    "housing on feet": drive(
        """motor > gear > shaft > pump
        motor.support = gear.support = frame.flange_a
        frame > feet > floor""",
        "motor InductionMotor, gear IdealGear, shaft SpringDamper, pump QuadraticTorque, "
        "frame Inertia, feet SpringDamper, floor Fixed",
    ),
}
"""Chains with branches, loops and second chains."""

CONTROLLED = {
    "speed control": drive(
        """motor > rotor > shaft > load
        speed.flange = rotor.flange_b
        speed.w = control.measured
        wanted.y = control.wanted
        control.y = motor.tau""",
        "wanted Step, control LimitedPI, motor Torque, rotor Inertia, speed SpeedSensor, "
        "shaft SpringDamper, load LinearTorque",
    ),
    "position control": drive(
        """motor > coupling > table
        angle.flange = table.flange_b
        speed.flange = table.flange_b
        path.s = position.wanted
        angle.phi = position.measured
        position.y = sum.a
        path.v = sum.b
        sum.y = control.wanted
        speed.w = control.measured
        control.y = limit.u
        limit.y = motor.wanted""",
        "path PointToPoint, position PController, sum Sum, control PIController, limit Limiter, "
        "motor FieldOrientedMotor, coupling SpringDamper, table Inertia, angle AngleSensor, "
        "speed SpeedSensor",
    ),
    "DC motor": drive(
        """motor > rotor > load
        source.p = inductor.p
        inductor.n = meter.p
        meter.n = motor.p
        source.n = motor.n = earth.pin
        meter.i = current.measured
        wanted.y = current.wanted
        current.y = source.v""",
        "source VoltageSource, inductor Inductor, meter CurrentSensor, earth Ground, "
        "motor DCMotor, rotor Inertia, load LinearTorque, wanted Constant, current PIController",
    ),
    "separate field": drive(
        """motor > rotor > shaft > load
        source.p = motor.p
        source.n = motor.n = earth.pin = field.n = motor.field_n
        field.p = motor.field_p""",
        "source VoltageSource, field VoltageSource, earth Ground, motor SeparatelyExcitedDCMotor, "
        "rotor Inertia, shaft SpringDamper, load LinearTorque",
    ),
    "generator on a network": drive(
        "turbine > shaft > generator\n"
        + "\n".join(
            f"""generator.{p} = step_up.{p}_1
            step_up.{p}_2 = breaker.{p}_1 = short.{p}
            breaker.{p}_2 = line.{p}_1
            line.{p}_2 = network.{p}"""
            for p in "abc"
        ),
        "turbine Torque, shaft SpringDamper, generator WoundFieldMachine, step_up ThreePhaseLine, "
        "short ShortCircuit, breaker CircuitBreaker, line ThreePhaseLine, network InfiniteBus",
    ),
}
"""Drives with circuits and signals."""

DRIVES = {
    **CHAINS,
    **BRANCHED,
    **CONTROLLED,
    **{name: machine(name).model() for name in MACHINES},
    **{f"random drive {seed}": RandomDrive(seed).model() for seed in (1, 4, 7, 11)},
}
