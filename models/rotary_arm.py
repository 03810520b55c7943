"""Mandrel rotary arm of a tube mill's front table: published numbers beside computed ones.

The arm is described in `lumped.models.rotary_arm_parts`, its load torques and motors in
`rotary_arm_loads`, its cycle in `rotary_arm_cycle`, its position control in `rotary_arm_control`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

import lumped as lp
from lumped.models import Row
from lumped.models.rotary_arm_control import AIM, controlled
from lumped.models.rotary_arm_cycle import ADOPTED, Cycle, motor_torque, rms, run_cycle
from lumped.models.rotary_arm_loads import (
    FIRST,
    KW_RPM,
    MAXIMUM,
    OVERLOAD,
    RATED,
    SPEED,
    at,
    critical_efficiency,
    greatest_acceleration,
    lifting,
    printed_loads,
    tray_twist,
)
from lumped.models.rotary_arm_parts import (
    EPS,
    ETA,
    M_WEIGHTS,
    PRINTED,
    R_WEIGHTS,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOADS, SIZING, TEXT, CYCLE, NOT = "load torques", "motor sizing", "text", "cycle", "not published"
PARTS = (  # name in the model, what, printed torque
    ("arm.trays.tau_g", "trays", 3276.0),
    ("arm.arms.tau_g", "arms", 36_868.0),
    ("arm.weights.tau_g", "counterweights", 18_620.0),
    ("arm.weight.tau", "mandrel", 319_536.0),
)
LOSS = PRINTED | {"reducer.eta": ETA}


def rows() -> list[Row]:
    """Published and computed numbers."""
    return [*_loads(), *_motors(), *_cycle(), *_loop()]


def _loads() -> Iterator[Row]:
    point = at(lifting(EPS), parameters=PRINTED)
    for name, what, torque in PARTS:
        yield Row(f"gravity, {what}", "N.m", torque, abs(point[name]), LOADS, "g = 10 m/s2")
    sums = printed_loads()
    yield Row("gravity, all", "N.m", 341_060.0, sums["grav"], LOADS, "rounded")
    acc = "with the mandrel's spin, 2.8 % too much: the tray does not turn; without the rotor"
    yield Row("acceleration, 1.38 rad/s2", "N.m", 50_721.0, sums["acc"], LOADS, acc)
    fric = "formula lost; the printed sum leaves 13 369 +- 25"
    yield Row("friction in the journals", "N.m", None, sums["fric"], LOADS, fric)
    rest = sum(point[name] for name, *_ in PARTS[:3])
    residual = "6.3 % of the load: 'the counterweight balances the arm' does not hold"
    yield Row("gravity, empty arm", "N.m", None, rest, TEXT, residual)
    share = 1 + rest / -point["arm.weights.tau_g"]
    balance = "0.7546 from the moments of trays and arms; or 2294 kg at 0.350 m"
    yield Row("radius that balances", "m", None, share * R_WEIGHTS, NOT, balance)
    yield Row("mass that balances, each", "kg", None, share * M_WEIGHTS / 5, NOT, "2294")
    for case, torque in (("counterweights", 8429.7), ("mandrel", 631.8)):
        found = printed_loads(missing=case)["motor"]
        yield Row(f"motor torque, no {case}", "N.m", None, found, NOT, f"{torque} by hand")
    one = np.degrees(tray_twist(40 / 41))
    yield Row("twist of a tray, one tooth amiss", "deg", None, one, NOT, "4.4, 180 (1 - 40/41)")


def _motors() -> Iterator[Row]:
    torque = printed_loads()["motor"]
    yield Row("motor torque, all together", "N.m", 8103.0, torque, SIZING, "rounded")
    power = torque * SPEED / KW_RPM / ETA
    yield Row("power needed", "kW", 479.1, power, SIZING, "the only place of the efficiency")
    yield Row("power over overload", "kW", 239.6, power / OVERLOAD, SIZING, "rounded")
    yield Row("rated torque, 250 kW", "N.m", 4974.0, RATED, SIZING, "rounded")
    yield Row("greatest torque, 250 kW", "N.m", 9948.0, OVERLOAD * RATED, SIZING, "rounded")
    loss = at(lifting(EPS), parameters=LOSS)
    lost = "9533 by hand: torque over efficiency"
    yield Row("torque, with the loss", "N.m", None, loss["reducer.flange_a.tau"], NOT, lost)
    rotor = "10 416 by hand: more than the motor has"
    yield Row("torque, with loss and rotor", "N.m", None, -loss["drive.flange.tau"], NOT, rotor)
    for name, changed, value in (("as printed", LOSS, 1.07), ("corrected", {}, 1.20)):
        found = greatest_acceleration(MAXIMUM, changed)
        note = f"{value:.2f} by hand; wanted are 1.38"
        yield Row(f"acceleration it gives, {name}", "rad/s2", None, found, NOT, note)
    lift = at(lifting(0.0), parameters=LOSS)["reducer.flange_a.tau"]
    yield Row("torque to lift, without acceleration", "N.m", None, lift, NOT, "8339 by hand")
    first = "8356; above the printed 8103, so it would do by the rule of the source"
    yield Row("greatest torque, first motor", "N.m", None, OVERLOAD * FIRST, NOT, first)
    kick = greatest_acceleration(OVERLOAD * FIRST, LOSS)
    note = "0.011 by hand: the reported 'cannot kick the mandrel in'"
    yield Row("acceleration the first motor gives", "rad/s2", None, kick, NOT, note)
    for g, changed, value in (("10", PRINTED, 0.848), ("9.80665", {}, 0.832)):
        found = critical_efficiency(OVERLOAD * FIRST, changed)
        name = f"efficiency it needs, g = {g}"
        yield Row(name, "1", None, found, NOT, f"{value} by hand; printed are 0.85")


def _cycle() -> Iterator[Row]:
    found = run_cycle(printed=True)
    torque = motor_torque(found, rotor=False)
    fitted = "pick-up and release 1.469 deg below the horizontal are fitted to it"
    yield Row("RMS torque T_dx", "N.m", 4100.0, rms(found, torque), CYCLE, fitted)
    note = "the printed 83 % are rounded from 82.4"
    share = 100 * rms(found, torque) / RATED
    yield Row("RMS torque over rated", "%", 83.0, share, CYCLE, note)
    level = run_cycle(Cycle(0.0, np.pi), printed=True)
    free = motor_torque(level, rotor=False)
    note = "nothing fitted: equal slow zones, both horizontal"
    yield Row("RMS torque, horizontal", "N.m", 4100.0, rms(level, free), CYCLE, note)
    slow = np.degrees(ADOPTED.slow)
    yield Row("slow angles together", "deg", None, slow, NOT, "17.520 by hand, from the 9 s")
    yield Row("peak torque", "N.m", None, torque.max(), NOT, "8093.9 by inverse dynamics by hand")
    for name, first, value in (("t = 1 to 9 s", 1.0, 4368), ("t = 0.5 to 8.5 s", 0.5, 3960)):
        samples = [torque[np.abs(found.t - t).argmin()] for t in first + np.arange(9.0)]
        mean = np.sqrt(np.mean(np.square(samples)))
        note = f"{value} by hand: so much does sampling alone change"
        yield Row(f"RMS torque, nine samples, {name}", "N.m", None, mean, NOT, note)
    full = run_cycle()
    torque = motor_torque(full)
    yield Row("RMS torque, full model", "N.m", None, rms(full, torque), NOT, "4408.6 by hand")
    note = "10 211 by hand, 103 % of what the motor has"
    yield Row("peak torque, full model", "N.m", None, torque.max(), NOT, note)
    yield Row("least torque, full model", "N.m", None, torque.min(), NOT, "-7177 by hand")


def _loop() -> Iterator[Row]:
    run = controlled(grid=498, rtol=1e-10)
    taken, put, near = instants(run)
    note = "0.577318, where friction acts forward even at rest"
    yield Row("pick-up under control", "s", None, taken, NOT, note)
    yield Row("release under control", "s", None, put, NOT, "5.266257 by hand")
    yield Row("proportional zone reached", "s", None, near, NOT, "9.310165 by hand")
    note = "0.52448, moments of inertia before and after"
    yield Row("speed after pick-up over before", "1", None, jump(run, taken), NOT, note)
    t = np.linspace(0.0, run.t[-1], 499)  # the samples of the calculation by hand
    w, phi, torque = (
        np.interp(t, run.t, run[name]) for name in ("arm.trays.w", "arm.phi", "motor.tau")
    )
    least = w[(t > taken) & (t < taken + 1)].min()
    note = "0.0193 by hand: the arm does not stop; samples 22 ms apart"
    yield Row("least speed after pick-up", "rad/s", None, least, NOT, note)
    there = t[np.nonzero(np.abs(phi - AIM) > 1e-3)[0][-1] + 1]
    yield Row("within 1 mrad of the aim", "s", None, there, NOT, "9.99 by hand")
    cut = t <= there
    mean = np.sqrt(np.trapezoid(torque[cut] ** 2, t[cut]) / there)
    yield Row("RMS torque until then", "N.m", None, mean, NOT, "4414.7 by hand")
    yield Row("greatest torque under control", "N.m", None, torque.max(), NOT, "9948: at its limit")
    yield Row("least torque under control", "N.m", None, torque.min(), NOT, "-6818 by hand")


def instants(run: lp.Trajectory) -> tuple[float, float, float]:
    """Instants at which the mandrel is taken and put down, and the law becomes linear, s."""
    found = {(e.component, e.after): e.time for e in reversed(run.events)}
    return (
        found["arm.carried", "u >= on"],
        found["arm.carried", "u >= off"],
        found["near", "u >= on"],
    )


def jump(run: lp.Trajectory, instant: float) -> float:
    """Speed of the arm just after an instant over that just before, both noted by the run."""
    before, after = run["arm.trays.w"][np.nonzero(run.t == instant)[0][[0, -1]]]
    return float(after / before)


def plots() -> dict[str, Figure]:
    """Figures by name."""
    from lumped.models.rotary_arm_figures import figures

    return figures()
