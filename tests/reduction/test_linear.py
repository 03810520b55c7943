"""The symbolic linear solver against NumPy."""

import casadi as ca
import numpy as np
import pytest
from checks import worst

from lumped.flattening.residual import CONSTANT, PARAMETRIC, VARYING
from lumped.flattening.tape import Tape
from lumped.reduction.elimination import Entry, SingularBlockError, solve


def system_of(matrix, kinds):
    """Rows and right sides with one symbol for each entry; function of entries and right side."""
    n = len(matrix)
    a, b = ca.SX.sym("a", n, n), ca.SX.sym("b", n)
    tape = Tape()
    terms = tape.add_terms(ca.vec(a))
    rows = [
        {
            j: Entry(terms[j * n + i], int(kinds[i, j]), matrix[i, j])
            for j in range(n)
            if matrix[i, j]
        }
        for i in range(n)
    ]
    right = [(term, 1.0 + i) for i, term in enumerate(tape.add_terms(b))]
    solution = solve(rows, right, tape)
    function = ca.Function("x", [a, b], [tape.expressions([x for x, _ in solution])])
    return function, np.array([value for _, value in solution])


@pytest.mark.parametrize("seed", range(30))
def test_random_sparse_systems_are_solved_symbolically_and_at_the_point(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 30))
    matrix = np.where(rng.random((n, n)) < 0.15, rng.normal(size=(n, n)), 0.0)
    matrix[np.arange(n), rng.permutation(n)] = rng.uniform(1, 2, n)
    if np.linalg.cond(matrix) > 1e6:
        pytest.skip("the random matrix happens to be ill-conditioned")
    kinds = rng.choice([CONSTANT, PARAMETRIC, VARYING], (n, n))
    function, at_point = system_of(matrix, kinds)
    right = 1.0 + np.arange(n)
    expected = np.linalg.solve(matrix, right)
    received = np.asarray(function(matrix, right)).ravel()
    assert worst(received, expected) < 1e-9
    assert at_point == pytest.approx(expected, rel=1e-8, abs=1e-9)


def test_varying_coefficients_may_pass_zero_one_by_one():
    rotation = np.array([[0.6, -0.8], [0.8, 0.6]])
    function, _ = system_of(rotation, np.full((2, 2), VARYING))
    for angle in np.arange(0, 2 * np.pi, np.pi / 4):
        c, s = np.cos(angle), np.sin(angle)
        if abs(c) < 1e-12:
            c = 0.0
        if abs(s) < 1e-12:
            s = 0.0
        received = np.asarray(function(np.array([[c, -s], [s, c]]), np.array([1.0, 2.0]))).ravel()
        assert received == pytest.approx([c + 2 * s, -s + 2 * c], abs=1e-14)


@pytest.mark.parametrize("kind", [CONSTANT, PARAMETRIC, VARYING])
def test_a_singular_system_is_refused(kind):
    with pytest.raises(SingularBlockError):
        system_of(np.array([[1.0, 2.0], [2.0, 4.0]]), np.full((2, 2), kind))


@pytest.mark.parametrize("seed", [*range(7), 138, 178, 204])  # the last fail with free pivots
def test_constraints_are_solved_whichever_of_them_hold(seed):
    """``m a + d.T r == f``; each row ``d a == 0`` or ``r == law``, by settings of 0 or 1."""
    rng = np.random.default_rng(seed)
    bodies = int(rng.integers(1, 30))
    mass = rng.uniform(1, 2, bodies)
    ways = np.diag(rng.choice([0.5, 1.0, 2.0], bodies))  # geared to the ground or one before
    for body in range(1, bodies):
        ways[body, rng.integers(body)] = rng.choice([0.0, 0.5, 1.0, 2.0])
    ways = ways[rng.permutation(bodies)[: int(rng.integers(1, 25))]]
    holds = len(ways)
    stuck = ca.SX.sym("stuck", holds)
    n, tape = bodies + holds, Tape()
    upper = ca.horzcat(ca.diag(ca.SX(mass)), ca.SX(ways.T))
    lower = ca.horzcat(ca.diag(stuck) @ ca.SX(ways), ca.diag(1 - stuck))
    terms = tape.add_terms(ca.vec(ca.densify(ca.vertcat(upper, lower))))
    generic = np.block([[np.diag(mass), ways.T], [ways, np.zeros((holds, holds))]])
    kinds = np.where(np.arange(n)[:, None] < bodies, CONSTANT, VARYING)
    present = generic != 0
    present[range(bodies, n), range(bodies, n)] = True
    rows = [
        {
            j: Entry(terms[j * n + i], int(kinds[i, 0]), generic[i, j])
            for j in range(n)
            if present[i, j]
        }
        for i in range(n)
    ]
    force, law = rng.normal(size=bodies), rng.normal(size=holds)
    given = ca.vertcat(ca.SX(force), (1 - stuck) * law)
    point = np.concatenate([force, np.zeros(holds)])
    right = list(zip(tape.add_terms(given), point.tolist(), strict=True))
    solution = solve(rows, right, tape, {bodies + h: bodies + h for h in range(holds)})
    function = ca.Function("x", [stuck], [tape.expressions([x for x, _ in solution])])
    for s in (np.zeros(holds), np.ones(holds), *rng.integers(0, 2, (20, holds))):
        matrix = np.block([[np.diag(mass), ways.T], [s[:, None] * ways, np.diag(1 - s)]])
        expected = np.linalg.solve(matrix, np.concatenate([force, (1 - s) * law]))
        received = np.asarray(function(s)).ravel()
        assert received == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())
