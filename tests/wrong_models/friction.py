"""Bearings, journals, brakes and clutches."""

from lumped.components import (
    BearingFriction,
    Clutch,
    Inertia,
    JournalFriction,
    Spring,
    Stribeck,
    friction,
)
from lumped.errors import ConnectError, EquationError, ParameterError, SingularModelError

from . import Table
from .parts import assemble_row

wrong = Table("Friction")


def rubbing(characteristic=((0, 1),), **values):
    """Assemble a shaft in a bearing of this friction."""
    assemble_row(
        motor=Inertia(J=1.0), bearing=BearingFriction(characteristic=characteristic, **values)
    )


@wrong(EquationError, "bearing (BearingFriction)", "characteristic", "rows")
def bearing_without_friction():
    """A bearing friction is given no characteristic."""
    rubbing(())


@wrong(EquationError, "bearing", "-5", "first row", "speed 0")
def characteristic_of_negative_speeds():
    """A characteristic is measured in both directions."""
    rubbing(((-5, -1.2), (0, 1.0), (5, 1.2)))


@wrong(EquationError, "bearing", "must increase", "10 -> 10")
def characteristic_with_a_jump():
    """A characteristic jumps at a sliding speed."""
    rubbing(((0, 1.0), (10, 0.8), (10, 0.5)))


@wrong(EquationError, "bearing", "-0.2", "speed 20", "against the motion")
def characteristic_that_drives():
    """A characteristic falls below zero."""
    rubbing(((0, 1.0), (20, -0.2)))


@wrong(EquationError, "bearing", "rows of two numbers")
def characteristic_in_columns():
    """A characteristic is given as columns instead of rows."""
    rubbing(((0, 10, 50), (1.0, 0.8, 0.7)))


@wrong(EquationError, "bearing", "-3", "standstill", "against the motion")
def characteristic_of_the_wrong_sign():
    """A characteristic is a function with the wrong sign."""
    rubbing(lambda w: -3 - 0.1 * w)


@wrong(EquationError, "bearing", "static = 2", "at least coulomb")
def stribeck_curve_upside_down():
    """The friction of a Stribeck curve is smaller at standstill."""
    rubbing(Stribeck(coulomb=3.0, static=2.0, decay=1.0))


@wrong(ParameterError, "journal.mu = -0.15", "journal.d = 0 m")
def journal_that_drives():
    """A journal has a negative friction coefficient and no diameter."""
    assemble_row(motor=Inertia(J=1.0), journal=JournalFriction(mu=-0.15, d=0.0, f_n=100.0))


@wrong(ParameterError, "bearing.peak = 0.8", "at least 1")
def peak_below_one():
    """Static friction is said to be smaller than kinetic friction."""
    rubbing(peak=0.8)


@wrong(ParameterError, "clutch.f_max = -500 N", "at least 0", "clutch.c_geo = -0.1 m")
def clutch_pulled_apart():
    """The normal force and the geometry of a clutch are negative."""
    assemble_row(
        motor=Inertia(J=1.0), clutch=Clutch(f_max=-500.0, c_geo=-0.1, u=1.0), load=Inertia(J=1.0)
    )


@wrong(SingularModelError, "clutch", "no inertia", "Inertia or Mass on each side")
def clutch_without_a_body_on_one_side():
    """A clutch drives a shaft without inertia."""
    assemble_row(
        motor=Inertia(J=1.0),
        clutch=Clutch(f_max=10.0, u=1.0),
        shaft=Spring(c=100.0),
        load=Inertia(J=1.0),
    )


@wrong(ConnectError, "brake.u", "normal force")
def brake_that_nobody_presses():
    """The normal force of a brake is not given."""
    assemble_row(motor=Inertia(J=1.0), brake=friction.Brake(f_max=10.0))


@wrong(
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
