"""Gears with loss, loads and heat."""

from lumped.components import (
    EddyCurrentBrake,
    EfficientGear,
    Inertia,
    LossyGear,
    QuadraticTorque,
    Spring,
)
from lumped.errors import ConnectError, EquationError, ParameterError, SingularModelError

from . import Table
from .parts import assemble_row, build_rows

wrong = Table("Gears with loss, and heat")


def hoist(**given):
    """Two bodies joined by a lossy gear."""
    assemble_row(motor=Inertia(J=0.1), gear=LossyGear(ratio=5.0, **given), drum=Inertia(J=2.0))


@wrong(EquationError, "gear (LossyGear)", "while b drives", "10 rad/s", "1.2", "at most 1")
def efficiency_above_one():
    """An efficiency of a loss table is greater than one."""
    hoist(losses=[(0.0, 0.9, 0.9, 0.0, 0.0), (10.0, 0.95, 1.2, 0.0, 0.0)])


@wrong(EquationError, "gear (LossyGear)", "while b drives", "is 0;", "greater than 0")
def efficiency_zero():
    """A gear that locks itself is given the efficiency zero."""
    hoist(losses=[(0.0, 0.4, 0.0, 0.0, 0.0)])


@wrong(EquationError, "gear (LossyGear)", "bearing friction", "-0.5 N.m", "zero or greater")
def bearing_torque_negative():
    """A bearing torque is given with the sign of a load."""
    hoist(losses=[(0.0, 0.9, 0.9, -0.5, 0.5)])


@wrong(EquationError, "gear (LossyGear)", "increase", "20 -> 10 rad/s")
def loss_table_not_increasing():
    """The speeds of a loss table do not increase."""
    hoist(losses=[(0.0, 0.9, 0.9, 0, 0), (20.0, 0.9, 0.9, 0, 0), (10.0, 0.9, 0.9, 0, 0)])


@wrong(EquationError, "gear (LossyGear)", "first speed", "-10 rad/s", "zero")
def loss_table_from_negative_speed():
    """A loss table begins at a negative speed."""
    hoist(losses=[(-10.0, 0.9, 0.9, 0, 0), (10.0, 0.9, 0.9, 0, 0)])


@wrong(EquationError, "gear (LossyGear)", "five numbers", "bearing friction")
def loss_table_with_short_rows():
    """A row of a loss table holds an efficiency only."""
    hoist(losses=[(0.0, 0.9)])


@wrong(EquationError, "gear (LossyGear)", "'losses.csv'", "five numbers")
def loss_table_from_a_file():
    """The name of a file stands for a loss table."""
    hoist(losses="losses.csv")


@wrong(ParameterError, "gear.eta = 1.1", "efficiency", "at most 1")
def efficient_gear_above_one():
    """The efficiency of a gear is greater than one."""
    assemble_row(motor=Inertia(J=0.1), gear=EfficientGear(ratio=5.0, eta=1.1), drum=Inertia(J=2.0))


@wrong(SingularModelError, "gear", "no inertia", "Put an Inertia")
def lossy_gear_between_springs():
    """A lossy gear without inertia stands between elastic shafts."""
    assemble_row(
        motor=Inertia(J=0.1),
        left=Spring(c=100.0),
        gear=EfficientGear(ratio=5.0, eta=0.9),
        right=Spring(c=1000.0),
        drum=Inertia(J=2.0),
    )


@wrong(ParameterError, "fan.w_nominal = 0 rad/s", "nominal speed", "greater than 0")
def load_with_nominal_speed_zero():
    """A load has no nominal speed."""
    assemble_row(shaft=Inertia(J=0.1), fan=QuadraticTorque(tau_nominal=-5.0, w_nominal=0.0))


@wrong(ConnectError, "brake.heat", "not connected")
def eddy_current_brake_without_temperature():
    """An eddy-current brake is given no temperature."""
    assemble_row(shaft=Inertia(J=0.1), brake=EddyCurrentBrake(tau_max=5.0, w_nominal=10.0, e=1.0))


@wrong(ConnectError, "brake.heat", "shaft.flange_b", "thermal port", "rotational flange")
def heat_led_into_a_shaft():
    """A thermal port is connected to a flange."""
    build_rows(
        "shaft brake",
        "brake.heat shaft.flange_b",
        shaft=Inertia(J=0.1),
        brake=EddyCurrentBrake(tau_max=5.0, w_nominal=10.0, e=1.0),
    )
