"""Events and pulses whose instants are known in closed form: none is missed, none is invented."""

import itertools

import numpy as np
import pytest
from ensemble_runs import Alone, assert_same_bits, ran
from scipy.optimize import brentq

import lumped as lp
from lumped import functionals as fun
from lumped.components import Brake, CamSwitch, Inertia, Torque
from lumped.components import translation as tr
from lumped.kernel import engine
from lumped.many_runs.native_runs import NativeRuns

METHODS = ("explicit", "implicit", "taylor")
t = lp.time


class Count(lp.Component):
    """Time in which a signal is on."""

    u: lp.Input = lp.Input("1", "what is counted")
    on: lp.Var = lp.var("s", "time that it was on", 0.0)

    def equations(self):
        yield lp.der(self.on) == self.u


def cam(width):
    """A wheel whose cam is on where it is nearer than half of its width to 1 rad."""
    parts = {"wheel": Inertia(J=1.0, w=100.0, phi=0.0), "cam": CamSwitch(centre=1.0, width=width)}
    model = lp.compose(
        **parts,
        count=Count(),
        connections=lambda m: [
            lp.connect(m.wheel.flange_a, m.cam.flange),
            lp.connect(m.cam.y, m.count.u),
        ],
    )
    return lp.assemble(model, keep=["wheel.phi"])


def passed(width, w, until):
    """Instants at which the cam of an even wheel switches."""
    turns = 2 * np.pi * np.arange(int(until * w / 2 / np.pi) + 2)
    found = np.concatenate([turns + 1.0 - 0.5 * width, turns + 1.0 + 0.5 * width]) / w
    return np.sort(found[found < until])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("w", "degrees"), [(1.0, 5.0), (30.0, 2.9), (30.0, 0.1), (300.0, 5.0), (300.0, 0.5), (3e3, 0.1)]
)
def test_a_cam_switches_twice_a_turn(method, w, degrees):
    width, until = np.radians(degrees), min(20.0, 300.0 / w)
    run = lp.simulate(cam(width), until=until, start={"wheel.w": w}, method=method)
    expected = passed(width, w, until)
    received = np.array([event.time for event in run.events])
    assert len(received) == len(expected)
    np.testing.assert_allclose(received, expected, rtol=1e-9, atol=1e-10 / w)


def test_cams_in_lanes_switch_as_in_single_runs():
    widths, until = np.radians(np.linspace(0.1, 5.0, 11)), 1.0
    of = {"count": fun.count("cam"), "on": fun.final("count.on")}
    for method in ("steps", "taylor"):
        lanes, alone = (
            ran(cam(0.1), ["cam.width"], widths[:, None], of, kind=kind, until=until, method=method)
            for kind in (NativeRuns, Alone)
        )
        assert_same_bits(lanes, alone)
        expected = [passed(width, 100.0, until) for width in widths]
        assert lanes.values[:, 0].tolist() == [len(times) for times in expected]
        on = [(times[1::2] - times[: len(times) // 2 * 2 : 2]).sum() for times in expected]
        np.testing.assert_allclose(lanes.values[:, 1], on, rtol=1e-7)


class Even(lp.Component):
    """``x = t - 1``, so steps are as long as the run; y counts while a condition on x holds."""

    x: lp.Var = lp.var("1", "x", -1.0)
    y: lp.Var = lp.var("1", "y", 0.0)
    law = None

    def equations(self):
        yield lp.der(self.x) == 1.0
        yield lp.der(self.y) == lp.ops.where(type(self).law(self.x), 1.0, 0.0)


def even(law):
    """The component with a condition."""
    return lp.assemble(type("Law", (Even,), {"__doc__": ".", "law": staticmethod(law)})())


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rate", [1.0, 7.0, 50.0, 300.0, 1000.0])
@pytest.mark.parametrize("by", [1e-3, 1e-9])
def test_a_sine_passes_its_limit_by_a_little(method, rate, by):
    until = min(12.0, 1000.0 / rate)
    run = lp.simulate(
        even(lambda x: lp.ops.sin(rate * x) > 1 - by), until=until, method=method, max_steps=10**6
    )
    half = 2 * np.arcsin(np.sqrt(by / 2))
    tops = 0.5 * np.pi + 2 * np.pi * np.arange(-int(rate), int(rate * until) + 1)
    expected = np.sort(np.concatenate([tops - half, tops + half])) / rate + 1.0
    expected = expected[(expected > 0) & (expected < until)]
    received = np.array([event.time for event in run.events])
    assert len(received) == len(expected)
    # a border is passed with the slope sqrt(2 by)
    np.testing.assert_allclose(received, expected, rtol=0, atol=1e-11 / np.sqrt(by) + 1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_what_stays_beside_its_limit_is_no_event(method):
    for beside in (1e-3, 1e-12):
        system = even(lambda x, beside=beside: lp.ops.sin(50 * x) > 1 + beside)
        assert not lp.simulate(system, until=10.0, method=method).events
    system = even(lambda x: lp.ops.sin(50 * x) > 1 - 1e-11)
    events = lp.simulate(system, until=1.0, method=method).events
    assert len(events) == 2 * len([k for k in range(20) if 0 < (0.25 + k) * 0.04 * np.pi < 1.0])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("order", [1, 3, 5, 9])
def test_a_root_of_high_order_is_found_where_it_is(method, order):
    run = lp.simulate(even(lambda x: x**order > 0), until=3.0, method=method)
    assert [event.time for event in run.events] == [pytest.approx(1.0, rel=1e-12)]
    assert run["y"][-1] == pytest.approx(2.0, rel=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("order", [3, 5])
def test_a_body_lifts_where_its_force_turns(method, order):
    """``s'' = (t - 1)**n`` from 1 s on: ``s(3) = 2**(n + 2) / ((n + 1) (n + 2))``."""
    force = tr.Force(f=(t - 1.0) ** order)
    model = lp.compose(
        m=tr.Mass(m=1.0, s=0.0, v=0.0),
        stop=tr.Stop(),
        g=force,
        connections=lambda m: [lp.connect(m.m.flange_a, m.stop.flange_b, m.g.flange)],
    )
    run = lp.simulate(lp.assemble(model, keep=["m.s"]), until=3.0, method=method)
    assert [event.time for event in run.events] == [pytest.approx(1.0, rel=1e-12)]
    expected = 2 ** (order + 2) / ((order + 1) * (order + 2))
    assert run["m.s"][-1] == pytest.approx(expected, rel=1e-5)


def test_engines_find_the_same_instants():
    runs = [
        (cam(0.05), 0.2),
        (even(lambda x: lp.ops.sin(40 * x) > 1 - 1e-6), 0.3),
        (even(lambda x: x**5 > 0), 1.5),
    ]
    for system, until in runs:
        for method in METHODS:
            found = []
            for name in ("llvm", "c", "python"):
                with engine.using(name):
                    run = lp.simulate(system, until=until, method=method)
                found.append([event.time for event in run.events])
            assert len(found[0])
            assert found[0] == found[1] == found[2]


# -- pulses of the time ----------------------------------------------------------------------------

PULSES = {
    "gauss": (lambda o, x: 12 * o.exp(-(((x - 7.7) / 0.1) ** 2)), 20.0, 7.7),
    "lorentz": (lambda o, x: 30 / (1 + ((x - 3.0) / 0.02) ** 2), 5.0, 3.0),
    "product": (lambda o, x: 14 * o.sin(x) * o.exp(-(((x - 1.5) / 0.01) ** 2)), 6.0, 1.5),
    "short": (lambda o, x: 12 * o.exp(-(((x - 0.77) / 1e-5) ** 2)), 1.0, 0.77),
}


def integral(f, begin, end, panels=40):
    """Gauss's rule in equal panels."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    half = 0.5 * (end - begin) / panels
    middles = begin + half * (2 * np.arange(panels) + 1)
    return half * (np.array([f(m + half * nodes) for m in middles]) @ weights).sum()


def turned(pulse, limit):
    """Angle by which a body of 1 kg m2 turns that a brake holds up to a limit."""
    law, _, centre = PULSES[pulse]

    def f(x):
        return law(np, x)

    wide = {"gauss": 1.0, "lorentz": 1.0, "product": 0.1, "short": 1e-4}[pulse]
    begin = brentq(lambda x: f(x) - limit, centre - wide, centre, xtol=1e-15)

    def speed(x):
        return integral(lambda s: f(s) - limit, begin, x)

    high = brentq(lambda x: f(x) - limit, centre, centre + wide, xtol=1e-15)
    later = high
    while speed(later) > 0:
        later += 0.05 * (high - begin)
    end = brentq(speed, later - 0.05 * (high - begin), later, xtol=1e-15)
    angle = integral(lambda x: np.array([speed(each) for each in x]), begin, end, 4)
    return angle, begin, end


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("pulse", PULSES)
def test_a_brake_at_rest_slips_under_a_pulse(method, pulse):
    law, until, _ = PULSES[pulse]
    model = lp.compose(
        a=Inertia(J=1.0, w=0.0),
        b=Brake(f_max=20.0, u=1.0),
        m=Torque(tau=law(lp.ops, t)),
        connections=lambda k: [lp.connect(k.a.flange_a, k.b.flange_a, k.m.flange)],
    )
    run = lp.simulate(lp.assemble(model), until=until, method=method, rtol=1e-8)
    angle, begin, end = turned(pulse, 10.0)
    times = [event.time for event in run.events]
    assert len(times) == 2
    # a maximum is flat: where it passes the limit is as uncertain as the root of the rounding
    np.testing.assert_allclose(times, [begin, end], rtol=1e-9)
    assert run["a.phi"][-1] == pytest.approx(angle, rel=1e-4, abs=1e-13)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("pulse", PULSES)
def test_a_body_at_rest_takes_the_impulse_of_a_pulse(method, pulse):
    law, until, centre = PULSES[pulse]
    model = lp.compose(
        a=Inertia(J=1.0, w=0.0),
        m=Torque(tau=law(lp.ops, t)),
        connections=lambda k: lp.chain(k.m, k.a),
    )
    system = lp.assemble(model)
    run = lp.simulate(system, until=until, method=method, rtol=1e-8)
    near = np.array([0.1, 1.0, 10.0, 100.0, 1000.0]) * {"gauss": 0.1, "lorentz": 0.02}.get(
        pulse, 1e-5
    )
    edges = np.clip([0.0, *(centre - near[::-1]), *(centre + near), until], 0.0, until)
    parts = itertools.pairwise(edges)
    expected = sum(integral(lambda x: law(np, x), low, high, 100) for low, high in parts)
    assert run["a.w"][-1] == pytest.approx(expected, rel=3e-7)


def test_pulses_in_lanes_and_by_all_engines_have_the_bits_of_single_runs():
    law = PULSES["short"][0](lp.ops, t) + PULSES["product"][0](lp.ops, t)
    model = lp.compose(
        a=Inertia(J=1.0, w=0.0), m=Torque(tau=law), connections=lambda k: lp.chain(k.m, k.a)
    )
    system, points = lp.assemble(model), np.linspace(0.5, 2.0, 11)[:, None]
    of = {"w": fun.final("a.w")}
    for method in ("steps", "taylor"):
        lanes, alone = (
            ran(system, ["a.J"], points, of, kind=kind, until=1.6, method=method)
            for kind in (NativeRuns, Alone)
        )
        assert_same_bits(lanes, alone)
        total = 12e-5 * np.sqrt(np.pi) + 14e-2 * np.sqrt(np.pi) * np.sin(1.5) * np.exp(-0.25e-4)
        np.testing.assert_allclose(lanes.values[:, 0] * points[:, 0], total, rtol=1e-5)
    found = []
    for name in ("llvm", "c", "python"):
        with engine.using(name):
            found.append(lp.simulate(system, until=1.6)["a.w"][-1])
    assert found[0] == found[1] == found[2]
