"""Each run of an ensemble has the bits of the run that `simulate` makes, whoever makes it.

``python tests/drives/ensemble_runs.py hybrid 0 500`` tries other drives, as ``smooth 2000 2500``
does.
"""

from collections import Counter

import numpy as np
import pytest
from ensemble_runs import (
    RUNS,
    Alone,
    all_functionals,
    assert_equal_to_single_runs,
    assert_same_bits,
    compare,
    drive,
    ran,
    states,
    to_vary,
)
from linkages import four_bar
from machine_scenes import SCENES, asked
from rows import in_a_row, in_rows
from stiff_in_turn import UNTIL, InTurn

import lumped as lp
from lumped import functionals as fun
from lumped.components import (
    Brake,
    Clutch,
    Coupling,
    Fixed,
    Inertia,
    NonlinearSpring,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.kernel import engine
from lumped.ops import sin, where

paired = lp.ensembles.paired
EXPLICIT = ("explicit", "taylor")
DRIVES = [("hybrid", seed) for seed in range(704, 728, 2)]
DRIVES += [("smooth", seed) for seed in (2100, 2101, 2102, 2103, 2105)]


@pytest.mark.parametrize(("kind", "seed"), DRIVES)
def test_random_drives(kind, seed):
    events, failed, steps, away = compare(kind, seed)
    print(
        f"{events} of {RUNS} runs have events, {failed} fail, {steps} steps, {away:.0e} of samples"
    )
    assert away < 1e-4


def test_a_clutch_that_a_command_closes_has_the_events_of_its_single_run():
    model = in_a_row(
        a=Inertia(J=1.0, w=3.0),
        clutch=Clutch(f_max=4.0, characteristic=((0.0, 1.0),), u=where(lp.time >= 0.5, 1.0, 0.0)),
        b=Inertia(J=1.0, w=0.0),
    )
    system, of = lp.assemble(model), [fun.count("clutch"), fun.instant("clutch", number=1)]
    run = lp.simulate(system, until=2.0, method="steps", grid=[2.0])
    times = [event.time for event in run.events if event.component == "clutch"]
    found = lp.ensemble(system, over={"a.J": [1.0]}, until=2.0, of=of)
    assert found.values[0].tolist() == [len(times), times[1]]


# -- machines --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SCENES)
def test_the_five_machines(name):
    system, options = asked(name)
    given = dict(options.get("parameters") or {})
    varied = to_vary(system, np.random.default_rng(5), 2)
    own = np.array([given.get(key, system.parameters[key]) for key in varied], dtype=float)
    points = own * np.linspace(0.97, 1.02, 4)[:, None]
    rest = {k: options[k] for k in ("parameters", "start", "begin") if options.get(k) is not None}
    _, runs = assert_equal_to_single_runs(
        system, varied, points, states(system), options["until"], rtol=1e-7, **rest
    )
    done = [run for run in runs if run is not None]
    print(f"{name}: {varied}, {len(done)} runs, {sum(len(run.events) for run in done)} events")
    assert done


# -- methods ---------------------------------------------------------------------------------------


def stiff(bodies, brakes=False):
    """Bodies on stiff shafts with dampers, driven slowly, and perhaps a brake that sticks."""
    parts = {"brake": Brake(f_max=4.0, u=1.0, characteristic=((0.0, 1.0),))} if brakes else {}
    return in_rows(
        "drive body/shaft wall",
        *(f"drive {name}" for name in parts),
        drive=Torque(tau=10 * sin(lp.time)),
        body=[Inertia(J=1e-3) for _ in range(bodies)],
        shaft=[SpringDamper(c=1e4, d=100.0) for _ in range(bodies)],
        wall=Fixed(),
        **parts,
    )


@pytest.mark.parametrize("method", ["steps", "explicit", "implicit", "taylor"])
@pytest.mark.parametrize("brakes", [False, True])
def test_stiff_drives_by_all_methods(method, brakes):
    """By steps, all change over to implicit ones in the middle of a run."""
    system, until = lp.assemble(stiff(3, brakes)), 0.4 if method in EXPLICIT else 2.0
    varied = ["shaft[0].d", "body[1].J"]
    points = np.array([[100.0, 1e-3], [70.0, 2e-3], [0.1, 1e-3], [130.0, 3e-3], [90.0, 1e-3]])
    names, times = states(system), (0.1, 0.3)
    _, runs = assert_equal_to_single_runs(
        system, varied, points, names, until, times, method=method, rtol=1e-7
    )
    told = Counter(run.statistics.method for run in runs)
    print(method, told)
    if method == "steps":
        assert told["explicit then implicit"] >= 4
    if method not in EXPLICIT:
        of, options = all_functionals(system, until), {"method": method, "rtol": 1e-7}
        one = ran(system, varied, points, of, until, **options)
        assert_same_bits(one, ran(system, varied, points, of, until, Alone, **options))


@pytest.mark.parametrize("method", ["steps", "taylor"])
def test_runs_that_are_stiff_and_soft_in_turn(method):
    """Each turns there and back at times of its own; lanes take it back for explicit steps."""
    system = lp.assemble(InTurn(cubic=1e3))
    rng = np.random.default_rng(3)
    varied = ["J", "c", "d"]
    points = np.array([2.0, 8e4, 2e6]) * rng.uniform([0.3, 0.3, 1e-3], [3.0, 3.0, 1.0], (24, 3))
    names, options = states(system), {"method": method, "rtol": 1e-7}
    _, runs = assert_equal_to_single_runs(
        system, varied, points, names, UNTIL, (1.3, 2.2), **options
    )
    turns = {tuple(used.begin for used in run.statistics.methods) for run in runs}
    assert len(turns) == len(runs)
    first = "explicit" if method == "steps" else "taylor"
    told = Counter(run.statistics.method for run in runs)
    assert told[f"{first} and implicit"] >= 20
    of = all_functionals(system, UNTIL)
    one = ran(system, varied, points, of, UNTIL, **options)
    assert_same_bits(one, ran(system, varied, points, of, UNTIL, Alone, **options))


def test_implicit_random_drives():
    for kind, seed in (("hybrid", 700), ("hybrid", 704), ("smooth", 2101)):
        system, until, varied, points = drive(kind, seed)
        assert_equal_to_single_runs(
            system, varied, points[:3], states(system), until, (0.3,), method="implicit"
        )


# -- instants and starts of their own --------------------------------------------------------------


class Switched(lp.Component):
    """Torques that change at instants that move with parameters, one of them by a sine."""

    rate: lp.Param = lp.param("rad/s", "angular rate", 10.0)
    on: lp.Param = lp.param("s", "an instant", 0.4)
    ground: Fixed = Fixed()
    shaft: Spring = Spring(c=40.0)
    body: Inertia = Inertia(J=2.0, w=0.0)
    drive: Torque = Torque(tau=where(lp.time >= on, 2.0, -1.0))
    wave: Torque = Torque(tau=where(sin(rate * lp.time) > 0, 1.0, -1.0))

    def connections(self):
        yield from lp.chain(self.ground, self.shaft, self.body, self.drive)
        yield lp.connect(self.wave.flange, self.body.flange_a)


@pytest.mark.parametrize("varied", [["on"], ["rate"], ["on", "rate"], ["body.J"]])
def test_instants_that_move(varied):
    system, rng = lp.assemble(Switched()), np.random.default_rng(6)
    ranges = {"on": (-0.2, 1.2), "rate": (1.0, 40.0), "body.J": (1.0, 3.0)}
    points = np.column_stack([rng.uniform(*ranges[name], 12) for name in varied])
    if "on" in varied:
        points[:4, 0] = 0.0, 1.0, 2 * np.pi / 10, 0.9
    names = ["shaft.phi_rel", "body.w", "body.a"]
    assert_equal_to_single_runs(system, varied, points, names, 1.0, (0.2, 0.9))
    of = all_functionals(system, 1.0)
    one = ran(system, varied, points, of, 1.0)
    assert_same_bits(one, ran(system, varied, points, of, 1.0, Alone))


def loaded(spring):
    return in_a_row(ground=Fixed(), shaft=spring, body=Inertia(J=2.0, w=0.0))


PARABOLA = NonlinearSpring(characteristic=lambda x: 50.0 * x + 400.0 * x**3)


@pytest.mark.parametrize(
    ("model", "varied", "start"),
    [
        (loaded(SpringDamper(c=100.0, d=1.0)), {"shaft.c": (50.0, 150.0)}, {"shaft.tau": 30.0}),
        (loaded(PARABOLA), {"body.J": (1.0, 3.0)}, {"shaft.tau": 30.0}),
        (four_bar(w=10.0), {"linkage.r": (0.9, 1.05), "crank.J": (1.0, 3.0)}, {}),
        (four_bar(), {"linkage.c": (2.9, 3.1)}, {"rocker.w": 2.0, "rocker.phi": 2.0}),
    ],
)
def test_starts_that_torques_or_linkages_determine(model, varied, start):
    """Where the start must be searched for, each run has its own."""
    system = lp.assemble(model)
    points = np.column_stack([np.linspace(*ends, 6) for ends in varied.values()])
    names = ["shaft.tau"] if hasattr(model, "shaft") else ["rocker.phi", "crank.w"]
    _, runs = assert_equal_to_single_runs(
        system, list(varied), points, names, 0.7, (0.2,), start=start, rtol=1e-7
    )
    assert None not in runs


def test_a_collision_at_a_start_that_is_searched_for_is_an_event():
    """The torque of a curved spring is given, and a closed dog clutch joins two speeds."""
    model = in_a_row(
        wall=Fixed(),
        shaft=PARABOLA,
        a=Inertia(J=1.0, w=3.0),
        dog=Coupling(u=1.0),
        b=Inertia(J=1.0, phi=0.0, w=0.0),
    )
    system, start = lp.assemble(model), {"shaft.tau": 30.0}
    of = [fun.count("dog"), fun.loss("dog"), fun.instant("dog")]
    run = lp.simulate(system, until=1.0, method="steps", grid=[1.0], start=start)
    assert [(event.time, event.loss) for event in run.events] == [(0.0, pytest.approx(2.25))]
    found = lp.ensemble(system, over={"a.J": [1.0]}, until=1.0, of=of, start=start)
    assert found.values[0] == pytest.approx([1.0, 2.25, 0.0])


# -- whoever works ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rubbing():
    """A hybrid drive, what varies, 90 variants, and all functionals."""
    system, until, varied, points = drive("hybrid", 708)
    rng = np.random.default_rng(1)
    points = points[0] * rng.uniform(0.95, 1.05, (90, points.shape[1]))
    over = paired(dict(zip(varied, points.T, strict=True)))
    of = all_functionals(system, until)
    return system, {"over": over, "until": until, "of": of}


def test_any_number_of_threads_gives_the_same_bits_again_and_again(rubbing):
    system, given = rubbing
    first = lp.ensemble(system, workers=1, **given)
    for workers in (1, 2, 5, None):
        other = lp.ensemble(system, workers=workers, **given)
        np.testing.assert_array_equal(other.values, first.values)
        assert other.failures == first.failures
    fresh = lp.ensemble(drive("hybrid", 708)[0], workers=2, **given)
    np.testing.assert_array_equal(fresh.values, first.values)


def test_the_order_of_runs_changes_no_bit(rubbing):
    system, given = rubbing
    whole = lp.ensemble(system, **given)
    order = np.random.default_rng(2).permutation(len(whole))[:23]
    over = paired(dict(zip(whole.names, whole.points[order].T, strict=True)))
    part = lp.ensemble(system, **{**given, "over": over})
    np.testing.assert_array_equal(part.values, whole.values[order])


@pytest.mark.parametrize("name", ["c", "python"])
def test_other_engines_give_the_same_bits(name):
    """Without lanes, and in Python or C instead of machine code by LLVM."""
    model = lp.compose(
        body=Inertia(J=1.0, phi=0.0, w=2.0),
        brake=Brake(f_max=1.5, u=1.0, characteristic=((0.0, 1.0),)),
        drive=Torque(tau=2.0 * sin(5.0 * lp.time)),
        connections=lambda m: lp.chain(m.drive, m.body, m.brake),
    )
    system, until = lp.assemble(model), 1.5
    of, points = all_functionals(system, until), np.array([[1.5], [0.7], [3.0]])
    expected = ran(system, ["brake.f_max"], points, of, until)
    with engine.using(name):
        received = ran(system, ["brake.f_max"], points, of, until)
        found = lp.ensemble(system, over={"brake.f_max": points.ravel()}, until=until, of=of)
    assert_same_bits(received, expected)
    np.testing.assert_array_equal(found.values, expected.values)
