"""Viscous couplings, and differentials whose outputs are braked against each other."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import (
    Component,
    Connection,
    Equation,
    Flange,
    Input,
    Output,
    Param,
    Var,
    connect,
    param,
    var,
)
from lumped.components.characteristic import Characteristic, coulomb, drag_at
from lumped.components.friction import _BetweenShafts
from lumped.components.gearing.gears import BevelDifferential
from lumped.language.switch import Item
from lumped.ops import smooth, where

__all__ = ["LimitedSlipDifferential", "ViscousCoupling"]


class ViscousCoupling(_BetweenShafts):
    """Viscous coupling between two shafts: ``tau = F(|w_rel|)`` against the slip, ``F(0) = 0``.

    `characteristic` is F, torque in N.m over the slip in rad/s: rows of both from (0, 0) on, or a
    function such as `lumped.components.PowerLaw`. Between the outputs of a `BevelDifferential` it
    makes a viscous limited-slip differential. The rise of torque of an oil that expands until the
    plates touch (hump) is left out.
    """

    symbol = "damper"
    characteristic: Characteristic = ()

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.tau == drag_at(self.characteristic, self.w_rel)


class _Loaded(BevelDifferential):
    """Differential that tells the torque on its cage: ``tau_cage = ratio tau_a``."""

    tau_cage = Output("N.m", "torque on the cage")

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        yield from super().equations()
        yield self.tau_cage == self.ratio * self.flange_a.tau


class _Lock(_BetweenShafts):
    """Friction between the outputs: ``|tau| <= (tau_0 + S |tau_cage|) / 2``."""

    symbol = "clutch"
    tau_cage: Input = Input("N.m", "torque on the cage")
    tau_0: Param = param("N.m", "difference of torque by the preload", 0.0, min=0)
    S_drive: Param = param("1", "locking value while the cage is driven", 0.0, min=0, below=1)
    S_coast: Param = param("1", "locking value while it is braked", 0.0, min=0, below=1)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    position: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 free")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        load = self.tau_cage
        ramps = smooth(where(load >= 0, self.S_drive * load, -self.S_coast * load))
        grip = (self.tau_0 + ramps) / 2
        yield coulomb(
            self.tau, self.w_rel, grip, self.peak * grip, engaged=grip > 0, position=self.position
        )


class LimitedSlipDifferential(Component):
    """Differential with friction: ``|tau_left - tau_right| <= tau_0 + S |ratio tau_a|``.

    A `BevelDifferential` whose outputs rub on each other, pressed by a preload and by ramps that
    the torque on the cage spreads. While they turn together the friction is whatever keeps them so;
    when they slip, the slower one takes more torque. S is the locking value, the difference of both
    torques over their sum: without preload the torque bias ratio is ``(1 + S) / (1 - S)``. Ramps of
    two angles have one locking value while the cage is driven forward (`S_drive`, positive
    ``ratio tau_a``) and another while it is braked (`S_coast`).

    Source: Naunheimer, Bertsche, Ryborz and Novak, Automotive Transmissions, 2nd ed. 2011
    (locking value of differentials).
    """

    symbol = "bevel"
    flange_a = Flange()
    left = Flange()
    right = Flange()
    support_a = Flange(grounded=True)
    support_b = Flange(grounded=True)
    ratio: Param = param("1", "speed of the pinion over that of the crown gear", nonzero=True)
    tau_0: Param = param("N.m", "difference of torque by the preload", 0.0, min=0)
    S_drive: Param = param("1", "locking value while the cage is driven", min=0, below=1)
    S_coast: Param = param("1", "locking value while it is braked", S_drive, min=0, below=1)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    gear: _Loaded = _Loaded(ratio=ratio)
    lock: _Lock = _Lock(tau_0=tau_0, S_drive=S_drive, S_coast=S_coast, peak=peak)

    def connections(self) -> Iterator[Connection]:
        gear, lock = self.gear, self.lock
        for port in ("flange_a", "support_a", "support_b"):
            yield connect(getattr(self, port), getattr(gear, port))
        yield connect(self.left, gear.left, lock.flange_a)
        yield connect(self.right, gear.right, lock.flange_b)
        yield connect(gear.tau_cage, lock.tau_cage)
