"""Friction, losses and contact."""

import lumped as lp
from lumped.components import (
    Backlash,
    BearingFriction,
    Clutch,
    EddyCurrentBrake,
    EfficientGear,
    ElastoBacklash,
    Inertia,
    JournalFriction,
    LossyGear,
    QuadraticTorque,
    Spring,
    Stribeck,
    translation,
)
from lumped.components.friction import Brake
from lumped.errors import (
    ConnectError,
    EquationError,
    ParameterError,
    SingularModelError,
    SolverError,
    StartError,
)
from tests.helpers.rows import assemble_row, assemble_rows

from . import Table
from .parts import build

friction = Table("Friction")


def rubbing(characteristic=((0, 1),), **values):
    """Assemble a shaft in a bearing of this friction."""
    assemble_row(
        motor=Inertia(J=1.0), bearing=BearingFriction(characteristic=characteristic, **values)
    )


@friction(EquationError, "bearing (BearingFriction)", "characteristic", "rows")
def bearing_without_friction():
    """A bearing friction is given no characteristic."""
    rubbing(())


@friction(EquationError, "bearing", "-5", "first row", "speed 0")
def characteristic_of_negative_speeds():
    """A characteristic is measured in both directions."""
    rubbing(((-5, -1.2), (0, 1.0), (5, 1.2)))


@friction(EquationError, "bearing", "must increase", "10 -> 10")
def characteristic_with_a_jump():
    """A characteristic jumps at a sliding speed."""
    rubbing(((0, 1.0), (10, 0.8), (10, 0.5)))


@friction(EquationError, "bearing", "-0.2", "speed 20", "against the motion")
def characteristic_that_drives():
    """A characteristic falls below zero."""
    rubbing(((0, 1.0), (20, -0.2)))


@friction(EquationError, "bearing", "rows of two numbers")
def characteristic_in_columns():
    """A characteristic is given as columns instead of rows."""
    rubbing(((0, 10, 50), (1.0, 0.8, 0.7)))


@friction(EquationError, "bearing", "-3", "standstill", "against the motion")
def characteristic_of_the_wrong_sign():
    """A characteristic is a function with the wrong sign."""
    rubbing(lambda w: -3 - 0.1 * w)


@friction(EquationError, "bearing", "static = 2", "at least coulomb")
def stribeck_curve_upside_down():
    """The friction of a Stribeck curve is smaller at standstill."""
    rubbing(Stribeck(coulomb=3.0, static=2.0, decay=1.0))


@friction(ParameterError, "journal.mu = -0.15", "journal.d = 0 m")
def journal_that_drives():
    """A journal has a negative friction coefficient and no diameter."""
    assemble_row(motor=Inertia(J=1.0), journal=JournalFriction(mu=-0.15, d=0.0, f_n=100.0))


@friction(ParameterError, "bearing.peak = 0.8", "at least 1")
def peak_below_one():
    """Static friction is said to be smaller than kinetic friction."""
    rubbing(peak=0.8)


@friction(ParameterError, "clutch.f_max = -500 N", "at least 0", "clutch.c_geo = -0.1 m")
def clutch_pulled_apart():
    """The normal force and the geometry of a clutch are negative."""
    assemble_row(
        motor=Inertia(J=1.0), clutch=Clutch(f_max=-500.0, c_geo=-0.1, u=1.0), load=Inertia(J=1.0)
    )


@friction(SingularModelError, "clutch", "no inertia", "Inertia or Mass on each side")
def clutch_without_a_body_on_one_side():
    """A clutch, whose friction depends on the speed, drives a shaft without inertia."""
    assemble_row(
        motor=Inertia(J=1.0),
        clutch=Clutch(f_max=10.0, u=1.0, characteristic=((0.0, 0.5), (10.0, 0.4))),
        shaft=Spring(c=100.0),
        load=Inertia(J=1.0),
    )


@friction(ConnectError, "brake.u", "normal force")
def brake_that_nobody_presses():
    """The normal force of a brake is not given."""
    assemble_row(motor=Inertia(J=1.0), brake=Brake(f_max=10.0))


@friction(
    SingularModelError, "first, second hold and slide without inertia", "between each two of them"
)
def two_clutches_in_a_row():
    """Two clutches stand in a row with nothing between them."""
    assemble_row(
        motor=Inertia(J=1.0),
        first=Clutch(f_max=10.0, u=1.0),
        second=Clutch(f_max=10.0, u=1.0),
        load=Inertia(J=1.0),
    )


losses = Table("Gears with loss, and heat")


def hoist(**given):
    """Two bodies joined by a lossy gear."""
    assemble_row(motor=Inertia(J=0.1), gear=LossyGear(ratio=5.0, **given), drum=Inertia(J=2.0))


@losses(EquationError, "gear (LossyGear)", "while b drives", "10 rad/s", "1.2", "at most 1")
def efficiency_above_one():
    """An efficiency of a loss table is greater than one."""
    hoist(losses=[(0.0, 0.9, 0.9, 0.0, 0.0), (10.0, 0.95, 1.2, 0.0, 0.0)])


@losses(EquationError, "gear (LossyGear)", "while a drives", "is -0.1;", "is b")
def undrivable_side():
    """A gear whose side a cannot drive."""
    hoist(losses=[(0.0, -0.1, 0.4, 0.0, 0.0)])


@losses(EquationError, "gear (LossyGear)", "bearing friction", "-0.5 N.m", "zero or greater")
def bearing_torque_negative():
    """A bearing torque is given with the sign of a load."""
    hoist(losses=[(0.0, 0.9, 0.9, -0.5, 0.5)])


@losses(EquationError, "gear (LossyGear)", "increase", "20 -> 10 rad/s")
def loss_table_not_increasing():
    """The speeds of a loss table do not increase."""
    hoist(losses=[(0.0, 0.9, 0.9, 0, 0), (20.0, 0.9, 0.9, 0, 0), (10.0, 0.9, 0.9, 0, 0)])


@losses(EquationError, "gear (LossyGear)", "first speed", "-10 rad/s", "zero")
def loss_table_from_negative_speed():
    """A loss table begins at a negative speed."""
    hoist(losses=[(-10.0, 0.9, 0.9, 0, 0), (10.0, 0.9, 0.9, 0, 0)])


@losses(EquationError, "gear (LossyGear)", "five numbers", "bearing friction")
def loss_table_with_short_rows():
    """A row of a loss table holds an efficiency only."""
    hoist(losses=[(0.0, 0.9)])


@losses(EquationError, "gear (LossyGear)", "'losses.csv'", "five numbers")
def loss_table_from_a_file():
    """The name of a file stands for a loss table."""
    hoist(losses="losses.csv")


@losses(ParameterError, "gear.eta = 1.1", "efficiency", "at most 1")
def efficient_gear_above_one():
    """The efficiency of a gear is greater than one."""
    assemble_row(motor=Inertia(J=0.1), gear=EfficientGear(ratio=5.0, eta=1.1), drum=Inertia(J=2.0))


@losses(SingularModelError, "gear", "no inertia", "Put an Inertia")
def lossy_gear_between_springs():
    """A lossy gear without inertia stands between elastic shafts."""
    assemble_row(
        motor=Inertia(J=0.1),
        left=Spring(c=100.0),
        gear=EfficientGear(ratio=5.0, eta=0.9),
        right=Spring(c=1000.0),
        drum=Inertia(J=2.0),
    )


@losses(ParameterError, "fan.w_nominal = 0 rad/s", "nominal speed", "greater than 0")
def load_with_nominal_speed_zero():
    """A load has no nominal speed."""
    assemble_row(shaft=Inertia(J=0.1), fan=QuadraticTorque(tau_nominal=-5.0, w_nominal=0.0))


@losses(ConnectError, "brake.heat", "not connected")
def eddy_current_brake_without_temperature():
    """An eddy-current brake is given no temperature."""
    assemble_row(shaft=Inertia(J=0.1), brake=EddyCurrentBrake(tau_max=5.0, w_nominal=10.0, e=1.0))


@losses(ConnectError, "brake.heat", "shaft.flange_b", "thermal port", "rotational flange")
def heat_led_into_a_shaft():
    """A thermal port is connected to a flange."""
    assemble_rows(
        "shaft brake",
        "brake.heat shaft.flange_b",
        shaft=Inertia(J=0.1),
        brake=EddyCurrentBrake(tau_max=5.0, w_nominal=10.0, e=1.0),
    )


contact = Table("Contact")


def resting(stop, **start):
    """Assemble a weight above a stop and start it."""
    system = assemble_rows(
        "stop mass",
        "stop weight",
        stop=stop,
        mass=translation.Mass(m=2.0, **start),
        weight=translation.Force(f=-20.0),
    )
    return lp.simulate(system, until=1.0)


@contact(ParameterError, "mesh.b = -0.001 rad", "whole play", "at least 0")
def negative_play():
    """The play of an elastic mesh is negative."""
    assemble_row(pinion=Inertia(J=1.0), mesh=ElastoBacklash(c=1e5, b=-1e-3), wheel=Inertia(J=1.0))


@contact(ParameterError, "mesh.b = 0 rad", "greater than 0")
def rigid_play_of_nothing():
    """Rigid flanks without play between them: that is a rigid joint."""
    assemble_row(pinion=Inertia(J=1.0), mesh=Backlash(b=0.0), wheel=Inertia(J=1.0))


@contact(ParameterError, "stop.restitution = 1.2", "at most 1")
def impact_that_gives_energy():
    """The coefficient of restitution is greater than one."""
    resting(translation.Stop(restitution=1.2), s=1.0, v=0.0)


@contact(StartError, "stop starts 0.2 m inside", "a gap, or none")
def start_inside_a_stop():
    """A body starts beyond its stop."""
    resting(translation.Stop(s_min=0.5), s=0.3, v=0.0)


@contact(StartError, "mesh starts 0.03 rad inside", "a gap, or none")
def start_beyond_a_flank():
    """Two gears start with their teeth inside each other."""
    system = assemble_row(
        pinion=Inertia(J=1.0, phi=0.0, w=0.0), mesh=Backlash(b=0.04), wheel=Inertia(J=1.0, phi=0.05)
    )
    lp.start_point(system)


@contact(StartError, "cylinder starts 0.1 m inside")
def stops_in_the_wrong_order():
    """The lower stop of a body stands above its upper one."""
    lp.start_point(build(cylinder=translation.MassWithStops(m=1.0, s_min=0.1, s_max=0.0)))


@contact(SolverError, "relay", "t = 0.5", "changes of mode")
def relay_without_hysteresis():
    """A relay drives its own input back to the point where it switches."""

    class Relay(lp.Component):
        """Drives x towards zero from both sides: der(x) = -sign(x)."""

        x: lp.Var = lp.var("1", "state", 0.5, state="always")

        def equations(self):
            yield lp.der(self.x) == lp.ops.where(self.x > 0, -1, 1)

    lp.simulate(build(relay=Relay()), until=1.0)
