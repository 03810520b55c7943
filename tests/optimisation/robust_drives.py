"""Drives whose parameters scatter, and a condition of one."""

import numpy as np
from rows import assemble_row

import lumped as lp
from lumped import functionals as fun
from lumped.components import Fixed, Inertia, Spring, Torque

LOAD, SPREAD = 5000.0, 500.0  # N.m
STRENGTH, WEAKER = 300e6, 20e6  # Pa


class Bar(lp.Component):
    """Round bar under torque; `excess` is its stress beyond the strength."""

    d: lp.Param = lp.param("m", "diameter", 0.06, above=0)
    T: lp.Param = lp.param("N.m", "torque", LOAD)
    R: lp.Param = lp.param("Pa", "strength", STRENGTH)
    excess = lp.var("Pa", "stress less strength")

    def equations(self):
        yield self.excess == 16 * self.T / (np.pi * self.d**3) - self.R


def oscillator(c=1000.0):
    return assemble_row(wall=Fixed(), shaft=Spring(c=c), body=Inertia(J=2.0))


def pushed():
    """A body that has the speed ``tau / J`` after 1 s."""
    return assemble_row(motor=Torque(tau=10.0), body=Inertia(J=2.0))


SCATTER = {"T": lp.normal(LOAD, SPREAD), "R": lp.normal(STRENGTH, WEAKER)}
BREAKS = lp.probability(fun.final("excess"), above=0.0, over=SCATTER)
