"""Ports, connections and signals."""

import lumped as lp
from lumped.components import (
    Constant,
    Damper,
    Fixed,
    IdealGear,
    Inertia,
    Planetary,
    QuasiStaticDCMotor,
    SpeedSensor,
    Spring,
    Torque,
    translation,
)
from lumped.errors import ConnectError, DeclarationError, EquationError, SingularModelError
from tests.helpers.rows import assemble_row, assemble_rows

from . import Table
from .parts import Hoist, Line, Shaft, build

ports = Table("Ports and connections")


@ports(ConnectError, "shaft.flange_b", "not connected")
def port_open():
    """The end of a shaft is not connected."""
    assemble_row(motor=Inertia(J=1.0), shaft=Spring(c=1.0))


@ports(ConnectError, "hoist.line.second.twist.flange_b", "not connected")
def port_open_deep_inside():
    """A port three levels down is not connected."""

    class Half(Shaft):
        """Shaft whose spring has a loose end."""

        def connections(self):
            yield from lp.chain(self.flange_a, self.left, self.twist)
            yield lp.connect(self.right.flange_b, self.flange_b)

    build(hoist=Hoist().with_({"line.second": Half()}))


@ports(SingularModelError, "line.second", "flange_b", "inside")
def composite_port_not_connected_inside():
    """A composite declares a port and connects nothing to it inside."""

    class Stub(Shaft):
        """Shaft that forgets its second port."""

        def connections(self):
            yield from lp.chain(self.flange_a, self.left, self.twist, self.right)

    lp.assemble(Hoist().with_({"line.second": Stub()}))


@ports(ConnectError, "line.first.twist.flange_a", "direct parts")
def port_of_a_grandchild():
    """A model connects to a port of a part of its part."""
    build(
        lambda m: [
            *lp.chain(m.motor, m.line, m.load),
            lp.connect(m.brake.flange_b, m.line.first.twist.flange_a),
            lp.connect(m.brake.flange_a, m.wall.flange),
        ],
        motor=Inertia(J=1.0),
        line=Line(),
        load=Inertia(J=1.0),
        brake=Damper(d=1.0),
        wall=Fixed(),
    )


@ports(ConnectError, "Crane", "IdealGear", "direct parts")
def part_of_another_model():
    """A model is connected to a part that was made outside of it."""
    gear = IdealGear(ratio=2.0)

    class Crane(lp.Component):
        """Connects what is not its own."""

        motor: Inertia = Inertia(J=1.0)

        def connections(self):
            yield from lp.chain(self.motor, gear)

    lp.assemble(Crane())


@ports(ConnectError, "rotational flange", "translational flange", "rack and pinion")
def rotation_on_translation():
    """A shaft is connected to a sliding mass."""
    assemble_row(shaft=Inertia(J=1.0), slide=translation.Mass(m=1.0))


@ports(ConnectError, "motor.p (electrical pin)", "rotor.flange_a (rotational flange)")
def pin_on_a_flange():
    """An electric pin is connected to a shaft."""
    assemble_rows(
        "motor.p rotor.flange_a",
        motor=QuasiStaticDCMotor(k=0.1, R=0.5, J=0.01),
        rotor=Inertia(J=1.0),
    )


@ports(ConnectError, "command.y (signal)", "rotor.flange_a (rotational flange)")
def signal_on_a_flange():
    """A signal is connected to a flange instead of to the input of a source."""
    assemble_rows("command.y rotor.flange_a", command=Constant(k=1.0), rotor=Inertia(J=1.0))


@ports(ConnectError, "sensor.w (signal)", "load.flange_a (rotational flange)")
def signal_of_a_sensor_on_a_shaft():
    """The output of a speed sensor is connected to the next shaft."""
    assemble_rows(
        "motor sensor",
        "sensor.w load.flange_a",
        motor=Inertia(J=1.0),
        sensor=SpeedSensor(),
        load=Inertia(J=1.0),
    )


@ports(ConnectError, "motor (Inertia)", "flange_a, flange_b")
def part_instead_of_port():
    """A part is connected, not one of its ports."""
    build(
        lambda m: [lp.connect(m.motor, m.shaft.flange_a)], motor=Inertia(J=1.0), shaft=Spring(c=1.0)
    )


@ports(ConnectError, "'motor.w'", "ports and signals")
def variable_instead_of_port():
    """A variable of a body is connected to the input of a source."""
    assemble_rows("motor.w drive.tau", motor=Inertia(J=1.0), drive=Torque())


@ports(ConnectError, "Planetary set", "'flange_a'", "sun, carrier, ring")
def planetary_in_a_chain():
    """A chain runs through a planetary gear, which has no flange_a."""
    assemble_row(motor=Inertia(J=1.0), set=Planetary(ratio=2.0), load=Inertia(J=1.0))


@ports(ConnectError, "motor.flange_b", "at least two ports")
def one_end_only():
    """A connection has a single end."""
    build(lambda m: [lp.connect(m.motor.flange_b)], motor=Inertia(J=1.0))


@ports(EquationError, "Drive", "connections", "yield")
def connections_return_ports():
    """connections() yields a pair of ports without connect."""

    class Drive(lp.Component):
        """Pairs instead of connections."""

        motor: Inertia = Inertia(J=1.0)
        shaft: Spring = Spring(c=1.0)

        def connections(self):
            yield self.motor.flange_b, self.shaft.flange_a

    lp.assemble(Drive())


@ports(DeclarationError, "left", "right", "same Inertia object")
def same_object_twice():
    """The same object stands for two parts."""
    wheel = Inertia(J=1.0)
    lp.compose(left=wheel, right=wheel)


@ports(DeclarationError, "wheels[0]", "wheels[1]", "same Inertia object")
def list_multiplied():
    """A list of parts is made by multiplication."""
    lp.compose(wheels=[Inertia(J=1.0)] * 4)


@ports(DeclarationError, "Drive.motor", "parentheses")
def class_instead_of_part():
    """A class stands where a part must, without parentheses."""

    class Drive(lp.Component):
        """Forgotten parentheses."""

        motor: Inertia = Inertia


@ports(DeclarationError, "J of motor (Inertia)", "with_")
def assignment_to_a_part():
    """A parameter of a finished part is assigned."""
    Hoist().motor.J = 2.0


signals = Table("Signals")


def commanded(*rows, **parts):
    """Assemble a motor on a rotor, with parts that are joined in these rows."""
    parts = {"motor": Torque(), "rotor": Inertia(J=1.0), **parts}
    assemble_rows("motor rotor", *rows, **parts)


@signals(ConnectError, "motor.tau", "no source", "tau=")
def input_without_source():
    """A torque source gets no torque."""
    assemble_row(motor=Torque(), rotor=Inertia(J=1.0))


@signals(ConnectError, "motor.tau", "one.y", "two.y", "2 sources")
def input_with_two_sources():
    """Two signals feed one input."""
    commanded("one.y motor.tau", "two.y motor.tau", one=Constant(k=1.0), two=Constant(k=2.0))


@signals(ConnectError, "motor.tau", "connected and given")
def input_connected_and_given():
    """An input is given a number and connected."""
    commanded("one.y motor.tau", motor=Torque(tau=3.0), one=Constant(k=1.0))


@signals(ConnectError, "left.tau", "right.tau", "no source")
def inputs_joined_only():
    """Two inputs are joined, and nothing feeds them."""
    assemble_rows(
        "left rotor right",
        "left.tau right.tau",
        left=Torque(),
        rotor=Inertia(J=1.0),
        right=Torque(),
    )


@signals(ConnectError, "one.y", "two.y", "2 sources")
def two_outputs_joined():
    """Two outputs are connected to each other."""
    assemble_rows("one.y two.y", one=Constant(k=1.0), two=Constant(k=2.0))


@signals(SingularModelError, "control (Control)", "y == 2 * time", "too many")
def output_driven_twice():
    """An output is connected inside and has an equation too."""

    class Control(lp.Component):
        """Constant command with a second law."""

        inner: Constant = Constant(k=1.0)
        y = lp.Output("N.m", "command")

        def connections(self):
            yield lp.connect(self.inner.y, self.y)

        def equations(self):
            yield self.y == 2 * lp.time

    commanded("control.y motor.tau", control=Control())


@signals(SingularModelError, "control (Control)", "its y must be determined")
def output_not_driven():
    """An output of a composite is neither connected inside nor computed."""

    class Control(lp.Component):
        """Forgets its output."""

        inner: Constant = Constant(k=1.0)
        y = lp.Output("N.m", "command")

    commanded("control.y motor.tau", control=Control())


@signals(DeclarationError, "SpeedSensor(w=", "output")
def output_given():
    """The output of a sensor is given a value."""
    SpeedSensor(w=1.0)


@signals(ConnectError, "sensor.flange", "not connected")
def sensor_not_attached():
    """A sensor's signal is used, but its flange is not connected."""
    commanded("sensor.w motor.tau", sensor=SpeedSensor())


@signals(SingularModelError, "one, two only repeat each other")
def signals_in_a_circle():
    """Two signals are each the other: an algebraic loop that determines nothing."""

    class Follow(lp.Component):
        """Repeats its input."""

        u = lp.Input("1", "in")
        y = lp.Output("1", "out")

        def equations(self):
            yield self.y == self.u

    assemble_rows("one.y two.u", "two.y one.u", one=Follow(), two=Follow())
