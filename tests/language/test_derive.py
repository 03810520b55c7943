"""Derivatives against CasADi's own, and what they cost against formulas written by hand."""

import casadi as ca
import numpy as np
import pytest
from linkages import Crank, Yoke
from rows import in_a_row

import lumped as lp
from lumped.components import IdealGear, Inertia, Spring, Torque
from lumped.components.translation import Mass
from lumped.language.derivatives import along, partials

UNARY = [
    *(ca.sin, ca.cos, ca.atan, ca.tanh, ca.sinh, ca.fabs, ca.sign),
    lambda a: -a,
    lambda a: 2 * a,
    lambda a: 0.3 * a,
    lambda a: a / 4,
    lambda a: a**2,
    lambda a: a**3,
    lambda a: (1 + a**2) ** -1.5,
    lambda a: ca.sqrt(1 + a**2),
    lambda a: ca.log(2 + ca.cos(a)),
    lambda a: ca.exp(-(a**2)),
    lambda a: ca.acos(ca.tanh(a)),
    lambda a: 1 / (2 + ca.sin(a)),
]
BINARY = [
    *(ca.fmin, ca.fmax, ca.atan2),
    lambda a, b: a + b,
    lambda a, b: a - b,
    lambda a, b: a * b,
    lambda a, b: a / (1 + b**2),
    lambda a, b: ca.sqrt(a**2 + b**2 + 1),
    lambda a, b: (1 + a**2) ** ca.sin(b),
    lambda a, b: ca.if_else(a >= b, a * b, b),
]


@pytest.mark.parametrize("seed", range(60))
def test_derivatives_of_random_expressions_are_those_of_casadi(seed):
    rng = np.random.default_rng(seed)
    symbols, rates, other = ca.SX.sym("q", 3), ca.SX.sym("w", 3), ca.SX.sym("p", 2)
    pool = [*ca.vertsplit(symbols), *ca.vertsplit(other)]
    for _ in range(15):
        a, b = (pool[i] for i in rng.integers(len(pool), size=2))
        both = rng.random() < 0.5
        pool.append(rng.choice(BINARY)(a, b) if both else rng.choice(UNARY)(a))
    root = sum(pool[-4:])
    rate, known = along(root, symbols, rates), ca.jtimes(root, symbols, rates)
    everything = ca.vertcat(symbols, rates)
    further = ca.vertcat(2.0, symbols[2], rates[0], *ca.vertsplit(rates))
    received = (
        partials(root, symbols),
        rate,
        partials(rate, everything),
        along(rate, everything, further),
    )
    expected = (
        ca.gradient(root, symbols),
        known,
        ca.gradient(known, everything),
        ca.jtimes(known, everything, further),
    )
    compare = ca.Function("f", [everything, other], [ca.vertcat(*received), ca.vertcat(*expected)])
    for _ in range(5):
        found, known_values = compare(rng.normal(size=6), rng.normal(size=2))
        scale = 1 + np.abs(np.asarray(known_values)).max()
        error = np.abs(np.asarray(found - known_values)).max() / scale
        assert error < 1e-12


def test_a_derivative_is_zero_where_the_symbol_is_absent():
    q, p = ca.SX.sym("q", 2), ca.SX.sym("p")
    assert partials(ca.sin(p) * q[0], q)[1].is_zero()
    assert along(p**2, q, ca.SX.ones(2)).is_zero()
    assert partials(p, ca.SX(0, 1)).shape == (0, 1)


def chain(n, ratio):
    """Free inertias with springs between them, and gears if there is a ratio; by hand too."""
    gears = [IdealGear(ratio=ratio) for _ in range(n - 1)] if ratio else []
    model = lp.compose(
        body=[Inertia(J=1.0 + i) for i in range(n)],
        shaft=[Spring(c=1e3) for _ in range(n - 1)],
        **({"gear": gears} if gears else {}),
        connections=lambda m: (
            joint
            for i in range(n - 1)
            for joint in lp.chain(
                m.body[i], m.shaft[i], *([m.gear[i]] if gears else []), m.body[i + 1]
            )
        ),
    )
    twist, w, J = ca.SX.sym("twist", n - 1), ca.SX.sym("w", n), ca.SX.sym("J", n)
    c, rest, i = (ca.SX.sym(name, n - 1) for name in ("c", "rest", "ratio"))
    tau = c * (twist - rest)
    speed, passed = (i * w[1:], i * tau) if gears else (w[1:], tau)
    torque = ca.vertcat(tau, 0) - ca.vertcat(0, passed)
    inputs = [twist, w, J, c, rest, i if gears else ca.SX(0, 1)]
    return model, ca.Function("f", inputs, [ca.vertcat(speed - w[:-1], torque / J)])


def crank_motion(phi, r, rod):
    """First and second derivative of the slider's position by the angle."""
    x, y = r * ca.cos(phi), r * ca.sin(phi)
    root = ca.sqrt(rod**2 - y**2)
    k = x / root
    lever = 1 + k
    return -y * lever, -lever * (x + y**2 * (k - 1) / root)


def yoke_motion(phi, r):
    """First and second derivative of the yoke's position by the angle."""
    return r * ca.cos(phi), -r * ca.sin(phi)


def slider(part, names, motion):
    """Torque on a crank that drives a mass; by hand ``(J + m s'^2) w' = tau - m s' s'' w^2``."""
    model = in_a_row(torque=Torque(tau=2.0), crank=Inertia(J=1.0), rod=part, slider=Mass(m=2.0))
    phi, w, J, m, tau = (ca.SX.sym(name) for name in ("phi", "w", "J", "m", "tau"))
    own = [ca.SX.sym(name) for name in names]
    slope, bend = motion(phi, *own)
    rate = (tau - m * slope * bend * w**2) / (J + m * slope**2)
    return model, ca.Function("f", [phi, w, J, m, tau, *own], [ca.vertcat(w, rate)])


@pytest.mark.parametrize(
    ("model", "by_hand"),
    [
        pytest.param(*chain(20, None), id="chain"),
        pytest.param(*chain(20, 2.5), id="geared chain"),
        pytest.param(*slider(Crank(), ["r", "length"], crank_motion), id="crank-slider"),
        pytest.param(*slider(Yoke(), ["r"], yoke_motion), id="scotch yoke"),
    ],
)
def test_the_right_hand_side_costs_at_most_a_fifth_more_than_one_written_by_hand(model, by_hand):
    received = lp.assemble(model).rhs.n_instructions()
    expected = by_hand.n_instructions()
    assert received <= 1.2 * expected


@pytest.mark.parametrize(
    ("part", "motion"), [(Crank(), crank_motion), (Yoke(), yoke_motion)], ids=["crank", "yoke"]
)
def test_a_slider_accelerates_its_crank_as_lagrange_says(part, motion):
    names = list(type(part)._quantities)
    model, by_hand = slider(part, names, motion)
    system = lp.assemble(model)
    assert system.state_names == ["crank.phi", "crank.w"]
    rng = np.random.default_rng(4)
    for phi, w in rng.uniform(-9, 9, (20, 2)):
        values = dict(zip(("crank.J", "slider.m", "torque.tau"), rng.uniform(1, 9, 3), strict=True))
        values |= {f"rod.{name}": (i + 1) * rng.uniform(0.5, 0.9) for i, name in enumerate(names)}
        expected = np.asarray(by_hand(phi, w, *values.values())).ravel()
        received = np.asarray(system.rhs([phi, w], system.theta(values), 0.0, [])).ravel()
        assert received == pytest.approx(expected, rel=1e-12)
