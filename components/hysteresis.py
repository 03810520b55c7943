"""Springs and dry friction together: elements whose torque depends on the way they came.

Their loops do not depend on the speed. Friction in series with a spring slides while the torque is
at its limit and sticks when the motion turns (Prandtl, Z. angew. Math. Mech. 8 (1928) 85; Iwan,
J. Appl. Mech. 33 (1966) 893).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

from lumped import (
    Component,
    Connection,
    Equation,
    Expr,
    Flange,
    Param,
    Var,
    connect,
    der,
    param,
    var,
)
from lumped.components.characteristic import coulomb
from lumped.components.compliance import Spring
from lumped.components.couplings.elastic import elastic_energy, elastic_force
from lumped.components.rows import check_ascending, check_rows
from lumped.errors import EquationError, shown
from lumped.language.component import Made
from lumped.language.expression import Datum, as_expr
from lumped.language.switch import Item
from lumped.language.value_types import Rows
from lumped.ops import where

__all__ = ["ClutchDisc", "Iwan", "Jenkin"]


_Stage = tuple[float, float, float]
"""Twist at which a stage begins, its stiffness, its friction torque."""


class _Twisted(Component):
    """Between two shafts: ``phi_rel = phi_b - phi_a``, ``tau_b = -tau_a = tau``."""

    flange_a = Flange()
    flange_b = Flange()
    phi_rel: Var = var("rad", "twist", nominal=1e-4)
    w_rel: Var = var("rad/s", "relative angular velocity")
    tau: Var = var("N.m", "torque on flange b")

    def equations(self) -> Iterator[Item]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau


class Jenkin(_Twisted):
    """Spring in series with dry friction: ``tau = c phi``, ``|tau| <= tau_max``.

    The elastic twist phi follows that of the flanges, ``der(phi) = w_rel - w_slip``. It sticks,
    ``w_slip = 0``, within the limit; there it slides, ``der(phi) = 0``, until the motion turns. A
    cycle of the amplitude A loses ``4 tau_max (A - tau_max / c)``.

    Source: Jenkin's element, as in Iwan, J. Appl. Mech. 33 (1966) 893.
    """

    symbol = "spring"
    c: Param = param("N.m/rad", "torsional stiffness", above=0)
    tau_max: Param = param("N.m", "torque at which it slides", above=0)
    phi: Var = var("rad", "elastic twist", nominal=1e-4, state="prefer")
    w_slip: Var = var("rad/s", "sliding speed")
    position: Var = var("1", "1 forward, 0 stuck, -1 backward")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.tau == self.c * self.phi
        yield der(self.phi) == self.w_rel - self.w_slip
        limit = self.tau_max
        yield coulomb(self.tau, self.w_slip, limit, limit, position=self.position)

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.tau * self.w_slip

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return self.c * self.phi**2 / 2


def _elements(joint: Iwan) -> list[Component]:
    """Elements that add up to a backbone: each takes one bend of it."""
    what, example = "twist (rad) and torque (N.m)", "((0, 0), (0.01, 40), (0.03, 60))"
    rows = check_rows("backbone", joint.backbone, what, example, least=2)
    check_ascending("backbone", "twists", [phi for phi, _ in rows], "rad")
    if rows[0] != (0.0, 0.0):
        raise EquationError(f"backbone = {shown(joint.backbone)}: the first row must be (0, 0).")
    slopes = [
        (t_1 - t_0) / (phi_1 - phi_0) for (phi_0, t_0), (phi_1, t_1) in itertools.pairwise(rows)
    ]
    if slopes[0] <= 0:
        raise EquationError(
            f"backbone = {shown(joint.backbone)}: it must begin with a stiffness above 0, such as "
            f"{example}."
        )
    found: list[Component] = []
    for (phi, _), (before, after) in zip(rows[1:-1], itertools.pairwise(slopes), strict=True):
        if before > after:
            found.append(Jenkin(c=before - after, tau_max=(before - after) * phi))
    if min(slopes) < 0 or any(before < after for before, after in itertools.pairwise(slopes)):
        raise EquationError(
            f"backbone = {shown(joint.backbone)}: its stiffness must not rise or be negative, as "
            f"sliding only makes it softer, such as {example}."
        )
    return found + [Spring(c=slopes[-1])] * (slopes[-1] > 0)


class Iwan(_Twisted):
    """Jenkin's elements in parallel: ``tau = sum(tau_i)``, microslip of a joint.

    `backbone` is the torque of the first loading, rows of twist in rad and torque in N.m from
    (0, 0) on, joined by straight lines, the last one continued; its slope never rises. At each bend
    one element begins to slide, so the rows are the distribution of sliding torques. Loops follow
    Masing's rules: after a turn the torque changes by twice the backbone at half the way.

    Source: Iwan, J. Appl. Mech. 33 (1966) 893.
    """

    symbol = "spring"
    backbone: Rows = ()
    elements: Any = Made(_elements)

    def equations(self) -> Iterator[Equation]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        tau: Expr = as_expr(0.0)
        for element in self.elements:
            tau = tau + element.tau
        yield self.tau == tau

    def connections(self) -> Iterator[Connection]:
        for element in self.elements:
            yield connect(self.flange_a, element.flange_a)
            yield connect(self.flange_b, element.flange_b)


class ClutchDisc(_Twisted):
    """Torsional damper of a clutch disc: ``tau = T(phi_rel) + tau_friction``.

    `drive` are rows of a stage for each: the twist in rad at which it begins (the first one at 0),
    its stiffness in N.m/rad and its friction torque in N.m, half the width of the hysteresis. So a
    pre-damper, main dampers and the stop are a row each. `coast` are the same for negative twist;
    without rows it equals `drive`. T is continuous, and the friction is that of the stage.
    """

    symbol = "spring_damper"
    drive: Rows = ()
    coast: Rows = ()
    phi_rel: Var = var("rad", "twist", nominal=1e-2, state="prefer")
    w_rel: Var = var("rad/s", "relative angular velocity", state="prefer")
    tau_friction: Var = var("N.m", "friction torque on flange b")
    position: Var = var("1", "1 forward, 0 stuck, -1 backward")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.tau == elastic_force(self._rows(), self.phi_rel) + self.tau_friction
        limit = self._friction()
        yield coulomb(self.tau_friction, self.w_rel, limit, limit, position=self.position)

    def _stages(self) -> tuple[list[_Stage], list[_Stage]]:
        return _stages("drive", self.drive), _stages("coast", self.coast or self.drive)

    def _rows(self) -> list[tuple[float, float]]:
        """Rows of twist and torque of the springs."""
        drive, coast = map(_torques, self._stages())
        return [(-phi, -tau) for phi, tau in reversed(coast[1:])] + drive

    def _friction(self) -> Expr:
        """Friction torque of the stage in which the twist is."""
        drive, coast = self._stages()
        found = where(self.phi_rel >= 0, Datum(drive[0][2]), Datum(coast[0][2]))
        for begin, _, friction in drive[1:]:
            found = where(self.phi_rel >= begin, Datum(friction), found)
        for begin, _, friction in coast[1:]:
            found = where(self.phi_rel <= -begin, Datum(friction), found)
        return found

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.tau_friction * self.w_rel

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return elastic_energy(self._rows(), self.phi_rel)


def _stages(name: str, rows: Rows) -> list[_Stage]:
    """Rows of stages that make sense."""
    what = "twist (rad) from 0 on, stiffness (N.m/rad) and friction torque (N.m)"
    found = check_rows(name, rows, what, "((0, 60, 1), (0.12, 1500, 20), (0.4, 2e5, 20))", 3)
    if found[0][0] != 0:
        raise EquationError(f"{name}: the first stage begins at {found[0][0]:g} rad, not at 0.")
    check_ascending(name, "twists", [begin for begin, *_ in found], "rad")
    for begin, c, friction in found:
        if c <= 0 or friction < 0:
            raise EquationError(
                f"{name}: in the stage from {begin:g} rad the stiffness {c:g} N.m/rad must be "
                f"greater than 0, the friction {friction:g} N.m not negative."
            )
    return [(begin, c, friction) for begin, c, friction in found]


def _torques(stages: list[_Stage]) -> list[tuple[float, float]]:
    """Twist and torque of the springs where stages begin, and one point in the last one."""
    found = [(0.0, 0.0)]
    ends = [begin for begin, _, _ in stages[1:]] + [2 * stages[-1][0] + 1.0]
    for (begin, c, _), end in zip(stages, ends, strict=True):
        found.append((end, found[-1][1] + c * (end - begin)))
    return found
