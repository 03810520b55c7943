"""Equilibria and rest."""

import lumped as lp
from lumped.components import Inertia, Speed
from lumped.errors import SolverError, StartError

from . import Table
from .parts import assemble_row, braked_drive

wrong = Table("Equilibria")


@wrong(SolverError, "no rest", "der(rotor.w) stays at 3", "springs or supports")
def rest_of_a_driven_shaft():
    """A driven shaft that only a damper holds shall rest."""
    lp.equilibrium(braked_drive(), rest=True)


@wrong(SolverError, "no rest", "rotor.w = 10 rad/s", "sources of motion")
def rest_on_a_speed_source():
    """A body on a speed source shall rest."""
    lp.equilibrium(assemble_row(motor=Speed(w=10.0), rotor=Inertia(J=1.0)), rest=True)


@wrong(StartError, "rotor.w = 4 rad/s", "rest")
def rest_with_a_speed():
    """Rest is asked for, and a speed."""
    lp.equilibrium(braked_drive(), rest=True, start={"rotor.w": 4.0})


@wrong(StartError, "drive.tau, brake.d", "speed")
def equilibrium_with_too_many_free_parameters():
    """The torque and the load are both free."""
    lp.equilibrium(braked_drive(), start={"rotor.w": 4.0}, free=["drive.tau", "brake.d"])


@wrong(SolverError, "no equilibrium", "der(rotor.w)", "free")
def equilibrium_with_a_useless_free_parameter():
    """The free parameter does not change the balance of torques."""
    lp.equilibrium(braked_drive(), start={"rotor.w": 4.0}, free=["rotor.J"])
