"""Elastic couplings and dampers of torsional vibration."""

import lumped as lp
from lumped.components import CentrifugalPendulum, ElasticCoupling, Inertia, Torque, ViscousDamper
from lumped.errors import EquationError, OptionError, ParameterError, SolverError

from .parts import build
from .table import Table

wrong = Table("Elastic couplings and torsional dampers")

ROWS = ((0, 60e3), (1000, 95e3), (2000, 150e3))


def drive(push=0.0, **given):
    """Two bodies joined by an elastic coupling."""
    return build(
        lambda m: lp.chain(m.motor, m.rotor, m.coupling, m.load),
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


@wrong(ParameterError, "pendulum.r = 0 m", "greater than 0")
def pendulum_without_length():
    """A pendulum has no length."""
    build(
        lambda m: [lp.connect(m.rotor.flange_b, m.pendulum.flange)],
        rotor=Inertia(J=12.0),
        pendulum=CentrifugalPendulum(m=1.0, R=0.1, r=0.0),
    )


@wrong(OptionError, "mu = 0", "above zero")
def optimum_without_ring():
    """The best damping of a ring without inertia is asked for."""
    ViscousDamper.optimum(0.0)
