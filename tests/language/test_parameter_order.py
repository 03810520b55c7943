"""Parameters that have another parameter of their component as lower limit."""

import pytest

import lumped as lp
from lumped.errors import ParameterError


class Window(lp.Component):
    """A range: ``y = high - low``."""

    high_first: lp.Param = lp.param("N", "unrelated", 0.0)
    low: lp.Param = lp.param("N", "lower end", 1.0)
    high: lp.Param = lp.param("N", "upper end", 2.0, above=low)
    y = lp.Output("N", "width")

    def equations(self):
        yield self.y == self.high - self.low


class Frame(lp.Component):
    """Two windows, one of them bound."""

    scale: lp.Param = lp.param("1", "scale", 1.0)
    left: Window = Window()
    right: Window = Window(low=lp.ops.sqrt(scale), high=3 - scale)


def test_ends_in_order_are_taken():
    received = lp.start_point(lp.assemble(Frame(left=Window(low=-4.0, high=-3.9))))["left.y"]
    expected = pytest.approx(0.1)
    assert received == expected


@pytest.mark.parametrize("high", [1.0, 0.5])
def test_crossed_or_equal_ends_are_refused_with_both_paths(high):
    text = rf"left\.high = {high:g} N \(upper end\) must be greater than left\.low = 1 N \(lower"
    with pytest.raises(ParameterError, match=text):
        lp.assemble(Frame(left=Window(high=high)))


def test_bound_ends_that_cross_are_refused():
    with pytest.raises(ParameterError, match=r"right\.high = -1 N .* right\.low = 2 N"):
        lp.assemble(Frame(scale=4.0))


def test_ends_that_cross_for_one_run_are_refused():
    system = lp.assemble(Frame())
    with pytest.raises(ParameterError, match=r"left\.high = 2 N .* left\.low = 7 N"):
        lp.start_point(system, parameters={"left.low": 7.0})


class Step(lp.Component):
    """Two levels: ``y = high - low``."""

    low: lp.Param = lp.param("N", "lower level", 1.0)
    high: lp.Param = lp.param("N", "upper level", 2.0, min=low)
    y = lp.Output("N", "height")

    def equations(self):
        yield self.y == self.high - self.low


def test_ends_may_be_equal_where_the_lower_one_is_the_least_value():
    received = lp.start_point(lp.assemble(lp.compose(part=Step(high=1.0))))["part.y"]
    expected = 0.0
    assert received == expected
    text = r"part\.high = 0.5 N \(upper level\) must be at least part\.low = 1 N \(lower level\)"
    with pytest.raises(ParameterError, match=text):
        lp.assemble(lp.compose(part=Step(high=0.5)))
