"""Gears that lose power in the mesh and in the bearings."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

from lumped import Component, Expr, Flange, Param, Var, der, hold, param, var
from lumped.errors import EquationError
from lumped.language.expression import Compare
from lumped.language.switch import Hold, Item
from lumped.language.value_types import Rows
from lumped.ops import interpolate, maximum, minimum, where

__all__ = ["EfficientGear", "LossyGear", "Meshing"]

Losses = tuple[Expr | float, Expr | float, Expr | float, Expr | float]
"""Efficiencies while a and while b drives, bearing friction in both cases."""


class Meshing(Component):
    """Loss torque of a mesh that is driven from flange a or from the other side: base of gears.

    ``power lost = tau_loss w``.
    """

    flange_a = Flange()
    phi: Var = var("rad", "angle of flange a relative to the support", state="avoid")
    w: Var = var("rad/s", "speed of flange a relative to the support", state="prefer")
    tau_loss: Var = var("N.m", "loss torque, referred to flange a")
    position: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 without loss")

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.tau_loss * self.w

    def mesh_loss(
        self,
        losses: Callable[[Expr | float], Losses],
        border: float | None,
        engaged: Compare | None = None,
        passed_on: Expr | None = None,
    ) -> Hold:
        """Loss torque while it turns, and its limits at standstill.

        Parameters
        ----------
        losses : callable
            Efficiencies and bearing friction at a speed.
        border : float, optional
            Torque above which side a drives forward, if it is the same at all speeds.
        engaged : relation, optional
            While this is false there is no loss.
        passed_on : expression, optional
            Torque that is passed on, referred to flange a. For a mesh that may hold itself, which
            has two losses for one torque at flange a, but one for that which it passes on.
        """
        tau = self.flange_a.tau if passed_on is None else passed_on

        def laws(speed: Expr | float, way: int) -> tuple[Expr, Expr]:
            eta_a, eta_b, tau_a, tau_b = losses(speed)
            if passed_on is not None:
                return (tau + way * tau_a) / eta_a - tau, eta_b * (tau + way * tau_b) - tau
            return (1 - eta_a) * tau + way * tau_a, (1 - 1 / eta_b) * tau + way * tau_b

        a_ahead, b_ahead = laws(self.w, 1)
        a_back, b_back = laws(-self.w, -1)
        a_drives = a_ahead >= b_ahead if border is None else tau >= border
        b_drives = a_back >= b_back if border is None else tau >= (-border or 0.0)
        return hold(
            self.tau_loss,
            self.w,
            forward=where(a_drives, a_ahead, b_ahead),
            backward=where(b_drives, b_back, a_back),
            upper=maximum(*laws(0.0, 1)),
            lower=minimum(*laws(0.0, -1)),
            engaged=engaged,
            pressed=False,
            position=self.position,
        )


class LossyGear(Meshing):
    """Gear with mesh efficiency and bearing friction: ``tau_b = -ratio (tau_a - tau_loss)``.

    While side a drives, ``tau_loss = (1 - eta_a) tau_a + tau_bearing_a``; while side b drives,
    ``tau_loss = (1 - 1/eta_b) tau_a + tau_bearing_b`` (forward motion; bearing friction changes
    its sign with the motion). The driving side is the one whose law gives the greater loss, so the
    loss does not jump. At standstill `tau_loss` is whatever keeps the gear still, up to the same
    law (Pelchen, Schweiger and Otter, Modeling and Simulating the Efficiency of Gearboxes and of
    Planetary Gearboxes, Modelica conference 2002).

    `losses` are rows of speed of flange a relative to the support in rad/s (from zero up),
    efficiency while a drives, efficiency while b drives, and bearing friction at side a in N.m
    in both cases; joined by straight lines and continued by the last one. If the continued line
    would leave the range of an efficiency, end the table with two equal rows. With an efficiency of
    zero or below while b drives the gear holds itself: then side a drives even if b helps.
    """

    symbol = "gear"
    flange_b = Flange()
    support = Flange(grounded=True)
    ratio: Param = param("1", "gear ratio, speed of a over speed of b", nonzero=True)
    losses: Rows = ((0.0, 1.0, 1.0, 0.0, 0.0),)

    def equations(self) -> Iterator[Item]:
        rows = check_loss_table(self.losses)
        yield from _kinematics(self)
        if all(tuple(row[1:]) == (1.0, 1.0, 0.0, 0.0) for row in rows):
            yield self.tau_loss == 0
            yield self.position == 2
            return
        speeds, *columns = zip(*rows, strict=True)
        own = min(columns[1]) <= 0
        laws = set(zip(*columns, strict=True))
        borders = {_border(*law, holds_itself=own) for law in laws}
        border = borders.pop() if len(laws) == 1 or borders == {0.0} else None

        def losses(speed: Expr | float) -> Losses:
            eta_a, eta_b, tau_a, tau_b = (interpolate(speed, speeds, y) for y in columns)
            return eta_a, eta_b, tau_a, tau_b

        passed_on = -self.flange_b.tau / self.ratio if own else None
        yield self.mesh_loss(losses, border, passed_on=passed_on)


class EfficientGear(Meshing):
    """Gear of one efficiency: ``tau_b = -ratio tau_a eta`` while a drives, ``/ eta`` while b does.

    A `LossyGear` whose mesh loses the same share in both directions at all speeds, and whose
    efficiency may change without a new assembly.
    """

    symbol = "gear"
    flange_b = Flange()
    support = Flange(grounded=True)
    ratio: Param = param("1", "gear ratio, speed of a over speed of b", nonzero=True)
    eta: Param = param("1", "efficiency, power out over power in", above=0, max=1)

    def equations(self) -> Iterator[Item]:
        yield from _kinematics(self)
        yield self.mesh_loss(lambda speed: (self.eta, self.eta, 0.0, 0.0), 0.0, self.eta < 1)


def _kinematics(gear: LossyGear | EfficientGear) -> Iterator[Item]:
    a, b, housing = gear.flange_a, gear.flange_b, gear.support
    yield gear.phi == a.phi - housing.phi
    yield gear.phi == gear.ratio * (b.phi - housing.phi)
    yield gear.w == der(gear.phi)
    yield b.tau == -gear.ratio * (a.tau - gear.tau_loss)
    yield housing.tau == -a.tau - b.tau


def _border(eta_a: float, eta_b: float, tau_a: float, tau_b: float, *, holds_itself: bool) -> float:
    """Torque at which both sides' laws give the same loss."""
    if tau_a == tau_b and not (holds_itself and tau_a):
        return 0.0
    if eta_a == eta_b == 1:
        return tau_a / 2
    passed = (eta_a * eta_b * tau_b - tau_a) / (1 - eta_a * eta_b)
    return passed if holds_itself else (passed + tau_a) / eta_a


def check_loss_table(rows: Rows) -> list[tuple[float, ...]]:
    """The loss table of a gear.

    Raises
    ------
    EquationError
        If a row does not hold five numbers, speeds do not increase from zero, an efficiency is
        out of its range, or a bearing torque is negative.
    """
    try:
        found = [tuple(float(value) for value in row) for row in rows]
    except (TypeError, ValueError):
        found = []
    if not found or any(len(row) != 5 for row in found):
        raise EquationError(
            f"losses = {rows!r}: at least one row is needed, and each has five numbers: speed in "
            "rad/s, efficiency while a drives, efficiency while b drives, and bearing friction in "
            "N.m in both cases."
        )
    if found[0][0] != 0:
        raise EquationError(f"losses: the first speed is {found[0][0]:g} rad/s; it must be zero.")
    for (left, *_), (right, *_) in pairwise(found):
        if not right > left:
            raise EquationError(
                f"losses: the speeds must increase from row to row, but {left:g} -> {right:g} "
                "rad/s. The table counts the magnitude of the speed."
            )
    for speed, eta_a, eta_b, tau_a, tau_b in found:
        if not 0 < eta_a <= 1:
            raise EquationError(
                f"losses: the efficiency while a drives at {speed:g} rad/s is {eta_a:g}; it must "
                "be greater than 0 and at most 1. The side that cannot drive is b."
            )
        if not -float("inf") < eta_b <= 1:
            raise EquationError(
                f"losses: the efficiency while b drives at {speed:g} rad/s is {eta_b:g}; it must "
                "be at most 1, and 0 or less where the gear holds itself."
            )
        for side, tau in (("a", tau_a), ("b", tau_b)):
            if not 0 <= tau < float("inf"):
                raise EquationError(
                    f"losses: the bearing friction while {side} drives at {speed:g} rad/s is "
                    f"{tau:g} N.m; it must be a finite number, zero or greater. It acts against "
                    "the motion by itself."
                )
    return found
