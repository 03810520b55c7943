"""Friction, freewheels, dogs, plays and stops, all at once, against a reference in closed form.

``python tests/drives/hybrid_reference.py 1000`` tries a thousand drives, ``python
tests/drives/hybrid_reference.py impacts 10000`` as many impacts.
"""

import signal

import numpy as np
import pytest
from contact_reference import lost, poisson
from hybrid_comparisons import Storm
from hybrid_drives import END, RandomDrive
from hybrid_impacts import RandomImpact, compare_impact
from hybrid_verdicts import alarm, compare

from lumped.errors import SolverError

# -- the reference itself --------------------------------------------------------------------------


def stepped(drive, steps, rounds=20):
    """Positions and speeds at the end by Moreau's time stepping, where every peak is one."""
    q, v, h, rows = drive.q, drive.v, drive.end / steps, drive.rows
    soft = [1 / float(row @ (row / drive.J)) for row in rows]
    for k in range(steps):
        t = (k + 0.5) * h
        begin, end = next(p for p in drive.pieces if p[0] <= t <= p[1])

        def at(line, piece=(begin, end), since=t - begin):
            value, slope = line.on(*piece)
            return value + slope * since

        q, push = q + h / 2 * v, np.zeros(drive.n)
        for row, c, d in drive.springs:
            push -= row * (c * row @ q + d * row @ v)
        for p in drive.loads:
            push += p.row * (at(p.line) + p.size * np.sin(p.rate * t + p.phase))
        limits, back = [], []
        for c, speed in zip(drive.contacts, rows @ v, strict=True):
            slides = h * (at(c.level) + c.rise * abs(speed))
            closed = c.gap + c.row @ q <= 0 if c.kind == "gap" else at(c.level) > 0.5
            free = np.inf if closed else 0.0
            ends = {"gap": (0.0, free), "dog": (-free, free), "freewheel": (-slides, np.inf)}
            limits.append(ends.get(c.kind, (-slides, slides)))
            back.append(c.e * min(speed, 0.0))
        v, r = v + h * push / drive.J, np.zeros(len(rows))
        for _ in range(rounds):
            for i, row in enumerate(rows):
                new = min(max(r[i] - soft[i] * (row @ v + back[i]), limits[i][0]), limits[i][1])
                v, r[i] = v + row / drive.J * (new - r[i]), new
        q = q + h / 2 * v
    return np.concatenate([q, v])


@pytest.mark.parametrize("seed", [4, 17])
def test_the_reference_is_what_time_stepping_converges_to(seed):
    drive = RandomDrive(seed).reference()
    assert all(c.peak == 1 for c in drive.contacts)
    expected = drive.run(np.linspace(0, END, 2))[-1]
    coarse, fine = (np.abs(stepped(drive, n) - expected).max() for n in (400, 800))
    assert fine < 0.6 * coarse < 0.03


# -- random drives and impacts ---------------------------------------------------------------------


def follow(seed):
    """Compare a drive with its closed form."""
    verdict = compare(seed)
    print(verdict)
    if verdict.word in ("law open", "reference lost", "knife's edge", "refused"):
        pytest.skip(verdict.word)
    assert verdict.word == "agrees"


@pytest.mark.parametrize("seed", range(24))
def test_random_drives_move_as_their_closed_form_does(seed):
    follow(seed)


@pytest.mark.parametrize("seed", range(150))
def test_random_impacts_obey_newtons_law_and_lose_energy(seed):
    verdict = compare_impact(seed)
    assert verdict.word in ("agrees", "law open, sound"), verdict.text


def test_poissons_law_answers_every_impact_without_a_gain():
    for seed in range(100):
        case = RandomImpact(seed)
        after = poisson(case.J, case.v, case.W, case.e, case.D)
        size = 1 + float(case.J @ case.v**2)
        assert lost(case.J, case.v, after) >= -1e-10 * size
        assert (case.W @ after).min(initial=0.0) >= -1e-9 * size


def test_poissons_law_is_newtons_for_one_contact():
    J, v, W = np.array([1.0, 2.0]), np.array([3.0, -1.0]), np.array([[-1.0, 1.0]])
    received = poisson(J, v, W, np.array([0.6]), np.zeros((0, 2)))
    assert W @ received == pytest.approx(0.6 * 4.0)
    assert J @ received == pytest.approx(J @ v)


# -- storms ----------------------------------------------------------------------------------------


@pytest.fixture
def patience(request):
    """Ten seconds, or as many as are given."""
    signal.signal(signal.SIGALRM, alarm)
    signal.alarm(getattr(request, "param", 10))
    yield
    signal.alarm(0)


STORMS = [
    ("plays", 0.9, 2),
    ("plays", 0.9, 3),
    ("stops", 0.9, 1),
    ("stops", 0.9, 2),
    ("stops", 0.9, 3),
]


@pytest.mark.parametrize("case", STORMS)
def test_storms_of_impacts_end_at_rest_with_their_energy_lost(case, patience):
    run, losses, gone, left = Storm(*case).run()
    assert run.t[-1] == 1.0
    assert left < 1e-9
    assert sum(losses) == pytest.approx(gone, rel=1e-6, abs=1e-12)
    assert min(losses) >= -1e-12 * sum(losses)


@pytest.mark.parametrize("patience", [5], indirect=True)
def test_a_limit_of_steps_ends_a_storm(patience):
    with pytest.raises(SolverError, match="max_steps"):
        Storm("plays", 0.999, 2).run(max_steps=300)
