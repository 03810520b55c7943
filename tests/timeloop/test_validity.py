"""Components that say where their equations hold."""

import re

import numpy as np
import pytest
from checks import refused
from rows import assemble_row, in_a_row

import lumped as lp
from lumped.components import Fixed, Inertia, Torque
from lumped.errors import EquationError, SolverError


class Rubber(lp.Component):
    """A spring whose law holds up to a twist: ``tau = c phi_rel``."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    c: lp.Param = lp.param("N.m/rad", "stiffness", above=0)
    most: float = 0.1
    phi_rel: lp.Var = lp.var("rad", "twist", state="prefer")
    tau: lp.Var = lp.var("N.m", "torque on flange b")

    def equations(self):
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.tau == self.c * self.phi_rel
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau

    def valid(self):
        yield self.phi_rel, -self.most, 2 * self.most, "rad", "twist", "Take a larger one"


def swing(begin=0.0, push=0.0, **rubber):
    """A rotor of inertia 1 on rubber of stiffness 100: 10 rad/s."""
    return assemble_row(
        wall=Fixed(),
        rubber=Rubber(c=100.0, phi_rel=begin, **rubber),
        rotor=Inertia(J=1.0),
        torque=Torque(tau=push),
    )


METHODS = ["explicit", "implicit", "taylor"]


@pytest.mark.parametrize("method", METHODS)
def test_a_run_within_the_range_is_as_without(method):
    run = lp.simulate(swing(0.0999), until=1.0, method=method, rtol=1e-9)
    assert run["rubber.phi_rel"] == pytest.approx(0.0999 * np.cos(10 * run.t), abs=1e-8)
    assert not run.events


@pytest.mark.parametrize("grid", [500, None, (0.0, 1.0), (0.0, 0.6, 1.0)])
@pytest.mark.parametrize("method", METHODS)
def test_a_run_that_leaves_the_range_is_refused(grid, method):
    # it begins at 0.1001 on the wide side and comes to -0.1 near the end of a half swing
    with pytest.raises(SolverError, match=r"rubber \(Rubber\): twist = -0\.1") as refused:
        lp.simulate(swing(0.1001), until=1.0, grid=grid, method=method, rtol=1e-9)
    assert "-0.1 to 0.2 rad, for which its equations hold. Take a larger one." in str(refused.value)
    assert refused.value.partial["rubber.phi_rel"][0] == 0.1001
    (time,) = re.findall(r"at t = ([\d.]+) s", str(refused.value))
    first = np.arccos(-0.1 / 0.1001) / 10
    assert first - 1e-5 < float(time) < 2 * np.pi / 10 - first + 1e-5


def test_a_run_that_begins_outside_is_refused():
    refused(SolverError, lambda: lp.simulate(swing(-0.3), until=1.0), "twist = -0.3 rad at t = 0 s")


def test_points_outside_are_refused():
    with pytest.raises(SolverError, match=r"twist = 0\.25 rad at the equilibrium"):
        lp.equilibrium(swing(push=25.0))
    assert lp.equilibrium(swing(push=19.9))["rubber.phi_rel"] == pytest.approx(0.199)
    refused(SolverError, lambda: lp.modes(swing(0.3)), "twist = 0.3 rad at the operating point")


def test_runs_of_an_ensemble_that_leave_the_range_fail():
    found = lp.ensemble(
        swing(),
        over={"torque.tau": [4.0, 9.0, 11.0, -4.0, -6.0]},
        until=1.0,
        of=[lp.functionals.peak("rubber.phi_rel")],
        rtol=1e-9,
    )
    # the largest twist is twice the static one
    assert found.values[[0, 1, 3], 0] == pytest.approx([0.08, 0.18, 0.08], rel=1e-6)
    assert np.isnan(found.values[[2, 4], 0]).all()
    assert set(found.failures) == {2, 4}
    assert "twist = -0.1" in found.failures[4]
    assert "lies outside -0.1 to 0.2 rad" in found.failures[2]


class Bump(lp.Component):
    """A quantity that leaves its range for a ten thousandth of the only step."""

    top: lp.Param = lp.param("1", "height", 1.0)
    phi: lp.Var = lp.var("1", "way", 0.0, state="always")
    bump: lp.Var = lp.var("1", "narrow bump")

    def equations(self):
        yield lp.der(self.phi) == 1.0
        yield self.bump == self.top * lp.ops.exp(-(((self.phi - 0.37) / 5e-4) ** 2))

    def valid(self):
        yield self.bump, -1.0, 0.99, "1", "bump", "Take a lower one"


@pytest.mark.parametrize("method", METHODS)
def test_a_range_that_is_left_for_a_ten_thousandth_of_a_step(method):
    """``exp(-s**2) > 0.99`` for 1e-4 s."""
    system = lp.assemble(Bump())
    with pytest.raises(SolverError, match=r"bump = 0\.99 1 passed at t = 0\.36995 s"):
        lp.simulate(system, until=1.0, grid=(0.0, 1.0), method=method)
    lp.simulate(system, until=1.0, grid=(0.0, 1.0), method=method, parameters={"top": 0.9899})
    tops = np.array([0.9899, 1.0, 0.98999, 0.99001, 0.5, 3.0, 0.0, -0.9999, -1.0001])
    found = lp.ensemble(
        system, over={"top": tops}, until=1.0, of=[lp.functionals.final("phi")], method=method
    )
    assert set(found.failures) == {1, 3, 5, 8}


class OneSided(lp.Component):
    """A quantity that falls, and must not fall below zero."""

    y: lp.Var = lp.var("1", "quantity", 1.0, state="always")
    rises: bool = False

    def equations(self):
        yield lp.der(self.y) == (1.0 if self.rises else -1.0) * lp.ops.cos(lp.time)

    def valid(self):
        ends = (-np.inf, 1.5) if self.rises else (0.5, np.inf)
        yield self.y, *ends, "1", "quantity", "Stop before"


@pytest.mark.parametrize(("rises", "end"), [(False, r"0\.5"), (True, r"1\.5")])
def test_a_range_may_be_open_to_one_side(rises, end):
    """``y = 1 -+ sin(t)`` leaves at 0.5236 s and is back at the end, or not."""
    system = lp.assemble(OneSided(rises=rises))
    with pytest.raises(SolverError, match=rf"quantity = {end} 1 passed at t = 0\.5235"):
        lp.simulate(system, until=3.0, grid=(0.0, 3.0))
    with pytest.raises(SolverError, match=r"quantity = .* 1 at t = 1 s"):
        lp.simulate(system, until=1.0, grid=(0.0, 1.0))
    lp.simulate(system, until=0.5, grid=(0.0, 0.5))
    outside = 2.0 if rises else 0.4
    with pytest.raises(SolverError, match=rf"quantity = {outside:g} 1 at t = 0 s"):
        lp.simulate(system, until=0.1, start={"y": outside})


def test_a_range_of_a_quantity_of_another_component_is_refused():
    class Stray(Rubber):
        """A spring that asks for what it does not have: ``tau = c phi_rel``."""

        def valid(self):
            yield Fixed().flange.phi, 0, 1, "rad", "twist", "Do not"

    model = in_a_row(wall=Fixed(), rubber=Stray(c=100.0), rotor=Inertia(J=1.0))
    refused(EquationError, lambda: lp.assemble(model), "rubber")


@pytest.mark.parametrize("given", [None, (1.0, 2.0), ("phi_rel", 0, 1, "rad", "twist", "Do not")])
def test_a_range_that_is_none_is_refused(given):
    class Vague(Rubber):
        """A spring that does not say what it means: ``tau = c phi_rel``."""

        def valid(self):
            yield given

    model = in_a_row(wall=Fixed(), rubber=Vague(c=100.0), rotor=Inertia(J=1.0))
    with pytest.raises(EquationError, match=r"rubber.*valid\(\) gave .* an advice are needed"):
        lp.assemble(model)


class Loaded(lp.Component):
    """A load that must not be negative."""

    flange = lp.Flange()
    F: lp.Input = lp.Input("N", "load")

    def equations(self):
        yield self.flange.tau == 0.0 * self.F

    def valid(self):
        yield self.F, 0.0, float("inf"), "N", "load", "Give its magnitude"


@pytest.mark.parametrize("least", [0.0, -1e-3])
def test_a_range_from_zero_on_bears_the_rounding_of_its_values(least):
    F = lp.ops.maximum(500 * lp.ops.cos(5 * lp.time), least)
    system = assemble_row(part=Loaded(F=F), rotor=Inertia(J=1.0))
    over, of = {"rotor.J": [1.0, 2.0]}, [lp.functionals.final("rotor.w")]
    if least:
        refused(SolverError, lambda: lp.simulate(system, until=1.0), "load = ")
        refused(SolverError, lambda: lp.ensemble(system, over=over, until=1.0, of=of), "load = ")
    else:
        assert lp.simulate(system, until=1.0)["rotor.w"][-1] == 0.0
        assert not lp.ensemble(system, over=over, until=1.0, of=of).failures


class Root(lp.Component):
    """A quantity that grows with a root, which has no value below zero."""

    y: lp.Var = lp.var("1", "quantity", 0.0, state="always")
    u: lp.Param = lp.param("s", "when there is no root any more")

    def equations(self):
        yield lp.der(self.y) == lp.ops.sqrt(self.u - lp.time)

    def valid(self):
        yield self.u - lp.time, 0.0, float("inf"), "s", "radicand", "Give a larger u"


@pytest.mark.parametrize(("u", "words"), [(-1.0, "radicand = -1"), (0.5, "radicand = -")])
def test_a_run_that_fails_outside_of_a_range_names_the_range(u, words):
    refused(SolverError, lambda: lp.simulate(lp.assemble(Root(u=u)), until=1.0), words)
