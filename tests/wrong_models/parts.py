"""Parts and models that several of the cases are built of."""

import lumped as lp
from lumped.components import Damper, Fixed, Inertia, Spring, Torque
from tests.helpers.rows import assemble_row


def build(connections=(), **parts):
    """Assemble a model of these parts."""
    return lp.assemble(lp.compose(connections=connections, **parts))


class Shaft(lp.Component):
    """Elastic shaft with its inertia: two halves and a spring, joined inside."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    J: lp.Param = lp.param("kg.m2", "moment of inertia", 0.1, above=0)
    left: Inertia = Inertia(J=J / 2)
    twist: Spring = Spring(c=100.0)
    right: Inertia = Inertia(J=J / 2)

    def connections(self):
        yield from lp.chain(self.flange_a, self.left, self.twist, self.right, self.flange_b)


class Line(lp.Component):
    """Two elastic shafts in a row, one level further down."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    first: Shaft = Shaft()
    second: Shaft = Shaft()

    def connections(self):
        yield from lp.chain(self.flange_a, self.first, self.second, self.flange_b)


class Hoist(lp.Component):
    """Motor, shafts and drum, with lists and dictionaries of parts."""

    motor: Inertia = Inertia(J=0.1)
    line: Line = Line()
    discs: list[Inertia] = [Inertia(J=1.0), Inertia(J=1.0)]  # noqa: RUF012
    brakes: dict[str, Damper] = {"left": Damper(d=1.0), "right": Damper(d=1.0)}  # noqa: RUF012
    wall: Fixed = Fixed()

    def connections(self):
        yield from lp.chain(self.motor, self.line, *self.discs)
        for brake in self.brakes.values():
            yield from lp.chain(self.discs[-1], brake, self.wall)


class Brake(lp.Component):
    """Brake whose law a test supplies."""

    flange = lp.Flange()
    d: lp.Param = lp.param("N.m.s/rad", "damping", 2.0)
    w: lp.Var = lp.var("rad/s", "speed")


def braked(law):
    """Assemble a rotor with a brake of this law."""
    kind = type("Brake", (Brake,), {"__doc__": "Brake under test.", "equations": law})
    return assemble_row(rotor=Inertia(J=1.0, w=1.0), brake=kind())


def braked_drive():
    """A motor against a damper."""
    return assemble_row(
        drive=Torque(tau=6.0), rotor=Inertia(J=2.0), brake=Damper(d=0.5), wall=Fixed()
    )
