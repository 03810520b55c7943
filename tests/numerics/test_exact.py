"""method='exact' against closed forms and matrices written here."""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from checks import apart
from drive_chains import in_turn
from rows import assemble_rows, in_a_row
from scipy.sparse import csc_array

import lumped as lp
from lumped.components import (
    BearingFriction,
    EllipticalGear,
    Fixed,
    Inertia,
    NonlinearSpring,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.errors import OptionError, SolverError
from lumped.numerics.closed_form import ClosedForm, _phis
from lumped.ops import sin, where

EPS = np.finfo(float).eps


PARTS = {
    "wall": Fixed(),
    "bar": Spring(c=3.1e4),
    "disc": Inertia(J=1.0),
    "drive": Torque(tau=0.0),
}
PENDULUM = in_a_row(**PARTS)
"""Disc on a torsion bar."""


def test_a_hundred_thousand_periods_drift_by_rounding_of_the_frequency_only():
    w = np.sqrt(np.longdouble(3.1e4))
    until = float(1e5 * 2 * np.pi / w)
    system = lp.assemble(PENDULUM)
    run = lp.simulate(system, until=until, start={"disc.w": 1.0}, method="exact", grid=997)
    expected = np.sin(w * run.t.astype(np.longdouble)) / w
    assert apart(run["bar.phi_rel"], expected) < EPS * float(w) * until
    energy = 3.1e4 * run["bar.phi_rel"] ** 2 + run["disc.w"] ** 2
    assert energy == pytest.approx(np.ones_like(energy), rel=1e-13)
    assert run.steps == 1


def test_a_chain_of_five_hundred_bodies_carries_the_torsional_wave():
    n, c, J = 500, 1.0e4, 1.0
    bodies = [Inertia(J=J, w=float(i == 0)) for i in range(n)]
    system = lp.assemble(in_turn(body=bodies, shaft=[Spring(c=c) for _ in range(n - 1)]))
    run = lp.simulate(system, until=30.0, method="exact", grid=60)
    k = np.arange(1, n)
    w = 2 * np.sqrt(c / J) * np.sin(k * np.pi / (2 * n))
    for i in (0, 417, n - 1):
        shape = 2 / n * np.cos(k * np.pi / (2 * n)) * np.cos((i + 0.5) * k * np.pi / n)
        expected = 1 / n + np.cos(np.outer(run.t, w)) @ shape
        error = np.abs(run[f"body[{i}].w"] - expected).max()
        print(f"body {i}: {error:.1e}")
        assert error < 1e-12


def test_pieces_of_polynomials_kept_angles_and_double_roots():
    """A free disc under a torque t^2 that stops; a critically damped one whose torque jumps."""
    t0, c, d = 1.25, 100.0, 20.0

    system = assemble_rows(
        "free push",
        "wall bar disc pull",
        free=Inertia(J=2.0),
        push=Torque(tau=where(lp.time >= t0, 0.0, 3 * lp.time**2)),
        wall=Fixed(),
        bar=SpringDamper(c=c, d=d),
        disc=Inertia(J=1.0),
        pull=Torque(tau=where(lp.time >= t0, 7.0, 0.0)),
        keep=["free.phi"],
    )
    run = lp.simulate(system, until=3.0, method="exact", start={"disc.w": 1.0})
    t = run.t
    early = np.minimum(t, t0)
    late = np.maximum(t - t0, 0)
    assert apart(run["free.w"], early**3 / 2) < 1e-14
    assert apart(run["free.phi"], early**4 / 8 + late * t0**3 / 2) < 1e-14
    response = 7 / c * (1 - np.exp(-10 * late) * (1 + 10 * late))
    assert apart(run["disc.phi"], t * np.exp(-10 * t) + response) < 1e-12
    assert len(run.pieces) == 2


def exponential(a):
    """Exponential of a matrix with 70 digits."""
    halvings = max(0, math.ceil(math.log2(float(abs(a).sum(axis=1).max())))) + 4
    term = total = digits(np.eye(len(a)))
    for i in range(1, 30):
        term = term.dot(a / 2**halvings) / i
        total = total + term
    for _ in range(halvings):
        total = total.dot(total)
    return total


def digits(a):
    """Numbers as they are, with 70 digits."""
    return np.array([[Decimal(float(v)) for v in row] for row in a], dtype=object)


def test_rounding_is_no_greater_than_estimated_in_stiff_and_damped_chains():
    rng = np.random.default_rng(1)
    twist = np.diff(np.eye(4), axis=0)
    with localcontext() as context:
        context.prec = 70
        for _ in range(40):
            J, c = 10 ** rng.uniform(-3, 1, 4), 10 ** rng.uniform(0, 9, 3)
            d = 10 ** rng.uniform(-2, 6, 3) * rng.integers(0, 2, 3)
            force = np.hstack([twist.T * c, (twist.T * d) @ twist]) / -J[:, None]
            a = np.vstack([np.hstack([np.zeros((3, 3)), twist]), force])
            x = np.concatenate([np.zeros(3), rng.normal(size=4)])
            form = ClosedForm(csc_array(a))
            received = form.solve(x, np.zeros((1, 7)), np.linspace(0, 1, 11)[1:])
            step, z = exponential(digits(a) * Decimal("0.1")), digits(x[:, None])
            for row in received:
                z = step.dot(z)
                error = np.abs(row - z.ravel().astype(float))[3:].max() / np.abs(x).max()
                assert error <= form.rounding(1.0), form.words


def test_phi_functions_hold_their_recurrence_and_their_limits():
    z = np.array([0, 1e-9, 0.3j, 0.999, -1.001, 40j, -700.0, 1e5j], dtype=complex)
    found = _phis(z.copy(), 4)
    assert found[0] == pytest.approx(np.exp(z), rel=1e-14)
    assert found[1][1:] == pytest.approx(np.expm1(z[1:]) / z[1:], rel=1e-13)
    assert [f[0] for f in found] == pytest.approx([1, 1, 1 / 2, 1 / 6, 1 / 24], rel=1e-15)
    for k, factorial in enumerate((1, 1, 2, 6)):
        assert found[k + 1] * z == pytest.approx(found[k] - 1 / factorial, rel=1e-12, abs=1e-14)


def test_parts_of_a_drive_are_solved_by_themselves():
    form = ClosedForm(csc_array(np.diag([-1.0, -1e6])))
    found = form.solve(np.array([2.0, 3.0]), np.array([[1.0, 1e6]]), np.array([0.5, 1.0]))
    assert found[:, 0] == pytest.approx(1 + np.exp([-0.5, -1.0]), rel=1e-15)
    assert found[:, 1] == pytest.approx([1, 1], rel=1e-15)


class Ageing(lp.Component):
    """Damper that grows with the time."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()

    def equations(self):
        a, b = self.flange_a, self.flange_b
        yield a.tau + b.tau == 0
        yield b.tau == lp.time * (lp.der(b.phi) - lp.der(a.phi))


HARDENING = NonlinearSpring(characteristic=lambda twist: twist + twist**3)
RUBBING = in_a_row(**PARTS, rub=BearingFriction(characteristic=((0.0, 0.3),)))
GEARED = in_a_row(**PARTS, gear=EllipticalGear(e=0.3), load=Inertia(J=1.0))


@pytest.mark.parametrize(
    ("model", "named"),
    [
        (RUBBING, "modes depend on states, in rub"),
        (GEARED, "what its states lead is not linear"),
        (PENDULUM.with_({"bar": HARDENING}), "derivatives of disc.w are not linear"),
        (PENDULUM.with_({"drive.tau": sin(lp.time)}), "drives disc.w is no polynomial"),
        (PENDULUM.with_({"bar": Ageing()}), "of disc.w are not linear .* constant coefficients"),
    ],
)
def test_what_is_not_linear_is_named(model, named):
    with pytest.raises(OptionError, match=named):
        lp.simulate(lp.assemble(model), until=1.0, method="exact")


def test_rounding_that_spoils_the_result_is_an_error():
    system = lp.assemble(PENDULUM)
    with pytest.raises(SolverError, match=r"rounding may reach .* method='auto'"):
        lp.simulate(system, until=1e9, start={"disc.w": 1.0}, method="exact", grid=[1e9])


LONG = {"until": 10.0}


@pytest.mark.parametrize(
    ("changes", "options", "method"),
    [
        ({}, {}, "explicit"),
        ({}, LONG, "exact"),
        ({}, {**LONG, "grid": None}, "explicit"),
        ({}, {**LONG, "method": "steps"}, "explicit"),
        ({}, {**LONG, "rtol": 1e-14}, "explicit"),  # rounding is no better
        ({"drive.tau": sin(lp.time)}, {}, "explicit"),
        (
            {"bar": SpringDamper(c=1e4, d=1e6), "drive.tau": sin(lp.time)},
            {},
            "explicit then implicit",
        ),
        ({"bar": SpringDamper(c=1e4, d=1.0), "drive.tau": sin(lp.time)}, {}, "explicit"),
    ],
)
def test_auto_takes_what_pays_and_says_so(changes, options, method):
    system = lp.assemble(PENDULUM.with_(changes))
    run = lp.simulate(system, **{"until": 0.2, "start": {"disc.w": 1.0}, **options})
    assert run.statistics.method == method
    assert f"{method}, {run.steps} steps" in repr(run)
    assert (run.statistics.why in repr(run)) == (method in ("exact", "explicit then implicit"))


def test_the_choice_depends_on_the_drive_and_not_on_runs_before():
    """The stiffer bar turns through a hundred times more radians."""
    system, start = lp.assemble(PENDULUM), {"disc.w": 1.0}
    told = []
    for c in (3.1e4, 3.1e8, 3.1e4, 3.1e8):
        run = lp.simulate(system, until=0.2, start=start, parameters={"bar.c": c}, rtol=1e-7)
        w = np.sqrt(c)
        assert apart(run["bar.phi_rel"], np.sin(w * run.t) / w) < 2e-5 / w
        told.append(run.statistics.method)
    assert told == ["explicit", "exact"] * 2
