"""A body with a speed of 1 rad/s on a spring: the runs of many tests, and their closed form."""

import numpy as np
from rows import assemble_row

from lumped.components import Fixed, Inertia, Spring

C = np.linspace(50.0, 200.0, 7)
UNTIL = 0.7


def oscillator():
    return assemble_row(ground=Fixed(), shaft=Spring(c=100.0), body=Inertia(J=1.0, phi=0.0, w=1.0))


def last(run):
    """Its twist at the end."""
    return run["shaft.phi_rel"][-1]


def closed_form(c, J=1.0):
    w = np.sqrt(c / J)
    return np.sin(w * UNTIL) / w


def fussy(run):
    """The same, but for stiff springs."""
    if run.theta.max() > 150:
        raise ValueError("too stiff for me")
    return last(run)
