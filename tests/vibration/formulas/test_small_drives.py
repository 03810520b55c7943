"""Formulas of twelve drives against matrices that are assembled here, at 100 sets of parameters."""

from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np
import pytest
import scipy
from docutils.utils.math.latex2mathml import tex2mathml

import lumped as lp
from lumped.components import Damper, Fixed, IdealGear, Inertia, Spring, SpringDamper, Torque

SETS = 100
LINES = 40


@dataclass
class Drive:
    """Bodies on shafts ``(from, to, gear)``: None is the ground, a gear stands before its shaft."""

    bodies: int
    shafts: tuple
    damped: bool = False
    dampers: tuple = ()

    def system(self):
        kind = SpringDamper if self.damped else Spring
        values = {"c": 3e3, "d": 2.0} if self.damped else {"c": 3e3}
        geared = [k for k, (*_, gear) in enumerate(self.shafts) if gear]

        def ends(m, i, j):
            return m.body[i].flange_b, m.ground.flange if j is None else m.body[j].flange_a

        def connections(m):
            yield lp.connect(m.load.flange, m.body[0].flange_a)
            for k, (i, j, gear) in enumerate(self.shafts):
                a, b = ends(m, i, j)
                between = (m.gear[geared.index(k)], m.shaft[k]) if gear else (m.shaft[k],)
                yield from lp.chain(a, *between, b)
            for damper, (i, j) in zip(getattr(m, "damper", ()), self.dampers, strict=True):
                a, b = ends(m, i, j)
                yield from lp.chain(a, damper, b)

        parts = {"gear": [IdealGear(ratio=2.0) for _ in geared]} if geared else {}
        if any(j is None for _, j, *_ in (*self.shafts, *self.dampers)):
            parts["ground"] = Fixed()
        if self.dampers:
            parts["damper"] = [Damper(d=1.0) for _ in self.dampers]
        return lp.assemble(
            lp.compose(
                body=[Inertia(J=1.0) for _ in range(self.bodies)],
                shaft=[kind(**values) for _ in self.shafts],
                load=Torque(tau=1.0),
                **parts,
                connections=connections,
            )
        )

    def matrices(self, p):
        """M, C and K at a set of parameters."""
        M = np.diag([p[f"body[{i}].J"] for i in range(self.bodies)])
        C, K = np.zeros_like(M), np.zeros_like(M)
        ratios = iter(range(len(self.shafts)))
        for k, (i, j, gear) in enumerate(self.shafts):
            twist = np.zeros(self.bodies)
            twist[i] = -1 / p[f"gear[{next(ratios)}].ratio"] if gear else -1
            if j is not None:
                twist[j] = 1
            K += p[f"shaft[{k}].c"] * np.outer(twist, twist)
            if self.damped:
                C += p[f"shaft[{k}].d"] * np.outer(twist, twist)
        for k, (i, j) in enumerate(self.dampers):
            twist = np.zeros(self.bodies)
            twist[i] = -1
            if j is not None:
                twist[j] = 1
            C += p[f"damper[{k}].d"] * np.outer(twist, twist)
        return M, C, K


def in_row(n, gears=(), end=()):
    return (*((i, i + 1, i in gears) for i in range(n - 1)), *end)


BRANCHED = ((0, 1, False), (1, 2, True), (1, 3, False), (3, 4, False), (3, 5, True))
DRIVES = {
    "two": Drive(2, in_row(2)),
    "two damped": Drive(2, in_row(2), damped=True),
    "three geared": Drive(3, in_row(3, gears=(1,))),
    "three grounded damped": Drive(3, in_row(3, end=((2, None, False),)), damped=True),
    "four in a ring": Drive(4, in_row(4, end=((3, 0, False),))),
    "four with dampers alone": Drive(4, in_row(4), dampers=((0, 2), (3, None))),
    "five geared": Drive(5, in_row(5, gears=(0, 2))),
    "five geared damped": Drive(5, in_row(5, gears=(1,)), damped=True),
    "six branched": Drive(
        6, ((0, 1, False), (1, 2, True), (1, 3, False), (3, 4, False), (3, 5, True))
    ),
    "seven branched damped": Drive(7, (*BRANCHED, (5, 6, False)), damped=True),
    "eight": Drive(8, in_row(8)),
    "eight geared damped": Drive(8, in_row(8, gears=(2, 5)), damped=True),
}


@cache
def of(name):
    return lp.vibration.symbolic(DRIVES[name].system())


@cache
def parameter_sets(name):
    rng = np.random.default_rng(sum(map(ord, name)))
    ranges = {"J": (0.3, 3.0), "c": (1e3, 1e4), "d": (0.5, 5.0), "ratio": (0.4, 3.0)}
    found = {}
    for key in of(name).system.parameters:
        kind = key.rpartition(".")[2]
        if kind in ranges:
            found[key] = np.exp(rng.uniform(*np.log(ranges[kind]), SETS))
    return found


def each_set(name):
    sets = parameter_sets(name)
    for k in range(SETS):
        yield {key: values[k] for key, values in sets.items()}


def eigenvalues(M, C, K):
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [np.linalg.solve(M, -K), np.linalg.solve(M, -C)]])
    return scipy.linalg.eigvals(A)


def squares(M, K):
    return scipy.linalg.eigh(K, M, eigvals_only=True)


def is_readable(formula):
    lines = str(formula).splitlines()
    return len(lines) <= LINES and max(map(len, lines)) <= 100


@pytest.mark.parametrize("name", DRIVES)
def test_matrices_are_those_of_the_book(name):
    drive, found = DRIVES[name], of(name)
    order = [int(c[5:-1]) for c in found.coordinates]
    sets = parameter_sets(name)
    for p in [{key: values[k] for key, values in sets.items()} for k in range(5)]:
        for formula, expected in zip((found.M, found.C, found.K), drive.matrices(p), strict=True):
            expected = expected[np.ix_(order, order)]
            used = {key: value for key, value in p.items() if key in formula.names}
            received = np.array(formula(used), dtype=float)
            assert received == pytest.approx(
                expected, rel=1e-13, abs=1e-13 * np.abs(expected).max()
            )


@pytest.mark.parametrize("name", DRIVES)
def test_the_polynomial_has_the_eigenvalues_as_its_roots(name):
    """Two polynomials with the same values at more points than their degree are the same."""
    drive, polynomial = DRIVES[name], of(name).polynomial
    assert is_readable(polynomial)
    sets = parameter_sets(name)
    known = {key: values for key, values in sets.items() if key in polynomial.names}
    if polynomial.name == "p(lambda)":
        roots = np.array([squares(m, k) for m, _, k in map(drive.matrices, each_set(name))])
        variable, rigid = "lambda", roots[:, 0].max() < 1.0
        roots = roots[:, 1:] if rigid else roots
    else:
        roots = np.array([eigenvalues(*drive.matrices(p)) for p in each_set(name)])
        variable = "s"
    scale = np.abs(roots).max(axis=1)
    points = scale[:, None] * 1.3 * np.exp(2j * np.pi * (np.arange(17) + 0.3) / 17)
    given = {key: values[:, None] for key, values in known.items()}
    received = polynomial({**given, variable: points})
    expected = np.prod(points[:, :, None] - roots[:, None, :], axis=2)
    # roots at zero, of rigid motions, are left out
    missing = np.log(np.abs(expected / received)[0, 0]) / np.log(np.abs(points[0, 0]))
    assert missing == pytest.approx(round(missing), abs=0.05)
    ratio = expected / (received * points ** round(missing))
    assert np.abs(ratio - 1).max() < 1e-10


CLOSED = [name for name in DRIVES if not DRIVES[name].damped and DRIVES[name].bodies <= 5]
CLOSED.remove("four with dampers alone")


@pytest.mark.parametrize("name", CLOSED)
def test_closed_frequencies_agree_with_the_eigenvalues(name):
    formulas, worst = of(name).frequencies, 0.0
    assert all(map(is_readable, formulas))
    sets = parameter_sets(name)
    received = np.array(
        [f({key: values for key, values in sets.items() if key in f.names}) for f in formulas]
    ).T
    for found, p in zip(received, each_set(name), strict=True):
        M, _, K = DRIVES[name].matrices(p)
        expected = np.sqrt(squares(M, K)[1:])
        worst = max(worst, np.abs(found / expected - 1).max())
    assert worst < 1e-10


def test_one_damped_mode_has_a_closed_frequency():
    (formula,) = of("two damped").frequencies
    for p in each_set("two damped"):
        value = formula({key: x for key, x in p.items() if key in formula.names})
        expected = np.abs(eigenvalues(*DRIVES["two damped"].matrices(p))).max()
        assert value == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("name", DRIVES)
def test_transfer_functions_agree_with_dynamic_stiffness(name):
    drive, k = DRIVES[name], len(DRIVES[name].shafts) - 1
    formula = of(name).transfer("load.tau", f"shaft[{k}].tau")
    assert is_readable(formula)
    i, j, gear = drive.shafts[k]
    for p in each_set(name):
        M, C, K = drive.matrices(p)
        s = 0.07 * np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(M, K))).max()) * (0.4 + 1j)
        q = np.linalg.solve(s**2 * M + s * C + K, np.eye(len(M))[0])
        last = sum(g for *_, g in drive.shafts[:k])
        twist = (0 if j is None else q[j]) - q[i] / (p[f"gear[{last}].ratio"] if gear else 1)
        law = p[f"shaft[{k}].c"] + s * (p[f"shaft[{k}].d"] if drive.damped else 0)
        received = formula({"s": s, **{key: v for key, v in p.items() if key in formula.names}})
        assert received == pytest.approx(law * twist, rel=1e-10)


@pytest.mark.parametrize("name", DRIVES)
def test_slopes_by_modes_agree_with_differences(name):
    found, drive = of(name), DRIVES[name]
    sets = [p for p, _ in zip(each_set(name), range(5), strict=False)]
    for parameter in ("body[1].J", "shaft[0].c", *(["shaft[0].d"] if drive.damped else [])):
        formula = found.slope(parameter)
        assert is_readable(formula)
        for p in sets:
            mode = found.mode(1 if drive.bodies > 2 else 0, parameters=p)
            given = {k: v for k, v in {**p, **mode}.items() if k in formula.names}
            root = mode.get("s", 1j * mode.get("omega", 0))
            moved = []
            for step in (-2, -1, 1, 2):
                near = dict(p)
                near[parameter] *= 1 + step * 2e-4
                values = eigenvalues(*drive.matrices(near))
                moved.append(values[np.abs(values - root).argmin()])
            h = 2e-4 * p[parameter]
            slope = (moved[0] - 8 * moved[1] + 8 * moved[2] - moved[3]) / (12 * h)
            expected = slope if "s" in mode else slope.imag
            size = abs(root) / p[parameter]
            assert abs(formula(given) - expected) < 1e-9 * size


@pytest.mark.parametrize("name", ["three geared", "five geared damped"])
def test_all_ways_of_writing_say_the_same(name):
    formula = of(name).polynomial
    p = {key: float(v[0]) for key, v in parameter_sets(name).items() if key in formula.names}
    variable = formula.name[2:-1]
    numbers = {**p, variable: 3.0e3}
    value = formula(numbers)
    graph = formula.casadi
    symbols = ca.symvar(graph)
    function = ca.Function("f", symbols, [graph])
    assert float(function(*(numbers[x.name()] for x in symbols))) == pytest.approx(value, rel=1e-12)
    names = {}
    exec(formula.code(), names)
    ordered = [numbers[x] for x in formula.names]
    (call,) = [f for f in names.values() if callable(f) and f.__module__ != "math"] or [names["p"]]
    assert call(*ordered) == pytest.approx(value, rel=1e-12)
    assert tex2mathml(formula.latex(), as_block=True).startswith("<math")


@pytest.mark.parametrize("name", ["three geared", "four in a ring", "five geared"])
def test_closed_frequencies_have_the_slopes_of_their_modes(name):
    """Two formulations: the derivative of the closed formula, and Rayleigh's quotient of a mode."""
    found = of(name)
    p = next(each_set(name))
    for k, formula in enumerate(found.frequencies):
        symbols = ca.symvar(formula.casadi)
        slopes = ca.Function("slopes", symbols, [ca.gradient(formula.casadi, ca.vertcat(*symbols))])
        received = np.array(slopes(*(p[x.name()] for x in symbols))).ravel()
        mode = found.mode(k, parameters=p)
        for symbol, value in zip(symbols, received, strict=True):
            key = symbol.name()
            expected = found.slope(key)({**p, **mode})
            assert abs(value - expected) < 1e-9 * mode["omega"] / p[key]
