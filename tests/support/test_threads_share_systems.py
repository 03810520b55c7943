"""Threads that begin together on a system that was just assembled find what one thread finds."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, is_dataclass
from threading import Barrier

import numpy as np
import pytest
from linkages import double_rocker
from rows import in_rows

import lumped as lp
from lumped import functionals as fun
from lumped.components import (
    BearingFriction,
    Clutch,
    CrankSlider,
    Damper,
    Fixed,
    Inertia,
    Spring,
    SwingingMass,
    Torque,
)
from lumped.ops import where

THREADS = 8


def driven():
    """A torque that changes, a clutch, dry friction, and a mechanism with gravity."""
    return in_rows(
        "drive motor clutch wheel shaft disc crank",
        "disc rub",
        drive=Torque(tau=where(lp.time >= 0.1, 3.0, 5.0 + lp.ops.sin(lp.time))),
        motor=Inertia(J=0.4),
        clutch=Clutch(f_max=8.0, u=1.0),
        wheel=Inertia(J=1.0),
        shaft=Spring(c=500.0),
        disc=Inertia(J=0.2),
        rub=BearingFriction(characteristic=((0.0, 0.3),)),
        crank=CrankSlider(r=0.1, L=0.4, m=2.0),
    )


def hanging():
    """A drive that comes to rest against springs."""
    return in_rows(
        "drive wheel shaft arm",
        "shaft damper wall",
        drive=Torque(tau=2.0),
        wheel=Inertia(J=1.0),
        shaft=Spring(c=500.0),
        arm=SwingingMass(m=1.0, R=0.3),
        damper=Damper(d=0.4),
        wall=Fixed(),
    )


RUN = {"until": 0.2, "start": {"motor.w": 3.0}, "rtol": 1e-6}
HELD = {"until": 0.3, "rtol": 1e-6}

DRIVEN = (
    lambda s: lp.gradient(
        s, of=[fun.peak("shaft.tau"), fun.rms("disc.w"), fun.final("motor.w")], **RUN
    ),
    lambda s: lp.sensitivity(s, of=["disc.w"], by=["disc.J", "shaft.c"], grid=20, **RUN),
    lambda s: lp.simulate(s, grid=50, method="explicit", **RUN),
    lambda s: lp.simulate(s, grid=50, method="implicit", **RUN)["crank.s"],
    lambda s: lp.start_point(s, start=RUN["start"]),
    lambda s: lp.modes(s, at=lp.start_point(s, start=RUN["start"])),
    lambda s: [lp.simulate(s, grid=9, **RUN)[name] for name in s.names() if ".tau" in name],
    lambda s: lp.simulate(s, grid=[0.0], until=0.05, start=RUN["start"]).statistics.steps,
)

HANGING = (
    lp.equilibrium,
    lambda s: lp.modes(s, at=lp.equilibrium(s)),
    lp.start_point,
    lambda s: lp.modes(s),
    lambda s: lp.gradient(s, of=[fun.highest("shaft.tau"), fun.integral("arm.phi")], **HELD),
    lambda s: lp.sensitivity(s, of=["wheel.w"], by=["wheel.J"], grid=20, **HELD),
    lambda s: lp.simulate(s, grid=50, **HELD)["arm.phi"],
    lambda s: lp.linearise(s, inputs=["drive.tau"], outputs=["arm.phi", "shaft.tau"]),
)

LINKAGE = (
    lambda s: lp.simulate(s, until=3.0, rtol=1e-8, method="steps", grid=60),
    lambda s: lp.simulate(s, until=1.0, rtol=1e-6, method="steps", grid=60).x,
    lp.start_point,
    lambda s: lp.simulate(s, until=2.0, rtol=1e-7, method="steps", grid=60).events,
)

SCENES = {
    "driven": (driven, DRIVEN),
    "hanging": (hanging, HANGING),
    "linkage": (lambda: double_rocker(w=3.0), LINKAGE),
}


def numbers(found):
    """All numbers and texts in a result, but for the time it took."""
    if isinstance(found, np.ndarray):
        return found.dtype.str, found.shape, found.tobytes()
    if isinstance(found, list | tuple):
        return [numbers(part) for part in found]
    if is_dataclass(found):
        names = [f.name for f in fields(found) if f.name not in ("seconds", "system", "_known")]
        return [(name, numbers(getattr(found, name))) for name in names]
    if hasattr(found, "toarray"):
        return numbers(found.toarray())
    return repr(found)


def together(system, calls):
    """What the calls give in threads that all begin at once."""
    barrier = Barrier(THREADS)

    def call(k):
        barrier.wait()
        return calls[k % len(calls)](system)

    with ThreadPoolExecutor(THREADS) as pool:
        return [numbers(found) for found in pool.map(call, range(THREADS))]


@pytest.mark.parametrize("name", SCENES)
def test_threads_on_a_new_system_find_what_one_finds(name):
    model, calls = SCENES[name]
    alone = lp.assemble(model())
    expected = [numbers(calls[k % len(calls)](alone)) for k in range(THREADS)]
    for _ in range(4):
        assert together(lp.assemble(model()), calls) == expected


def test_threads_share_a_copy_that_is_assembled_when_it_is_first_used():
    system = lp.assemble(hanging())
    expected = [numbers(call(system)) for call in HANGING]
    for _ in range(4):
        assert together(pickle.loads(pickle.dumps(system)), HANGING) == expected
