"""Carrousel coiler with its safety coupling and its long shaft, and a jam of the mandrel.

The source names coupling, shaft and mesh but gives no value of them; all here are assumed [A]. The
shaft is steel, 0.4 m thick and 6 m long. Play and stiffness of the meshes are referred to it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import Brake, ElastoBacklash, Inertia, SlipCoupling, Torque
from lumped.models.carrousel_coiler.drive import J_MANDREL, UnderTension, WindingDrive
from lumped.models.sources import Given
from lumped.ops import where

SLIP = Given(140e3, "N.m", "A", "slip torque of the safety coupling, at the motor shaft")
SLIDING = Given(0.9, "1", "A", "torque of the slipping coupling over its slip torque")
J_HALF = Given(20.0, "kg.m2", "A", "half of the safety coupling and pinion, at the motor shaft")
J_WHEEL = Given(200.0, "kg.m2", "A", "gears, at the mandrel")
STIFFNESS = Given(
    8.1e10 * np.pi * 0.4**4 / 32 / 6.0,
    "N.m/rad",
    "A",
    "long shaft of steel, 0.4 m thick and 6 m long",
)
PLAY = Given(2e-3, "rad", "A", "play of the meshes, at the mandrel")
JAM = Given(400e3, "N.m", "A", "torque that rubs when the mandrel jams")


class ShaftedDrive(WindingDrive):
    """Winding drive whose safety coupling may slip, with play and an elastic shaft."""

    coupling: SlipCoupling = SlipCoupling(kinetic=SLIDING * SLIP, static=SLIP, u=1.0)
    half: Inertia = Inertia(J=J_HALF)
    wheel: Inertia = Inertia(J=J_WHEEL)
    shaft: ElastoBacklash = ElastoBacklash(c=STIFFNESS, b=PLAY)
    mandrel: Inertia = Inertia(J=J_MANDREL - J_WHEEL)

    def line(self) -> Iterator[lp.Connection]:
        """From the motor to the mandrel."""
        yield from lp.chain(self.motor, self.rotor, self.coupling, self.half, self.gear)
        yield from lp.chain(self.gear, self.mesh, self.wheel, self.shaft, self.mandrel)


class Jammed(ShaftedDrive):
    """Winding drive whose mandrel is braked by rubbing from an instant on."""

    at: lp.Param = lp.param("s", "instant of the jam", 0.1)
    rub: Brake = Brake(f_max=JAM, u=where(lp.time >= at, 1.0, 0.0), characteristic=((0.0, 1.0),))

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.mandrel.flange_b, self.rub.flange_a)


def jam(
    w: float = 50.0,
    radius: float = 0.4,
    until: float = 0.3,
    drive: Jammed | None = None,
    parameters: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Steady winding in high gear, without losses, until the mandrel jams at 0.1 s.

    Parameters
    ----------
    w : float
        Speed of the mandrel, rad/s.
    radius : float
        Radius of the coil, m.
    until : float
        End, s.
    drive : Jammed, optional
        Drive, which runs here without losses on a torque; that of the source unless given.
    parameters : mapping of name to value, optional
        Parameters to change: ``{"drive.coupling.static": 1e9}`` for a coupling that never slips.
        The motor has the torque of the tension unless ``drive.motor.tau`` is given.
    start : mapping of name to value, optional
        Start values besides.
    **options
        Passed to `lumped.simulate`.

    Returns
    -------
    Trajectory
    """
    plain = {"motor": Torque(tau=0.0), "eta": 1.0, "mu": 0.0, "sigma_s": 0.0}
    drive = (Jammed() if drive is None else drive).with_(plain)
    system = lp.assemble(UnderTension(drive=drive))
    found = system.parameter_values(parameters)
    torque, ratio = found["T"] * radius, found["drive.gear.ratio_1"]
    begin = {
        "drive.mandrel.w": w,
        "drive.wheel.w": w,
        "drive.rotor.w": ratio * w,
        "drive.shaft.phi_rel": -torque / found["drive.shaft.c"] - found["drive.shaft.b"] / 2,
        "drive.coil.theta": 2 * np.pi * (radius - found["drive.r"]) / found["drive.h"],
    }
    changed = {"drive.motor.tau": torque / ratio} | dict(parameters or {})
    begin |= dict(start or {})
    return lp.simulate(system, until=until, parameters=changed, start=begin, **options)
