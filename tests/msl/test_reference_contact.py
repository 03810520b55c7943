"""Reference results with play, gaps and gas force: trajectories and instants of the events."""

import numpy as np
import pytest
from specification import build, read
from test_reference_cases import Engine, outside_of_tube

import lumped as lp

TOGETHER = 1e-5
"""Instants of the reference that are closer than this are one, s: its solver passes through modes
in between."""


class GasForce(lp.Component):
    """Gas force on a piston, from its position and the sign of its speed."""

    flange = lp.LinearFlange()
    v: lp.Var = lp.var("m/s", "speed away from the head")
    work: lp.Var = lp.var("J", "work done by the gas", state="always")

    def equations(self):
        # the flange is the piston pin, 0.1 m below the top of the piston
        s = 0.45 - (self.flange.s + 0.1)
        yield self.v == -lp.der(self.flange.s)
        x = 1 - s / 0.35
        compression = lp.ops.where(
            x < 0.986061,
            177.4132 * x**4 - 287.2189 * x**3 + 151.8252 * x**2 - 24.9973 * x + 2.4,
            2836360 * x**4 - 10569296 * x**3 + 14761814 * x**2 - 9158505 * x + 2129670,
        )
        expansion = lp.ops.where(
            x <= 0.933,
            145.930 * x**4 - 131.707 * x**3 + 17.3438 * x**2 + 17.9272 * x + 2.4,
            -3929704 * x**4 + 14748765 * x**3 - 20747000 * x**2 + 12964477 * x - 3036495,
        )
        pressure = 1e5 * lp.ops.where(self.v < 0, compression, expansion)
        yield self.flange.f == pressure * np.pi * 0.1**2 / 4
        yield lp.der(self.work) == self.flange.f * self.v


class FiredEngine(Engine):
    """The same engine with gas force."""

    gas: GasForce = GasForce()

    def connections(self):
        yield from super().connections()
        yield lp.connect(self.piston_lift.slide, self.gas.flange)


WRITTEN_OUT = {"engine_fired": FiredEngine}
CASES = ("engine_fired", "mt_tr_all_components", "rot_backlash", "tr_elasto_gap")


def assembled(case, name):
    model = WRITTEN_OUT[name]() if name in WRITTEN_OUT else build(case)
    keep = [q for q in case.columns if q.rpartition(".")[2] in ("phi", "s")]
    return lp.assemble(model, keep=keep)


@pytest.mark.parametrize("name", CASES)
def test_the_trajectory_follows_the_reference(name):
    case = read(name)
    system = assembled(case, name)
    options = {"until": case.stop, "start": case.start, "rtol": 1e-9}
    at_times = lp.simulate(system, grid=case.t, **options)
    fine = lp.simulate(system, grid=4000, **options)
    half_width = case.facts["tolerance"]["relative_width"] * case.stop
    last_at_its_time = np.append(np.diff(case.t) > 0, True)
    faults = []
    for column, expected in case.columns.items():
        span = np.ptp(expected)
        pointwise = np.abs(at_times[column] - expected)[last_at_its_time].max() / span
        tube = outside_of_tube(fine.t, fine[column], case, expected, half_width).max() / span
        print(f"{name} {column}: {pointwise:.1e} of the range, {tube:.1e} in the time window")
        if pointwise > 1e-4 or tube > 2e-3:
            faults.append(column)
    assert not faults


# In mt_tr_all_components the gap is exactly closed at the start and is entered from there on; the
# reference notices it after 4 ms, when the distance exceeds its tolerance. That instant is none of
# physics.
@pytest.mark.parametrize("name", ["engine_fired", "rot_backlash", "tr_elasto_gap"])
def test_events_happen_at_the_instants_of_the_reference_and_at_no_others(name):
    case = read(name)
    run = lp.simulate(
        assembled(case, name), until=case.stop, start=case.start, rtol=1e-9, grid=None
    )
    # the reference takes the limit of the damping for smooth
    changes = [e for e in run.events if not {"damping", "force"} & {*e.before.split()}]
    received = clusters(e.time for e in changes if e.kind != "time")
    expected = clusters(case.facts["experiment"]["event_times"])
    assert len(received) == len(expected)
    error = np.abs(received - expected).max()
    print(f"{name}: {len(expected)} instants, largest difference {error:.1e} s")
    assert error <= TOGETHER


def clusters(times):
    """Sorted instants, those close together as one."""
    found = np.array(sorted(times))
    return found[np.append(True, np.diff(found) > TOGETHER)]


def test_the_work_of_the_gas_is_what_the_engine_gains():
    case = read("engine_fired")
    system = assembled(case, "engine_fired")
    run = lp.simulate(system, until=case.stop, start=case.start, rtol=1e-10)
    turning = ("inertia", "crank", "rod")
    sliding = ("piston", "rod_up", "rod_aside")
    lifted = (("crank_weight", "crank_top"), ("piston_weight", "piston_lift"))
    point = lp.start_point(system, start=case.start)
    energy = sum(point.parameters[f"{n}.J"] * run[f"{n}.w"] ** 2 / 2 for n in turning)
    energy = energy + sum(point.parameters[f"{n}.m"] * run[f"{n}.v"] ** 2 / 2 for n in sliding)
    for weight, lift in (*lifted, ("rod_weight", "rod_lift")):
        energy = energy - point.parameters[f"{weight}.f"] * run[f"{lift}.slide.s"]
    error = np.abs(energy - energy[0] - run["gas.work"]).max()
    print(f"{np.ptp(run['gas.work']):.3g} J of work, books out by {error:.1e} J")
    assert error <= 1e-7 * np.ptp(run["gas.work"])
