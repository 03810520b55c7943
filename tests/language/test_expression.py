import pytest

import lumped as lp
from lumped.errors import EquationError
from lumped.language.expression import text


class Part(lp.Component):
    """Something with two variables: x = y."""

    x: lp.Var = lp.var("1", "first")
    y: lp.Var = lp.var("1", "second")


x, y = Part().x, Part().y


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (x + y * 2, "x + y * 2"),
        ((x + y) * 2, "(x + y) * 2"),
        (x - (y - 1), "x - (y - 1)"),
        (x / (y * 2), "x / (y * 2)"),
        (-(x + y), "-(x + y)"),
        ((-x) ** 2, "(-x)**2"),
        (2**x, "2**x"),
        (lp.ops.atan2(x, y), "atan2(x, y)"),
        (lp.der(x * y), "der(x * y)"),
        (lp.ops.where(lp.time >= 1, x, 0), "where(time >= 1, x, 0)"),
        (abs(x), "abs(x)"),
    ],
)
def test_expressions_print_as_written(expression, expected):
    assert text(expression) == expected


def test_equal_sides_stay_an_equation():
    received = x == x
    assert repr(received) == "x == x"


@pytest.mark.parametrize(
    ("use", "hint"),
    [
        (lambda: float(x), "symbol, not a number"),
        (lambda: bool(x), "no truth value"),
        (lambda: x in [y], "truth value"),
        (lambda: list(x), "cannot be iterated"),
        (lambda: x + "1 m", "cannot stand in an equation"),
        (lambda: x != y, "write =="),
        (lambda: lp.ops.where(True, x, y), "must be a relation"),
        (lambda: lp.der(3.0), "time derivative"),
        (lambda: lp.ops.table([0, 1, 0.5], [0, 1, 2]), "must not decrease"),
        (lambda: lp.ops.table([0, 1], [0]), "2 times and 1 values"),
    ],
)
def test_slips_get_an_error_that_says_what_to_write(use, hint):
    with pytest.raises((EquationError, TypeError), match=hint):
        use()


def test_text_and_lowering_have_no_recursion_limit():
    total = x
    for _ in range(20_000):
        total = total + y
    assert text(total).count("y") == 20_000
