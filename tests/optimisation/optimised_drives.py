"""Drives whose optimal designs are known in closed form."""

import numpy as np
from rows import assemble_row, in_rows

import lumped as lp
from lumped.components import Damper, Fixed, Inertia, Position, Spring, SpringDamper, Torque

J, D, A, W = 2.0, 3.0, 0.4, 5.0
PERIOD = 2 * np.pi / W


def shaken(c=10.0):
    """Body, spring and damper to ground that a drive shakes: ``tau = J phi'' + d phi' + c phi``."""
    model = in_rows(
        "drive body.flange_a spring.flange_a oil",
        "spring oil.flange_b ground",
        drive=Position(phi=A * lp.ops.sin(W * lp.time)),
        body=Inertia(J=J),
        spring=Spring(c=c),
        oil=Damper(d=D),
        ground=Fixed(),
    )
    return lp.simulate(lp.assemble(model), until=PERIOD, grid=400)


TAU = "drive.flange.tau"
BEST = J * W**2  # the spring that cancels the inertia
LEAST = A * D * W  # amplitude that is left for the damper


def two_bodies():
    """A torque that ends at 0.5 s on two bodies joined by a spring, in oil."""
    return assemble_row(
        t=Torque(tau=10 * lp.ops.where(lp.time >= 0.5, 0.0, 1.0)),
        a=Inertia(J=0.5),
        s=SpringDamper(c=100.0, d=0.2),
        b=Inertia(J=2.0),
        oil=Damper(d=0.7),
        wall=Fixed(),
    )


def pushed(torque, **body):
    """Body in oil under a torque: ``J w' + d w == tau``."""
    return assemble_row(
        motor=Torque(tau=torque), body=Inertia(J=J, **body), oil=Damper(d=D), ground=Fixed()
    )
