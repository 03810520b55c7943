"""Drives whose schematics are examined: chains, branches, loops, composites, circuits, signals."""

import re
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

    A class stands for a part of this class without values; its inputs are 0 unless joined. A part
    of the library has its class where it is first named, ``motor:Inertia``, or, where parts are
    declared in another order, in a list of all, ``"motor Inertia, shaft Spring"``.
    """
    named = [pair.split() for pair in library.split(",") if pair]
    named += re.findall(r"(\w+):((?:\w+\.)?[A-Z]\w*)", joints)
    joints = re.sub(r":(\w+\.)?[A-Z]\w*", "", joints)
    parts |= {name: attrgetter(kind)(lib) for name, kind in named}
    ends = {name.strip() for line in joints.splitlines() for name in line.split("=")}

    def made(name: str, cls: type[lp.Component]) -> lp.Component:
        quantities = cls._quantities.items()
        inputs = [key for key, quantity in quantities if isinstance(quantity, Input)]
        return cls(**{key: 0.0 for key in inputs if f"{name}.{key}" not in ends})

    def connections(model: lp.Component):
        for line in joints.strip().splitlines():
            ends = [attrgetter(name.strip())(model) for name in re.split("[>=]", line)]
            yield from lp.chain(*ends) if ">" in line else [lp.connect(*ends)]

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
        "drive:Torque > rotor:Inertia > shaft:SpringDamper > table:Inertia > load:LinearTorque"
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
        """pusher:translation.Force > wagon:translation.Mass > buffer:translation.SpringDamper
        buffer > stone:translation.Mass > bumper:translation.Fixed"""
    ),
    "four bar": drive("crank > linkage > rocker", crank=Inertia, linkage=FourBar, rocker=Inertia),
    "long names": drive(
        """low_pressure_turbine:Inertia > intermediate_shaft:SpringDamper
        intermediate_shaft > main_reduction_gear:IdealGear > propeller_shaft:SpringDamper
        propeller_shaft > ship_propeller:Inertia"""
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
        """motor:Inertia > stage:Planetary.sun
        stage.carrier > shaft:SpringDamper > load:Inertia > work:LinearTorque
        brake:Brake.flange_b = stage.ring"""
    ),
    "two planetary stages": drive(
        """turbine:Inertia > first:Planetary.sun
        first.carrier > shaft:SpringDamper > second:Planetary.sun
        second.carrier > generator:Inertia
        first.ring = housing:Inertia.flange_a = second.ring
        housing > feet:SpringDamper > floor:Fixed"""
    ),
    "power split": drive(
        """engine:Torque > damper:SpringDamper > split:Planetary.carrier
        split.sun > generator:ConverterDrive
        split.ring > final:IdealGear > car:Vehicle.wheel
        motor:ConverterDrive.flange = split.ring"""
    ),
    "branches": drive(
        """motor:InductionMotor > pinion:Inertia
        pinion.flange_b = upper:IdealGear.flange_a = lower:IdealGear.flange_a
        upper > upper_shaft:SpringDamper > upper_roll:Inertia
        lower > lower_shaft:SpringDamper > lower_roll:Inertia"""
    ),
    "differential": drive(
        """motor:InductionMotor > propeller_shaft:SpringDamper > axle:BevelDifferential
        axle.left > left_shaft:SpringDamper > left_wheel:Inertia > left_load:LinearTorque
        axle.right > right_shaft:SpringDamper > right_wheel:Inertia > right_load:LinearTorque"""
    ),
    "wind turbine": drive(
        """wind:Torque > hub:Inertia > main_shaft:SpringDamper > stage:ElasticPlanetary.carrier
        stage.sun > high_speed:Inertia > coupling:SpringDamper > rotor:Inertia
        rotor > generator:ConverterDrive
        ring:SpringDamper.flange_b = stage.ring
        ring.flange_a = tower:Fixed.flange
        brake:Brake.flange_a = high_speed.flange_b
        speed:SpeedSensor.flange = rotor.flange_b
        speed.w = control:LimitedPI.measured
        control.y = generator.wanted"""
    ),
    "car": drive(
        """engine:Torque > flywheel:Inertia > clutch:Clutch > input:Inertia
        input > first:SelectableGear > output:Inertia > axle:BevelDifferential
        axle.left > left_wheel:SpringDamper > car:Vehicle.wheel
        axle.right > right_wheel:SpringDamper > car.wheel
        input > second:SelectableGear > output"""
    ),
    "dampers": drive(
        """engine:Torque > crank:Inertia > shaft:SpringDamper > flywheel:Inertia
        flywheel > load:LinearTorque
        viscous:ViscousDamper.flange = crank.flange_a
        tuned:TunedDamper.flange = crank.flange_a
        pendulum:CentrifugalPendulum.flange = flywheel.flange_a"""
    ),
    "springs side by side": drive(
        """motor:Inertia > spring:Spring > rotor:Inertia > load:LinearTorque
        motor > damper:Damper > rotor
        motor > play:ElastoBacklash > rotor"""
    ),
    "star": drive(
        "\n".join(f"hub > shaft_{i} > disc_{i}" for i in range(6)),
        hub=Inertia,
        **{f"shaft_{i}": SpringDamper for i in range(6)},
        **{f"disc_{i}": Inertia for i in range(6)},
    ),
    "press": drive(
        """motor:InductionMotor > belt:IdealGear > flywheel:Inertia > clutch:Clutch
        clutch > shaft:Inertia > gear:EllipticalGear > crank:CrankSlider.flange
        brake:Brake.flange_a = shaft.flange_b
        crank.slider = ram:translation.Mass.flange_a = die:StrokeLoad.flange"""
    ),
    "linkage press": drive(
        """motor:Torque > flywheel:Inertia > crank:Eccentric.flange
        x:translation.Fixed.flange = crank.hub_x
        y:translation.Fixed.flange = crank.hub_y
        crank.pin_x = rod:GuidedRod.pin_x
        crank.pin_y = rod.pin_y
        rod.foot_y = ram:translation.Mass.flange_a
        ram.flange_b = force:translation.Force.flange"""
    ),
    "bar on springs": drive(
        """bar:Bar.a_x = left:PlaneSpring.a_x
        bar.a_y = left.a_y
        bar.b_x = right:PlaneSpring.a_x
        bar.b_y = right.a_y
        left.b_x = left_x:translation.Fixed.flange
        left.b_y = left_y:translation.Fixed.flange
        right.b_x = right_x:translation.Fixed.flange
        right.b_y = right_y:translation.Fixed.flange
        turning:Inertia.flange_a = bar.flange"""
    ),
    "feed axis": drive(
        """motor:ConverterDrive > coupling:SpringDamper > screw:Inertia > rack:RackAndPinion
        rack > slide:translation.MassWithStops > force:translation.Force
        rack.support = bed:translation.Mass.flange_a
        bed > feet:translation.SpringDamper > floor:translation.Fixed
        position:translation.PositionSensor.flange = slide.flange_b"""
    ),
    "housing on feet": drive(
        """motor:InductionMotor > gear:IdealGear > shaft:SpringDamper > pump:QuadraticTorque
        motor.support = gear.support = frame:Inertia.flange_a
        frame > feet:SpringDamper > floor:Fixed"""
    ),
}
"""Chains with branches, loops and second chains."""

CONTROLLED = {
    "speed control": drive(
        """motor:Torque > rotor:Inertia > shaft:SpringDamper > load:LinearTorque
        speed:SpeedSensor.flange = rotor.flange_b
        speed.w = control:LimitedPI.measured
        wanted:Step.y = control.wanted
        control.y = motor.tau"""
    ),
    "position control": drive(
        """motor:FieldOrientedMotor > coupling:SpringDamper > table:Inertia
        angle:AngleSensor.flange = table.flange_b
        speed:SpeedSensor.flange = table.flange_b
        path:PointToPoint.s = position:PController.wanted
        angle.phi = position.measured
        position.y = sum:Sum.a
        path.v = sum.b
        sum.y = control:PIController.wanted
        speed.w = control.measured
        control.y = limit:Limiter.u
        limit.y = motor.wanted"""
    ),
    "DC motor": drive(
        """motor:DCMotor > rotor:Inertia > load:LinearTorque
        source:VoltageSource.p = inductor:Inductor.p
        inductor.n = meter:CurrentSensor.p
        meter.n = motor.p
        source.n = motor.n = earth:Ground.pin
        meter.i = current:PIController.measured
        wanted:Constant.y = current.wanted
        current.y = source.v"""
    ),
    "separate field": drive(
        """motor:SeparatelyExcitedDCMotor > rotor:Inertia > shaft:SpringDamper > load:LinearTorque
        source:VoltageSource.p = motor.p
        source.n = motor.n = earth:Ground.pin = field:VoltageSource.n = motor.field_n
        field.p = motor.field_p"""
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
