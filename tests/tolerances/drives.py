"""Small drives with closed forms."""

import numpy as np
from rows import assemble_row, assemble_rows

import lumped as lp
from lumped.components import Brake, Fixed, Inertia, Spring, SpringDamper, Torque


def pair():
    """Two inertias and a spring: f = sqrt(c (1/Ja + 1/Jb)) / (2 pi)."""
    return assemble_row(a=Inertia(J=2.0), s=SpringDamper(c=1000.0, d=0.3), b=Inertia(J=3.0))


def undamped_hertz(c, Ja, Jb):
    return np.sqrt(c * (1 / Ja + 1 / Jb)) / (2 * np.pi)


def wheel():
    """An inertia driven by two torques: speed after one second (tau1 + tau2) / J."""
    return assemble_rows(
        "one body two", body=Inertia(J=4.0, w=0.0), one=Torque(tau=20.0), two=Torque(tau=12.0)
    )


def pendulum_on_a_spring():
    """An inertia on a spring to the ground: f = sqrt(c / J) / (2 pi)."""
    return assemble_row(body=Inertia(J=2.0), spring=Spring(c=1000.0), wall=Fixed())


def braked():
    """A body that stands after ``2 w / f_max``: half of f_max is its torque."""
    return assemble_row(
        body=Inertia(J=1.0, w=10.0), brake=Brake(f_max=10.0, characteristic=((0.0, 0.5),), u=1.0)
    )


def pulled():
    """``w(1 s) = (t + 2 s) / J``, as the second torque acts twice."""
    return lp.compose(
        a=Inertia(J=2.0),
        t=Torque(tau=10.0),
        s=Torque(tau=4.0),
        r=Torque(tau=4.0),
        connections=lambda m: [lp.connect(x.flange, m.a.flange_a) for x in (m.t, m.s, m.r)],
    )


MEANS, STDS = np.array([10.0, 4.0, 4.0]), np.array([1.0, 0.5, 0.3])
TORQUES = ("t.tau", "s.tau", "r.tau")


def normals(means=MEANS, stds=STDS):
    return {n: lp.normal(m, s) for n, m, s in zip(TORQUES, means, stds, strict=True)}
