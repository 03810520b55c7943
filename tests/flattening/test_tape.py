"""Arithmetic on a tape against the same in Python."""

import operator

import casadi as ca
import numpy as np
import pytest

from lumped.flattening.tape import Tape

OPERATORS = [operator.add, operator.sub, operator.mul, operator.truediv]


@pytest.mark.parametrize("seed", range(10))
def test_a_random_programme_gives_what_python_gives(seed):
    rng = np.random.default_rng(seed)
    tape, x = Tape(), ca.SX.sym("x", 5)
    at = rng.uniform(1, 2, 5)
    terms, expected = tape.add_terms(x), at.tolist()
    for _ in range(40):
        i, j = rng.integers(0, len(terms), 2)
        if rng.random() < 0.1:
            terms.append(-terms[i])
            expected.append(-expected[i])
        elif rng.random() < 0.1:
            u = ca.SX.sym("u", 2)
            rotated = ca.Function("r", [u], [ca.vertcat(u[0] + u[1], u[0] - u[1])])
            terms += tape.call(rotated, [terms[i], terms[j]])
            expected += [expected[i] + expected[j], expected[i] - expected[j]]
        else:
            op = OPERATORS[rng.integers(4)]
            if op is operator.truediv and abs(expected[j]) < 1e-3:
                continue
            terms.append(op(terms[i], terms[j]))
            expected.append(op(expected[i], expected[j]))
    function = ca.Function("f", [x], [tape.expressions(terms)])
    received = np.asarray(function(at)).ravel()
    assert received == pytest.approx(np.array(expected), rel=1e-13, abs=1e-13)


def test_constants_are_folded():
    tape, x = Tape(), ca.SX.sym("x")
    (term,) = tape.add_terms(x)
    (one,) = tape.add_terms(ca.SX(1))
    received = tape.expressions([tape.zero - term * one / one, term * tape.zero])
    assert received[1].is_zero()
    assert ca.Function("f", [x], [received]).n_nodes() <= 2 + 1 + 2  # x, -x, 0 and two outputs
