"""Shafts that cannot be made."""

import lumped as lp
from lumped.components import (
    Fillet,
    Hollow,
    Inertia,
    Keyed,
    Keyway,
    RadialHole,
    Shaft,
    Solid,
    Splined,
    SplineEnd,
    Taper,
)
from lumped.errors import DeclarationError, ParameterError, UnknownNameError

from . import Table

wrong = Table("Shafts")


def shaft(*sections, **given):
    lp.assemble(lp.compose(shaft=Shaft(sections=sections, **given)))


@wrong(ParameterError, "d = 0.1 m (outside diameter)", "bore = 0.12 m (diameter of the bore)")
def bore_larger_than_the_shaft():
    """The bore of a shaft is larger than its diameter."""
    shaft(Hollow(d=0.1, bore=0.12, L=0.5))


@wrong(ParameterError, "d = 0.1 m (diameter)", "bore + 2 * t = 0.11 m")
def keyway_deeper_than_the_wall():
    """A keyway is deeper than the wall of a hollow shaft."""
    shaft(Keyed(d=0.1, bore=0.07, t=0.02, L=0.5))


@wrong(ParameterError, "d = 0.08 m (outside diameter)", "d_root = 0.09 m")
def spline_with_root_outside():
    """The root of a spline is larger than its outside."""
    shaft(Splined(d=0.08, d_root=0.09, L=0.1))


@wrong(ParameterError, "sections[0].L = 0 m (length", "greater than")
def taper_without_length():
    """A cone has no length."""
    shaft(Taper(d_a=0.1, d_b=0.08, L=0.0))


@wrong(ParameterError, "sections[1].L = 0.02 m (length", "max(0, -x_a - x_b)")
def flange_shorter_than_its_steps():
    """A flange is so short that the steps on both sides would take more than its length."""
    shaft(Solid(d=0.2, L=0.5), Solid(d=0.5, L=0.02), Solid(d=0.2, L=0.5))


@wrong(UnknownNameError, "sections[0] (Solid): material = 'stel'", "Nearest: steel")
def unknown_material():
    """The name of a material is misspelt."""
    shaft(Solid(d=0.1, L=0.5, material="stel"))


@wrong(UnknownNameError, "step = 'compute' is no rule", "Nearest: computed")
def unknown_rule_of_steps():
    """The name of a rule for steps is misspelt."""
    shaft(Solid(d=0.1, L=0.5), Solid(d=0.2, L=0.5), step="compute")


@wrong(DeclarationError, "shaft (Shaft): f_max = -50.0 Hz")
def negative_frequency_limit():
    """The highest frequency of interest is negative."""
    shaft(Solid(d=0.1, L=0.5), f_max=-50.0)


@wrong(ParameterError, "r = 0.001 m (radius of the fillet", "t/r up to 4", "(D - d) / 8")
def fillet_too_sharp():
    """A fillet is sharper than its fit was made for."""
    shaft(Solid(d=0.1, L=0.5), Fillet(r=0.001), Solid(d=0.15, L=0.5))


@wrong(ParameterError, "d = 0.1 m (diameter of the shaft, ten times that of the hole or more)")
def hole_too_large():
    """A radial hole is too large for the formula of a small one."""
    shaft(Solid(d=0.1, L=0.5), RadialHole(d_hole=0.03), Solid(d=0.1, L=0.5))


@wrong(
    ParameterError, "d (diameter of the shaft; the fit holds for r/d up to 0.07, m) has no value"
)
def keyway_without_a_shaft():
    """A keyway stands outside of a shaft and has no diameter."""
    lp.assemble(lp.compose(keyway=Keyway()))


@wrong(UnknownNameError, "sections[1] (SplineEnd): profile = 'involut'", "Nearest: involute")
def unknown_profile_of_a_spline():
    """The name of a profile is misspelt."""
    end = SplineEnd(R_m=900e6, profile="involut")
    shaft(Solid(d=0.06, L=0.5), end, Splined(d=0.05, d_root=0.045, L=0.1))


@wrong(ParameterError, "sections[1].R_m (tensile strength of the part at its diameter, Pa) has no")
def spline_of_unknown_strength():
    """The strength of a splined shaft is not given."""
    shaft(Solid(d=0.06, L=0.5), SplineEnd(), Splined(d=0.05, d_root=0.045, L=0.1))


@wrong(DeclarationError, "sections[1] (Inertia) is no section of a shaft and no notch")
def body_among_the_sections():
    """A body stands among the sections of a shaft."""
    shaft(Solid(d=0.1, L=0.5), Inertia(J=1.0))


@wrong(DeclarationError, "shaft (Shaft): no sections")
def shaft_without_sections():
    """A shaft is given no sections."""
    lp.assemble(lp.compose(shaft=Shaft()))
