"""Functions of a plant, compiled and interpreted, against CasADi's own evaluation."""

import ctypes

import casadi as ca
import casadi_operations
import numpy as np
import pytest
from machine_scenes import SCENES

from lumped.code.functions import Columns, compile_columns, compile_functions
from lumped.code.operations import UnsupportedError, operations_of
from lumped.kernel import engine

_CALL = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p
)

ONE = casadi_operations.ONE | {"constant power": lambda a: a**1.7}
TWO = casadi_operations.TWO | {
    "equal": lambda a, b: a == b,
    "not equal": lambda a, b: a != b,
    "and": ca.logic_and,
    "or": ca.logic_or,
}
SPECIAL = np.array([0.0, -0.0, 1.0, -1.0, 0.5, 2.0, np.inf, -np.inf, np.nan, 1e-310, 1e300])

EPS = np.finfo(float).eps


class Ways:
    """A function in machine code, and interpreted by each engine."""

    def __init__(self, function, full=True):
        self.own = operations_of(function, full=full)
        self.code = compile_functions({"f": self.own})
        self.count = self.own.results

    def __call__(self, x, p, t, m, engines=("llvm", "c", "python")):
        held = [np.ascontiguousarray(v, dtype=float).ravel() for v in (x, p, m)]
        places = [v.ctypes.data for v in held]
        compiled = np.zeros(max(self.count, 1))
        _CALL(self.code.address("f"))(*places[:2], float(t), places[2], compiled.ctypes.data)
        for name in engines:
            with engine.using(name):
                same(casadi_operations.interpret(self.own, held[0], held[1], t, held[2]), compiled)
        return compiled[: self.count]


def expected(function, *arguments):
    results = function.call([ca.DM(a) for a in arguments])
    return np.concatenate([np.array(r.nonzeros(), dtype=float) for r in results])


def same(received, wanted):
    """Equal to the last digit, signs of zero and all that is no number included."""
    np.testing.assert_array_equal(received, wanted)


def close(received, wanted, rounding=0.0):
    """Equal but for the last digits of sines, which are computed here and not in the C library."""
    is_finite = np.isfinite(wanted)
    size = np.abs(wanted[is_finite]).max(initial=0.0)
    np.testing.assert_array_equal(received[~is_finite], wanted[~is_finite])
    tolerated = 1e-12 * np.abs(wanted) + 1e-13 * size + rounding
    is_far = is_finite & ~(np.abs(received - wanted) <= tolerated)
    assert not is_far.any(), (received[is_far], wanted[is_far])


def by_rounding(function, x, p, t, m):
    """What the last digits of states and parameters change: terms that cancel make much of them."""
    rng, wanted = np.random.default_rng(1), expected(function, x, p, t, m)
    found = np.zeros(len(wanted))
    for _ in range(4):
        moved = [v * (1 + EPS * rng.choice([-1, 1], size=len(v))) for v in (x, p)]
        found = np.fmax(found, np.abs(expected(function, *moved, t, m) - wanted))
    return 4 * found


@pytest.fixture
def symbols():
    return [ca.SX.sym("x", 2), ca.SX.sym("p", 1), ca.SX.sym("t"), ca.SX.sym("m", 1)]


@pytest.mark.parametrize("name", ONE)
def test_operations_of_one_number(name, symbols):
    x, p, _, _ = symbols
    function = ca.Function("f", symbols, [ca.vertcat(ONE[name](x[0]), ONE[name](p))])
    ways = Ways(function)
    numbers = [*np.random.default_rng(1).uniform(-3, 3, 30), *SPECIAL]
    for number in numbers:
        arguments = ([number, 0.0], [number / 3], 0.0, [0.0])
        (close if name in ("sin", "cos") else same)(
            ways(*arguments), expected(function, *arguments)
        )


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sines_are_right_to_two_units_in_the_last_place(name, symbols):
    x, p, _, _ = symbols
    ways = Ways(ca.Function("f", symbols, [ca.vertcat(ONE[name](x[0]), ONE[name](p))]))
    rng, worst = np.random.default_rng(5), 0.0
    quarters = np.arange(-40, 41) * (np.pi / 2)
    numbers = [
        *quarters,
        *(s * v for s in (1e-9, 1.0, 10.0, 1e3, 1e6) for v in rng.uniform(-1, 1, 99)),
    ]
    for number in numbers:
        received = ways([number, 0.0], [-number], 0.0, [0.0], ("python",))
        for found, angle in zip(received, (number, -number), strict=True):
            true = getattr(np, name)(np.longdouble(angle))
            worst = max(worst, float(abs(found - true) / np.spacing(abs(float(true)))))
    assert worst < 2.0
    for number in (1e7, -3e15, 1e300):
        arguments = ([number, 0.0], [number / 3], 0.0, [0.0])
        same(ways(*arguments), [getattr(np, name)(number), getattr(np, name)(number / 3)])


@pytest.mark.parametrize("name", TWO)
def test_operations_of_two_numbers(name, symbols):
    x, _, t, m = symbols
    results = ca.vertcat(TWO[name](x[0], x[1]), TWO[name](t, m))
    function = ca.Function("f", symbols, [results])
    ways = Ways(function)
    rng = np.random.default_rng(2)
    pairs = [*rng.uniform(-3, 3, (30, 2)), *((a, b) for a in SPECIAL for b in SPECIAL)]
    for a, b in pairs:
        arguments = ([a, b], [0.0], a, [b])
        same(ways(*arguments), expected(function, *arguments))


@pytest.mark.parametrize("on_stack", [True, False])
def test_a_function_longer_than_a_chunk_hands_its_numbers_on(on_stack, symbols, monkeypatch):
    if not on_stack:
        monkeypatch.setattr("lumped.code.emit_llvm._MOST_ON_STACK", 0)
    x, p, t, m = symbols
    values, rng = [x[0], x[1], p, t, m], np.random.default_rng(3 + on_stack)
    for _ in range(3000):
        i, j = rng.integers(0, len(values), 2)
        values.append(ca.sin(values[i]) + rng.uniform(-1, 1) * values[j])
    chosen = ca.vertcat(*(values[i] for i in rng.integers(0, len(values), 200)))
    function = ca.Function("f", symbols, [chosen, ca.sum1(chosen)])
    ways = Ways(function)
    arguments = (rng.normal(size=2), rng.normal(size=1), 0.3, rng.normal(size=1))
    close(ways(*arguments), expected(function, *arguments))


def test_columns_side_by_side_and_half_of_those_of_the_last_results():
    x, p, t, m = symbols = [ca.SX.sym(*v) for v in (("x", 3), ("p", 1), ("t", 1), ("m", 1))]
    begin = 1
    by_rows = ca.vertcat(x[begin] * ca.sin(x[0]) + x[begin + 1], x[begin] * p[0], x[begin] * t)
    own = operations_of(ca.Function("f", symbols, [by_rows]))
    columns, halved = 6, 1
    code = compile_columns(own, Columns(columns, begin, halved))
    rng = np.random.default_rng(4)
    point, wide = rng.normal(size=begin), rng.normal(size=(2, columns))
    settings, more = rng.normal(size=m.numel()), rng.normal(size=p.numel())
    given = np.concatenate([point, wide.ravel()])
    found = np.full(columns + 2 * columns // 2 + 1, np.nan)
    places = [v.ctypes.data for v in (given, more, settings, found)]
    _CALL(code.address("columns"))(*places[:2], 0.7, *places[2:])
    assert found[:columns] == pytest.approx(wide[0] * np.sin(point[0]) + wide[1], rel=1e-14)
    assert (found[6:9] == wide[0, :3] * more[0]).all()
    assert (found[9:12] == wide[0, :3] * 0.7).all()
    assert np.isnan(found[12])


def test_what_is_not_made_of_scalar_operations_is_refused(symbols):
    x, p, t, m = (ca.MX.sym("s", *s.shape) for s in symbols)
    function = ca.Function("f", [x, p, t, m], [ca.mtimes(x, x.T)])
    with pytest.raises(UnsupportedError):
        operations_of(function)


@pytest.mark.parametrize("name", SCENES)
def test_functions_of_the_machines(name):
    run = SCENES[name](grid=20)
    system, rng = run.system, np.random.default_rng(4)
    functions = {
        name: getattr(system, name)
        for name in ("rhs", "jacobian", "look", "margins", "margin_rates")
    }
    ways = {name: Ways(function, full=False) for name, function in functions.items()}
    for piece in run.pieces:
        if piece.system is not system:
            continue
        for k in range(0, len(piece.t), 4):
            x = piece.x[k] * (1 + 1e-3 * rng.normal(size=piece.x.shape[1]))
            arguments = (x, run.theta, piece.t[k], piece.settings[k])
            for each, function in functions.items():
                engines = ("llvm", "c", "python") if k == 0 else ("llvm", "c")
                wanted, rounding = expected(function, *arguments), by_rounding(function, *arguments)
                close(ways[each](*arguments, engines), wanted, rounding)
