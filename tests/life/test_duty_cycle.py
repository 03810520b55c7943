"""Duty cycles, against histories that are written out in full and counted by hand."""

import collections

import numpy as np
import pytest
from rows import assemble_one, assemble_row

import lumped as lp
from lumped.components import Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptionError
from lumped.life import LoadCase, SNCurve, duty_cycle, goodman
from lumped.life.duty_cycle import count_in_turn

CURVE = SNCurve(knee=5.0, cycles=1e6, slope=4.0)


def closed(values):
    """Cycles that four points close, by valley and peak: plain lists, written for this test."""
    kept = [values[0]]
    for value in values[1:]:
        if value != kept[-1]:
            kept.append(value)
    found, points = collections.Counter(), []
    for i, value in enumerate(kept):
        inner = 0 < i < len(kept) - 1
        if inner and (value - kept[i - 1]) * (kept[i + 1] - value) > 0:
            continue
        points.append(value)
        while len(points) >= 4:
            a, b, c, d = points[-4:]
            if abs(c - b) > min(abs(b - a), abs(d - c)):
                break
            found[min(b, c), max(b, c)] += 1
            del points[-3:-1]
    return found


def written_out(loads, repetitions):
    """Cycles that one more turn of a long history adds."""
    turn = np.concatenate([np.tile(v, n) for v, n in zip(loads, repetitions, strict=True)])
    return closed(np.tile(turn, 6)) - closed(np.tile(turn, 5))


def test_cycles_are_those_of_the_history_written_out():
    rng = np.random.default_rng(7)
    for _ in range(100):
        count = int(rng.integers(1, 4))
        sizes = rng.integers(2, 14, count)
        loads = [rng.integers(-6, 7, size).astype(float) for size in sizes]
        repetitions = rng.integers(1, 6, count).tolist()
        cycles, _ = count_in_turn(loads, repetitions)
        found = collections.Counter()
        for r, m, n in zip(cycles.ranges, cycles.means, cycles.counts, strict=True):
            found[m - r / 2, m + r / 2] += n
        assert found == written_out(loads, repetitions)


def test_the_large_cycle_from_one_case_to_the_other_counts_once():
    up, down = [0.0, 8.0, 0.0], [0.0, -6.0, 0.0]
    found = duty_cycle(
        {"up": LoadCase(up, 600, step=0.5), "down": LoadCase(down, 40, step="250 ms")}, curve=CURVE
    )

    def damage(valley, peak):
        return (0.5 * (peak - valley) / 5) ** 4 / 1e6

    assert found.damages == pytest.approx([599 * damage(0, 8), 39 * damage(-6, 0)], rel=1e-12)
    assert found.between == pytest.approx(damage(-6, 8), rel=1e-12)
    total = 599 * damage(0, 8) + 39 * damage(-6, 0) + damage(-6, 8)
    assert found.life == pytest.approx(1 / total, rel=1e-12)
    assert found.duration == 600 * 1.0 + 40 * 0.5
    assert found.hours == pytest.approx(620 / 3600 / total, rel=1e-12)
    assert found.worst == "up"
    text = repr(found)
    for told in ("up", "down", "between cases", "600", "14"):
        assert told in text


def test_a_smaller_case_keeps_its_cycles():
    found = duty_cycle(
        {"a": LoadCase([0, 8, 0], 1, step=1), "b": LoadCase([0, 3, 0], 50, step=1)}, curve=CURVE
    )
    # from rest to rest: neither makes the other's cycles larger
    assert found.between == 0
    assert found.damages == pytest.approx([0.8**4 / 1e6, 50 * 0.3**4 / 1e6], rel=1e-12)


def test_means_count():
    found = duty_cycle(
        {"a": LoadCase([100.0, 300.0, 100.0], 9, step=1)}, curve=CURVE, mean_stress=goodman(500.0)
    )
    assert found.damage == pytest.approx(9 * (100 / (1 - 200 / 500) / 5) ** 4 / 1e6, rel=1e-12)


@pytest.fixture(scope="module")
def swinging():
    return assemble_row(
        load=Torque(tau=-10.0),
        body=Inertia(J=1.0),
        spring=SpringDamper(c=100.0, d=0.4),
        ground=Fixed(),
    )


def test_runs_systems_and_histories_stand_beside_each_other(swinging):
    run = lp.simulate(swinging, until=20.0, grid=None, rtol=1e-8)
    soft = {"load.tau": -4.0}
    found = duty_cycle(
        {
            "run": LoadCase(run, 3),
            "system": LoadCase(swinging, 5, until="20 s", parameters=soft),
            "history": LoadCase([10.0, 11.0, 9.0, 10.0], 7, step=0.1),
        },
        of="spring.phi_rel",
        curve=SNCurve(knee=0.01, cycles=1e6, slope=4.0),
        scale=0.5,
        rtol=1e-8,
    )
    # a load that is put on at once: q is the overshoot of half a period
    q = np.exp(-np.pi * 0.02 / np.sqrt(1 - 0.02**2))
    swings = np.append(1 - (-q) ** np.arange(63), 1.0)
    values = [0.1 * swings, 0.04 * swings, np.array([10.0, 11.0, 9.0, 10.0])]
    wanted = sum(
        n * (0.25 * (peak - valley) / 0.01) ** 4 / 1e6
        for (valley, peak), n in written_out(values, (3, 5, 7)).items()
    )
    assert found.unit == "rad"
    assert found.durations == pytest.approx([20.0, 20.0, 0.3])
    assert found.damage == pytest.approx(wanted, rel=1e-6)
    frame = found.to_pandas()
    assert frame["damage"].sum() == pytest.approx(wanted, rel=1e-6)
    assert frame["case"].tolist() == ["run", "system", "history", "between cases"]
    html = found._repr_html_()
    assert html.count("<svg") == 4
    assert "between cases" in html


def test_its_picture_has_the_shares_and_the_spectrum(swinging):
    found = duty_cycle(
        {"up": LoadCase([0, 8, 0], 600, step=1), "down": LoadCase([0, -6, 0], 40, step=1)},
        curve=CURVE,
    )
    figure = found.plot()
    shares, spectrum = figure.axes[:2]
    widths = [bar.get_width() for bar in shares.patches]
    wanted = 100 * np.array([*found.damages, found.between]) / found.damage
    assert widths == pytest.approx(wanted)
    line = spectrum.get_lines()[0]
    # one cycle of 14, 600 above 8 or more, 639 of at least 6
    steps = dict(zip(line.get_ydata()[1::2], line.get_xdata()[1::2], strict=True))
    assert steps[14.0] == 1
    assert steps[8.0] == 600
    assert steps[6.0] == 639


def test_without_damage_it_lives_for_ever():
    found = duty_cycle(
        {"rest": LoadCase([1.0, 1.0], 2, step=1)}, curve=SNCurve(5.0, 1e6, 4.0, below="original")
    )
    assert (found.damage, found.life, found.hours) == (0.0, np.inf, np.inf)
    assert "no damage" in repr(found)
    found.plot()


VALUES = [0.0, 1.0, 0.0]


@pytest.mark.parametrize(
    ("cases", "options", "match"),
    [
        ({}, {}, "at least one load case"),
        ({"a": VALUES}, {}, r"cases\['a'\]"),
        ({"a": LoadCase(VALUES)}, {}, "'a': step, the time between two values"),
        ({"a": LoadCase(VALUES, step=-1)}, {}, "'a': step"),
        ({"a": LoadCase(VALUES, 2.5, step=1)}, {}, r"'a': repetitions = 2.5.* whole"),
        ({"a": LoadCase(VALUES, 0, step=1)}, {}, "'a': repetitions = 0"),
        ({"a": LoadCase(VALUES, step=1, until=3)}, {}, "'a': until = 3: not for a history"),
        ({"a": LoadCase([0.0, np.nan], step=1)}, {}, "'a': load: value 1 is not finite"),
        ({"a": LoadCase("spring.tau", step=1)}, {}, "'a': load = 'spring.tau'"),
        ({"a": LoadCase(VALUES, step=1)}, {"scale": -1.0}, "scale = -1"),
        ({"a": LoadCase("system")}, {"of": "spring.tau"}, "'a': until, the end of the run"),
        ({"a": LoadCase("system", until=1)}, {}, "'a': a run has many quantities"),
        ({"a": LoadCase("system", until=1, step=1)}, {"of": "spring.tau"}, "not for a system"),
        ({"a": LoadCase("run", until=1)}, {"of": "spring.tau"}, "until = 1: not for a run"),
    ],
)
def test_slips_are_named(swinging, cases, options, match):
    given = {"system": swinging, "run": lp.simulate(swinging, until=0.1)}
    made = {}
    for name, case in cases.items():
        is_case = isinstance(case, LoadCase) and isinstance(case.load, str)
        found = given.get(case.load, case.load) if is_case else None
        kept = {k: getattr(case, k) for k in ("repetitions", "until", "step")} if is_case else {}
        made[name] = LoadCase(found, **kept) if is_case else case
    with pytest.raises(OptionError, match=match):
        duty_cycle(made, curve=CURVE, **options)


def test_loads_of_different_units_are_refused():
    def decay(self):
        yield lp.der(self.y) == -self.y

    systems = {unit: assemble_one(decay, y=lp.var(unit, "load", 1.0)) for unit in ("N", "N.m")}
    cases = {unit: LoadCase(system, until=0.1) for unit, system in systems.items()}
    with pytest.raises(OptionError, match=r"different units: N, N\.m"):
        duty_cycle(cases, of="y", curve=CURVE)
