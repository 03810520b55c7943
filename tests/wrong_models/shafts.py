"""Shafts and couplings."""

import lumped as lp
from lumped.components import (
    CentrifugalPendulum,
    ElasticCoupling,
    Fillet,
    Hollow,
    Inertia,
    Keyed,
    Keyway,
    MaxwellCoupling,
    RadialHole,
    Shaft,
    Solid,
    Splined,
    SplineEnd,
    Taper,
    Torque,
    ViscousDamper,
)
from lumped.errors import (
    DeclarationError,
    EquationError,
    OptionError,
    ParameterError,
    SolverError,
    UnknownNameError,
)
from tests.helpers.rows import assemble_row

from . import Table

shafts = Table("Shafts")


def shaft(*sections, **given):
    lp.assemble(lp.compose(shaft=Shaft(sections=sections, **given)))


@shafts(ParameterError, "d = 0.1 m (outside diameter)", "bore = 0.12 m (diameter of the bore)")
def bore_larger_than_the_shaft():
    """The bore of a shaft is larger than its diameter."""
    shaft(Hollow(d=0.1, bore=0.12, L=0.5))


@shafts(ParameterError, "d = 0.1 m (diameter)", "bore + 2 * t = 0.11 m")
def keyway_deeper_than_the_wall():
    """A keyway is deeper than the wall of a hollow shaft."""
    shaft(Keyed(d=0.1, bore=0.07, t=0.02, L=0.5))


@shafts(ParameterError, "d = 0.08 m (outside diameter)", "d_root = 0.09 m")
def spline_with_root_outside():
    """The root of a spline is larger than its outside."""
    shaft(Splined(d=0.08, d_root=0.09, L=0.1))


@shafts(ParameterError, "sections[0].L = 0 m (length", "greater than")
def taper_without_length():
    """A cone has no length."""
    shaft(Taper(d_a=0.1, d_b=0.08, L=0.0))


@shafts(ParameterError, "sections[1].L = 0.02 m (length", "max(0, -x_a - x_b)")
def flange_shorter_than_its_steps():
    """A flange is so short that the steps on both sides would take more than its length."""
    shaft(Solid(d=0.2, L=0.5), Solid(d=0.5, L=0.02), Solid(d=0.2, L=0.5))


@shafts(UnknownNameError, "sections[0] (Solid): material = 'stel'", "Nearest: steel")
def unknown_material():
    """The name of a material is misspelt."""
    shaft(Solid(d=0.1, L=0.5, material="stel"))


@shafts(UnknownNameError, "step = 'compute' is no rule", "Nearest: computed")
def unknown_rule_of_steps():
    """The name of a rule for steps is misspelt."""
    shaft(Solid(d=0.1, L=0.5), Solid(d=0.2, L=0.5), step="compute")


@shafts(DeclarationError, "shaft (Shaft): f_max = -50.0 Hz")
def negative_frequency_limit():
    """The highest frequency of interest is negative."""
    shaft(Solid(d=0.1, L=0.5), f_max=-50.0)


@shafts(ParameterError, "r = 0.001 m (radius of the fillet", "t/r up to 4", "(D - d) / 8")
def fillet_too_sharp():
    """A fillet is sharper than its fit was made for."""
    shaft(Solid(d=0.1, L=0.5), Fillet(r=0.001), Solid(d=0.15, L=0.5))


@shafts(ParameterError, "d = 0.1 m (diameter of the shaft, ten times that of the hole or more)")
def hole_too_large():
    """A radial hole is too large for the formula of a small one."""
    shaft(Solid(d=0.1, L=0.5), RadialHole(d_hole=0.03), Solid(d=0.1, L=0.5))


@shafts(
    ParameterError, "d (diameter of the shaft; the fit holds for r/d up to 0.07, m) has no value"
)
def keyway_without_a_shaft():
    """A keyway stands outside of a shaft and has no diameter."""
    lp.assemble(lp.compose(keyway=Keyway()))


@shafts(UnknownNameError, "sections[1] (SplineEnd): profile = 'involut'", "Nearest: involute")
def unknown_profile_of_a_spline():
    """The name of a profile is misspelt."""
    end = SplineEnd(R_m=900e6, profile="involut")
    shaft(Solid(d=0.06, L=0.5), end, Splined(d=0.05, d_root=0.045, L=0.1))


@shafts(ParameterError, "sections[1].R_m (tensile strength of the part at its diameter, Pa) has no")
def spline_of_unknown_strength():
    """The strength of a splined shaft is not given."""
    shaft(Solid(d=0.06, L=0.5), SplineEnd(), Splined(d=0.05, d_root=0.045, L=0.1))


@shafts(DeclarationError, "sections[1] (Inertia) is no section of a shaft and no notch")
def body_among_the_sections():
    """A body stands among the sections of a shaft."""
    shaft(Solid(d=0.1, L=0.5), Inertia(J=1.0))


@shafts(DeclarationError, "shaft (Shaft): no sections")
def shaft_without_sections():
    """A shaft is given no sections."""
    lp.assemble(lp.compose(shaft=Shaft()))


couplings = Table("Elastic couplings and torsional dampers")

ROWS = ((0, 60e3), (1000, 95e3), (2000, 150e3))


def drive(push=0.0, **given):
    """Two bodies joined by an elastic coupling."""
    return assemble_row(
        motor=Torque(tau=push),
        rotor=Inertia(J=12.0),
        coupling=ElasticCoupling(**{"stiffness": ROWS, "psi": 0.8, "w_loss": 90.0, **given}),
        load=Inertia(J=30.0),
    )


@couplings(EquationError, "coupling (ElasticCoupling)", "increase", "1000 -> 500")
def coupling_rows_not_increasing():
    """The torques of a coupling's rows do not increase."""
    drive(stiffness=((0, 60e3), (1000, 95e3), (500, 75e3)))


@couplings(EquationError, "coupling (ElasticCoupling)", "begins at 500 N.m", "zero")
def coupling_rows_not_from_zero():
    """The rows of a coupling begin at a torque."""
    drive(stiffness=((500, 75e3), (1000, 95e3)))


@couplings(ParameterError, "coupling.psi = -0.8")
def relative_damping_negative():
    """The relative damping of a coupling is negative."""
    drive(psi=-0.8)


@couplings(
    SolverError, "coupling (ElasticCoupling)", "t = ", "-2000 to 2000 N.m", "extrapolate=True"
)
def coupling_beyond_its_table():
    """A run twists a coupling beyond its rows."""
    lp.simulate(drive(push=1800.0), until=1.0)


@couplings(SolverError, "coupling (ElasticCoupling)", "390 K", "293 to 353 K")
def coupling_too_warm():
    """A coupling is warmer than its rows of factors say."""
    lp.equilibrium(drive(over_temperature=((293, 1, 1), (353, 0.7, 0.8)), T=390.0))


@couplings(EquationError, "coupling (ElasticCoupling)", "over_amplitude begins at 100 N.m", "zero")
def amplitudes_not_from_zero():
    """The rows of factors over the amplitude begin at an amplitude."""
    drive(over_amplitude=((100, 1, 1), (900, 0.7, 1.2)))


@couplings(SolverError, "amplitude of vibration = ", "0 to 300 N.m", "extrapolate=True")
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


@couplings(DeclarationError, "coupling (MaxwellCoupling)", "psi by 37%", "Take a narrower band")
def branches_too_few():
    """One Maxwell branch is to have a relative damping over a decade of frequencies."""
    maxwell(n_branches=1)


@couplings(DeclarationError, "coupling (MaxwellCoupling)", "band = (0.0, 0.0)", "rad/s")
def band_not_given():
    """The frequencies at which a Maxwell coupling is to have its damping are not given."""
    maxwell(band=(0.0, 0.0))


@couplings(DeclarationError, "coupling (MaxwellCoupling)", "static = 1.2", "below 1")
def static_stiffness_above_the_dynamic_one():
    """The static stiffness of a coupling is above its dynamic one."""
    maxwell(static=1.2)


@couplings(ParameterError, "pendulum.r = 0 m", "greater than 0")
def pendulum_without_length():
    """A pendulum has no length."""
    assemble_row(rotor=Inertia(J=12.0), pendulum=CentrifugalPendulum(m=1.0, R=0.1, r=0.0))


@couplings(OptionError, "mu = 0", "above zero")
def optimum_without_ring():
    """The best damping of a ring without inertia is asked for."""
    ViscousDamper.optimum(0.0)
