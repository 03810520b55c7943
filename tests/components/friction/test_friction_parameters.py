"""Frictions that are parameters of the component around the element: varied, differentiated, found.

A body coasts: ``J der(w) = -(c_0 + s w)`` with ``s = (c_1 - c_0) / 20`` has the closed form
``w = (w_0 + c_0 / s) exp(-s t / J) - c_0 / s``.
"""

import numpy as np
import pytest
from checks import worst
from rows import in_a_row

import lumped as lp
from lumped.components import BearingFriction, Clutch, Fixed, Inertia, Stribeck
from lumped.errors import EquationError

J, W, FAST = 0.5, 18.0, 20.0
FORMS = {
    "rows": lambda a, b: ((0.0, a), (FAST, b), (2 * FAST, 2 * b - a)),
    "function": lambda a, b: lambda w: a + (b - a) / FAST * w,
    "Stribeck": lambda a, b: Stribeck(a, a, 1.0, (b - a) / FAST),
}


def rig(form):
    class Rig(lp.Component):
        """A body that its bearing brakes; the frictions have the names of other parameters."""

        c_0: lp.Param = lp.param("N.m", "friction at standstill", 2.0, min=0)
        peak: lp.Param = lp.param("N.m", "friction at 20 rad/s", 3.0, min=0)
        body: Inertia = Inertia(J=J, w=W)
        bearing: BearingFriction = BearingFriction(characteristic=FORMS[form](c_0, peak))

        def connections(self):
            yield from lp.chain(self.body, self.bearing)

    return Rig


def coasting(t, c_0, c_1):
    slope = (c_1 - c_0) / FAST
    return (W + c_0 / slope) * np.exp(-slope * t / J) - c_0 / slope


@pytest.mark.parametrize("form", FORMS)
def test_it_coasts_with_the_frictions_that_are_given(form):
    system = lp.assemble(rig(form)())
    for c_0, c_1 in ((2.0, 3.0), (1.0, 4.0)):
        given = {"c_0": c_0, "peak": c_1}
        run = lp.simulate(system, until=2.0, parameters=given, rtol=1e-11)
        assert run["body.w"] == pytest.approx(coasting(run.t, c_0, c_1), rel=1e-9)
        assert system.parameters["bearing.peak"] == 1.0


@pytest.mark.parametrize("form", FORMS)
def test_its_derivatives_by_the_frictions_are_those_of_the_closed_form(form):
    h = 1e-20
    found = lp.sensitivity(
        lp.assemble(rig(form)()), of=["body.w"], by=["c_0", "peak"], until=2.0, rtol=1e-10
    )
    for i, name in enumerate(("c_0", "peak")):
        moved = [2.0 + 1j * h * (i == 0), 3.0 + 1j * h * (i == 1)]
        expected = coasting(found.run.t, *moved).imag / h
        assert worst(found["body.w", name], expected) < 1e-7


def test_the_frictions_of_a_measured_run_are_found():
    t = np.linspace(0.0, 2.5, 60)
    found = lp.identify(
        lp.assemble(rig("rows")()),
        vary={"c_0": (0.1, 10.0), "peak": (0.1, 10.0)},
        t=t,
        measured={"body.w": coasting(t, 1.3, 4.4)},
        sigma={"body.w": 1e-3},
        rtol=1e-10,
    )
    assert found.parameters["c_0"] == pytest.approx(1.3, rel=1e-6)
    assert found.parameters["peak"] == pytest.approx(4.4, rel=1e-6)


def test_each_copy_has_the_frictions_of_its_own_surroundings():
    """Two rigs of one class share their equations, not their parameters."""
    kind = rig("rows")
    system = lp.assemble(lp.compose(a=kind(), b=kind(c_0=1.0, peak=4.0)))
    run = lp.simulate(system, until=1.0, rtol=1e-10)
    for name, given in (("a", (2.0, 3.0)), ("b", (1.0, 4.0))):
        assert run[f"{name}.body.w"] == pytest.approx(coasting(run.t, *given), rel=1e-8)


def test_their_units_fit():
    assert lp.check_units(rig("rows")()) > 0
    kind = rig("rows")
    curve = Stribeck(coulomb=kind.c_0, static=1.5 * kind.c_0, decay=0.4, viscous=0.05)
    assert lp.check_units(kind(bearing=BearingFriction(characteristic=curve))) > 0


def test_a_clutch_takes_them_too():
    class Rig(lp.Component):
        """A body that a clutch holds."""

        mu: lp.Param = lp.param("1", "friction coefficient", 0.3, min=0)
        body: Inertia = Inertia(J=J, w=W)
        clutch: Clutch = Clutch(characteristic=((0.0, mu),), c_geo=0.1, f_max=50.0, u=1.0)
        wall: Fixed = Fixed()

        def connections(self):
            yield from lp.chain(self.body, self.clutch, self.wall)

    run = lp.simulate(lp.assemble(Rig()), until=2.0, parameters={"mu": 0.4})
    assert run["body.w"] == pytest.approx(W - 0.4 * 5.0 / J * run.t, rel=1e-9)


def test_a_parameter_of_nothing_around_it_is_refused_by_name():
    stray = BearingFriction(characteristic=((0.0, rig("rows").c_0),))
    alone = in_a_row(body=Inertia(J=J), bearing=stray)
    with pytest.raises(EquationError, match="parameter 'c_0', which Model does not have"):
        lp.assemble(alone)
    with pytest.raises(EquationError, match=r"'c_0', which is not its own .* Give a number"):
        lp.assemble(stray)
    rows = ((0.0, 1.0), (rig("rows").c_0, 2.0))
    with pytest.raises(EquationError, match="sliding speeds must be numbers"):
        lp.assemble(BearingFriction(characteristic=rows))
