"""What is supplied to a machine is stored, rubbed away or lost in impacts, over whole runs."""

import arm_by_hand
import numpy as np
import pytest
from machine_scenes import asked_by
from mill_by_hand import C1, C2, J1, J3, JR

import lumped as lp
from lumped.models.carrousel_coiler.shafts import J_HALF, J_WHEEL, STIFFNESS, jam
from lumped.models.pilger_mill.drive import start_up
from lumped.models.pilger_mill.stand import DESIGNS, SETS, SPEED
from lumped.models.reversing_mill.scenes import skidding
from lumped.models.reversing_mill.stand import KGF
from lumped.models.rotary_arm.control import run_controlled
from lumped.ops import minimum

RTOL = 1e-10
DENSITY = 7850.0 * 1.25 * 1e-3  # kg/m  strip of the coiler


def arm_powers(m):
    journal = m.arm.journal
    return m.motor.tau * m.motor.w, m.reducer.tau_loss * m.reducer.w + journal.tau * journal.w


def arm_stored(at):
    empty, loaded, rotor = arm_by_hand.EMPTY, arm_by_hand.LOADED, arm_by_hand.ROTOR
    trays, both = arm_by_hand.gravity(0.0, 0), arm_by_hand.gravity(0.0, 1)
    moved = (empty + rotor) * at("arm.trays.w") ** 2 + (loaded - empty) * at("arm.mandrel.w") ** 2
    lifted = trays * np.sin(at("arm.phi")) + (both - trays) * np.sin(at("arm.mandrel.phi"))
    return moved / 2 + lifted


def stand_powers(m):
    drives = sum(side.drive.tau * side.motor.w for side in (m.upper, m.lower))
    rolled = m.upper_load.tau * m.upper.rolls.w + m.lower_load.tau * m.lower.rolls.w
    return drives + rolled, m.gap.tau * m.gap.w_rel


def stand_stored(at):
    inertias = {"motor": J1, "gearbox": J3, "rolls": JR}
    moved = sum(
        J * at(f"{side}.{part}.w") ** 2
        for side in ("upper", "lower")
        for part, J in inertias.items()
    )
    springs = {"upper.shaft": C1, "upper.spindle": C2, "lower.spindle": C2}
    twisted = sum((at(f"{name}.tau") / KGF) ** 2 / c for name, c in springs.items())
    return KGF * (moved + twisted) / 2


def pilger_powers(m):
    mill = m.mill
    return m.motor.tau * m.motor.w, (
        mill.load.flange.f * mill.stand.v + mill.feed.flange.tau * m.shaft.w
    )


def pilger_stored(at):
    p = SETS["P"] | DESIGNS["after"]
    fixed = p["m_pin"] * 0.59**2 + 4 * p["U"] * 0.9 + 3000.0 + 15.6**2 * 30.0
    fixed += 2 * 0.55 * (p["m_rod"] + p["m_rod_1"]) * 0.59**2
    twice = fixed * at("shaft.w") ** 2
    trains = (
        ("stand", p["m1"] + 1100 * (0.21 / 0.19) ** 2, p["m_rod"], 4.25),
        ("weight", p["m2"], p["m_rod_1"], 3.4),
    )
    for part, slider, rod, length in trains:
        twice = twice + (slider + 2 * 0.45 * rod) * at(f"mill.{part}.v") ** 2
        about = 2 * rod * length**2 * (1 / 12 - 0.05**2 - 0.45 * 0.55)
        twice = twice + about * at(f"mill.{part}.w_rod") ** 2
    return twice / 2


def coiler_powers(m):
    drive, v = m.drive, lp.der(m.drive.strip.s)
    supplied = drive.motor.tau * drive.rotor.w - m.T * v + DENSITY * v**3 / 2  # it brings its own
    rubbed = drive.rub.flange_a.tau * drive.mandrel.w
    return supplied, drive.coupling.tau * drive.coupling.w_rel + rubbed


def coiler_stored(at):
    R = at("drive.coil.R")
    coil = np.pi * 7850.0 * 1.25 / 2 * (R**4 - 0.305**4)
    moved = 600.0 * at("drive.rotor.w") ** 2 + J_HALF * at("drive.half.w") ** 2
    moved = moved + J_WHEEL * at("drive.wheel.w") ** 2
    moved = moved + (500.0 - J_WHEEL + coil) * at("drive.mandrel.w") ** 2
    return moved / 2 + at("drive.shaft.tau") ** 2 / (2 * STIFFNESS)


WANTED = {"wanted": minimum(lp.time / 6.0, 1.0) * 15.6 * SPEED["P"]}


@pytest.mark.parametrize(
    ("scene", "changes", "powers", "stored", "impacts"),
    [
        (lambda: run_controlled(until=8.0), {}, arm_powers, arm_stored, True),
        (skidding, {}, stand_powers, stand_stored, False),
        (lambda: start_up(until=7.0), WANTED, pilger_powers, pilger_stored, False),
        (jam, {}, coiler_powers, coiler_stored, False),
    ],
    ids=["rotary arm", "reversing mill", "pilger mill", "coiler"],
)
def test_what_is_supplied_is_stored_rubbed_away_or_lost_in_impacts(
    scene, changes, powers, stored, impacts
):
    system, options = asked_by(scene)

    class Booked(lp.Component):
        """A machine with the energies that pass through it."""

        machine: lp.Component = system.model.with_(changes)
        work: lp.Var = lp.var("J", "supplied", state="always")
        heat: lp.Var = lp.var("J", "rubbed away", state="always")
        turned: lp.Var = lp.var("J", "turned over", state="always")

        def equations(self):
            supplied, rubbed = powers(self.machine)
            yield lp.der(self.work) == supplied
            yield lp.der(self.heat) == rubbed
            yield lp.der(self.turned) == abs(supplied) + rubbed

    for name in ("parameters", "start"):
        given = dict(options.get(name) or {})
        options[name] = {f"machine.{key}": value for key, value in given.items()}
    kept = [f"machine.{name}" for name in system.state_names]
    booked = lp.assemble(Booked(), keep=[*kept, "work", "heat", "turned"])
    run = lp.simulate(booked, **options, grid=100, rtol=RTOL)
    energy = stored(lambda name: run[f"machine.{name}"])
    lost = sum(event.loss for event in run.events)
    turned = run["turned"][-1] + lost
    error = run["work"][-1] - (energy[-1] - energy[0]) - run["heat"][-1] - lost
    print(f"{error:.1e} J of {turned:.4g} J; {run['heat'][-1]:.4g} J, {lost:.4g} J lost")
    assert abs(error) < RTOL * turned
    assert (np.diff(run["heat"]) >= -RTOL * turned).all()
    assert run["heat"][-1] > 0.1 * turned
    assert (lost > 0) == impacts
