"""Derivatives of the states at the start against differences of starts."""

import numpy as np
import pytest
from checks import worst
from differences import slope
from rows import in_rows

import lumped as lp
from lumped.components import Fixed, Inertia, SpringDamper
from lumped.models.reversing_mill import scenes as mill
from lumped.points.start_slopes import start_slopes


def pulled():
    """Torques of the shafts are given: twists follow from them and the stiffnesses."""
    system = lp.assemble(mill.pull_apart())
    start = dict.fromkeys(mill.SHAFTS, mill.RATED)
    return system, start, ["upper.spindle.c", "upper.shaft.c", "lower.spindle.c", "M_pr"], []


def turning():
    """A speed that is given is an expression of a parameter; a default and a given one vary."""
    speed = lp.param("rad/s", "speed at the start", 0.0)
    model = in_rows(
        "a shaft b rest wall",
        speed=speed,
        a=Inertia(J=1.0, w=2.0 * speed),
        shaft=SpringDamper(c=50.0, d=0.1),
        b=Inertia(J=2.0, w=0.0),
        rest=SpringDamper(c=20.0),
        wall=Fixed(),
    )
    return lp.assemble(model), {"shaft.tau": 3.0}, ["speed", "shaft.c"], ["b.w", "shaft.tau"]


@pytest.mark.parametrize("case", [pulled, turning])
def test_slopes_at_the_start_are_those_of_differences(case):
    system, start, names, values = case()
    known = {name: i for i, name in enumerate(system.parameters)}
    seed = np.zeros((len(known), len(names) + len(values)))
    for column, name in enumerate(names):
        seed[known[name], column] = 1.0
    tree, units = system.structure.tree, np.eye(len(names) + len(values))
    varied = {tree.unknown(v): units[len(names) + i] for i, v in enumerate(values)}
    x, S = start_slopes(system, system.theta(None), start, 0.0, seed, varied)
    assert (x == lp.start_point(system, start=start).x).all()
    size = np.abs(S).max()
    assert size > 0
    for column, name in enumerate([*names, *values]):
        value = {**system.parameters, "b.w": 0.0, **start}[name]

        def begin(x, name=name):
            if name in known:
                return lp.start_point(system, parameters={name: x}, start=start).x
            return lp.start_point(system, start=start | {name: x}).x

        expected = slope(begin, value, 1e-4 * (abs(value) or 1.0), 2)
        assert worst(S[:, column], expected) < 1e-7, name
