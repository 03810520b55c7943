"""Play and stops."""

import lumped as lp
from lumped.components import Backlash, ElastoBacklash, Inertia, translation
from lumped.errors import ParameterError, SolverError, StartError

from . import Table
from .parts import assemble_row, build, build_rows

wrong = Table("Contact")


def resting(stop, **start):
    """Assemble a weight above a stop and start it."""
    system = build_rows(
        "stop mass",
        "stop weight",
        stop=stop,
        mass=translation.Mass(m=2.0, **start),
        weight=translation.Force(f=-20.0),
    )
    return lp.simulate(system, until=1.0)


@wrong(ParameterError, "mesh.b = -0.001 rad", "whole play", "at least 0")
def negative_play():
    """The play of an elastic mesh is negative."""
    assemble_row(pinion=Inertia(J=1.0), mesh=ElastoBacklash(c=1e5, b=-1e-3), wheel=Inertia(J=1.0))


@wrong(ParameterError, "mesh.b = 0 rad", "greater than 0")
def rigid_play_of_nothing():
    """Rigid flanks without play between them: that is a rigid joint."""
    assemble_row(pinion=Inertia(J=1.0), mesh=Backlash(b=0.0), wheel=Inertia(J=1.0))


@wrong(ParameterError, "stop.restitution = 1.2", "at most 1")
def impact_that_gives_energy():
    """The coefficient of restitution is greater than one."""
    resting(translation.Stop(restitution=1.2), s=1.0, v=0.0)


@wrong(StartError, "stop starts 0.2 m inside", "a gap, or none")
def start_inside_a_stop():
    """A body starts beyond its stop."""
    resting(translation.Stop(s_min=0.5), s=0.3, v=0.0)


@wrong(StartError, "mesh starts 0.03 rad inside", "a gap, or none")
def start_beyond_a_flank():
    """Two gears start with their teeth inside each other."""
    system = assemble_row(
        pinion=Inertia(J=1.0, phi=0.0, w=0.0), mesh=Backlash(b=0.04), wheel=Inertia(J=1.0, phi=0.05)
    )
    lp.start_point(system)


@wrong(StartError, "cylinder starts 0.1 m inside")
def stops_in_the_wrong_order():
    """The lower stop of a body stands above its upper one."""
    lp.start_point(build(cylinder=translation.MassWithStops(m=1.0, s_min=0.1, s_max=0.0)))


@wrong(SolverError, "relay", "t = 0.5", "changes of mode")
def relay_without_hysteresis():
    """A relay drives its own input back to the point where it switches."""

    class Relay(lp.Component):
        """Drives x towards zero from both sides: der(x) = -sign(x)."""

        x: lp.Var = lp.var("1", "state", 0.5, state="always")

        def equations(self):
            yield lp.der(self.x) == lp.ops.where(self.x > 0, -1, 1)

    lp.simulate(build(relay=Relay()), until=1.0)
