"""Signals without a source, or with too many."""

import lumped as lp
from lumped.components import Constant, Inertia, SpeedSensor, Torque
from lumped.errors import ConnectError, DeclarationError, SingularModelError

from . import Table
from .parts import assemble_row, build_rows

wrong = Table("Signals")


def commanded(*rows, **parts):
    """Assemble a motor on a rotor, with parts that are joined in these rows."""
    parts = {"motor": Torque(), "rotor": Inertia(J=1.0), **parts}
    build_rows("motor rotor", *rows, **parts)


@wrong(ConnectError, "motor.tau", "no source", "tau=")
def input_without_source():
    """A torque source gets no torque."""
    assemble_row(motor=Torque(), rotor=Inertia(J=1.0))


@wrong(ConnectError, "motor.tau", "one.y", "two.y", "2 sources")
def input_with_two_sources():
    """Two signals feed one input."""
    commanded("one.y motor.tau", "two.y motor.tau", one=Constant(k=1.0), two=Constant(k=2.0))


@wrong(ConnectError, "motor.tau", "connected and given")
def input_connected_and_given():
    """An input is given a number and connected."""
    commanded("one.y motor.tau", motor=Torque(tau=3.0), one=Constant(k=1.0))


@wrong(ConnectError, "left.tau", "right.tau", "no source")
def inputs_joined_only():
    """Two inputs are joined, and nothing feeds them."""
    build_rows(
        "left rotor right",
        "left.tau right.tau",
        left=Torque(),
        rotor=Inertia(J=1.0),
        right=Torque(),
    )


@wrong(ConnectError, "one.y", "two.y", "2 sources")
def two_outputs_joined():
    """Two outputs are connected to each other."""
    build_rows("one.y two.y", one=Constant(k=1.0), two=Constant(k=2.0))


@wrong(SingularModelError, "control (Control)", "y == 2 * time", "too many")
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


@wrong(SingularModelError, "control (Control)", "its y must be determined")
def output_not_driven():
    """An output of a composite is neither connected inside nor computed."""

    class Control(lp.Component):
        """Forgets its output."""

        inner: Constant = Constant(k=1.0)
        y = lp.Output("N.m", "command")

    commanded("control.y motor.tau", control=Control())


@wrong(DeclarationError, "SpeedSensor(w=", "output")
def output_given():
    """The output of a sensor is given a value."""
    SpeedSensor(w=1.0)


@wrong(ConnectError, "sensor.flange", "not connected")
def sensor_not_attached():
    """A sensor's signal is used, but its flange is not connected."""
    commanded("sensor.w motor.tau", sensor=SpeedSensor())


@wrong(SingularModelError, "one, two only repeat each other")
def signals_in_a_circle():
    """Two signals are each the other: an algebraic loop that determines nothing."""

    class Follow(lp.Component):
        """Repeats its input."""

        u = lp.Input("1", "in")
        y = lp.Output("1", "out")

        def equations(self):
            yield self.y == self.u

    build_rows("one.y two.u", "two.y one.u", one=Follow(), two=Follow())
