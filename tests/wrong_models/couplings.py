"""Elastic couplings and dampers of torsional vibration."""

import lumped as lp
from lumped.components import (
    CentrifugalPendulum,
    ElasticCoupling,
    Inertia,
    MaxwellCoupling,
    Torque,
    ViscousDamper,
)
from lumped.errors import DeclarationError, EquationError, OptionError, ParameterError, SolverError

from . import Table
from .parts import assemble_row

wrong = Table("Elastic couplings and torsional dampers")

ROWS = ((0, 60e3), (1000, 95e3), (2000, 150e3))


def drive(push=0.0, **given):
    """Two bodies joined by an elastic coupling."""
    return assemble_row(
        motor=Torque(tau=push),
        rotor=Inertia(J=12.0),
        coupling=ElasticCoupling(**{"stiffness": ROWS, "psi": 0.8, "w_loss": 90.0, **given}),
        load=Inertia(J=30.0),
    )


@wrong(EquationError, "coupling (ElasticCoupling)", "increase", "1000 -> 500")
def coupling_rows_not_increasing():
    """The torques of a coupling's rows do not increase."""
    drive(stiffness=((0, 60e3), (1000, 95e3), (500, 75e3)))


@wrong(EquationError, "coupling (ElasticCoupling)", "begins at 500 N.m", "zero")
def coupling_rows_not_from_zero():
    """The rows of a coupling begin at a torque."""
    drive(stiffness=((500, 75e3), (1000, 95e3)))


@wrong(ParameterError, "coupling.psi = -0.8")
def relative_damping_negative():
    """The relative damping of a coupling is negative."""
    drive(psi=-0.8)


@wrong(SolverError, "coupling (ElasticCoupling)", "t = ", "-2000 to 2000 N.m", "extrapolate=True")
def coupling_beyond_its_table():
    """A run twists a coupling beyond its rows."""
    lp.simulate(drive(push=1800.0), until=1.0)


@wrong(SolverError, "coupling (ElasticCoupling)", "390 K", "293 to 353 K")
def coupling_too_warm():
    """A coupling is warmer than its rows of factors say."""
    lp.equilibrium(drive(over_temperature=((293, 1, 1), (353, 0.7, 0.8)), T=390.0))


@wrong(EquationError, "coupling (ElasticCoupling)", "over_amplitude begins at 100 N.m", "zero")
def amplitudes_not_from_zero():
    """The rows of factors over the amplitude begin at an amplitude."""
    drive(over_amplitude=((100, 1, 1), (900, 0.7, 1.2)))


@wrong(SolverError, "amplitude of vibration = ", "0 to 300 N.m", "extrapolate=True")
def amplitude_beyond_the_rows():
    """A coupling vibrates with more than its rows of factors say."""
    lp.vibration.order_response(
        drive(over_amplitude=((0, 1, 1), (300, 0.8, 1.2))),
        speeds=[60.0, 90.0],
        of=["coupling.tau"],
        excitations={"motor.tau": {1: 600.0}},
    )


def maxwell(**given):
    """Two bodies joined by a coupling of Maxwell branches."""
    values = {"stiffness": ROWS, "static": 0.7, "psi": 0.8, "band": (30.0, 300.0), **given}
    return assemble_row(
        rotor=Inertia(J=12.0), coupling=MaxwellCoupling(**values), load=Inertia(J=30.0)
    )


@wrong(DeclarationError, "coupling (MaxwellCoupling)", "psi by 37%", "Take a narrower band")
def branches_too_few():
    """One Maxwell branch is to have a relative damping over a decade of frequencies."""
    maxwell(n_branches=1)


@wrong(DeclarationError, "coupling (MaxwellCoupling)", "band = (0.0, 0.0)", "rad/s")
def band_not_given():
    """The frequencies at which a Maxwell coupling is to have its damping are not given."""
    maxwell(band=(0.0, 0.0))


@wrong(DeclarationError, "coupling (MaxwellCoupling)", "static = 1.2", "below 1")
def static_stiffness_above_the_dynamic_one():
    """The static stiffness of a coupling is above its dynamic one."""
    maxwell(static=1.2)


@wrong(ParameterError, "pendulum.r = 0 m", "greater than 0")
def pendulum_without_length():
    """A pendulum has no length."""
    assemble_row(rotor=Inertia(J=12.0), pendulum=CentrifugalPendulum(m=1.0, R=0.1, r=0.0))


@wrong(OptionError, "mu = 0", "above zero")
def optimum_without_ring():
    """The best damping of a ring without inertia is asked for."""
    ViscousDamper.optimum(0.0)
