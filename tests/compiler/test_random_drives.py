"""Random drive graphs against mass, damping and stiffness matrices projected on the free motions.

The drives have rotating and sliding bodies, springs and dampers in series and in loops, gears with
fixed and with moving housing, racks, planetary sets, rigid couplings, supports and sources. The
second formulation knows nothing of states: it writes matrices over the coordinates of all nodes,
finds the motions that the rigid parts allow by an SVD, and then eliminates what has no mass.
"""

import numpy as np
import pytest
from random_graphs import random_drive, rank
from rows import in_rows
from scipy.optimize import linear_sum_assignment

import lumped as lp
from lumped.components import (
    Damper,
    IdealGear,
    Inertia,
    Planetary,
    Spring,
    translation,
)

SEEDS, SHARE = 160, 20
END = 0.05
LIMITS = {"accelerations": 1e-9, "torques": 1e-9, "eigenvalues": 1e-9, "speeds": 1e-9}


def deviation(received, expected):
    """Largest difference over the largest expected value, or over 1 if that is smaller."""
    difference = np.abs(np.asarray(received) - expected).max(initial=0.0)
    return float(difference / np.abs(expected).max(initial=1.0))


def matched(received, expected):
    """Both in an order in which they lie nearest to each other."""
    one, other = linear_sum_assignment(np.abs(received[:, None] - expected[None, :]))
    return received[one], expected[other]


def check(seed):
    """Compare one drive with the second formulation; return the deviations."""
    rng = np.random.default_rng(seed)
    graph, expected = random_drive(rng)
    model = graph.model()
    kept = lp.assemble(model, keep=[graph.coordinate(i) for i in range(graph.n)])
    free = lp.assemble(model)

    # The twist of a damper stays a state where it is not a port's angle, although nothing needs it.
    parts = {f"part[{k}]": part for k, part in enumerate(graph.parts)}
    damper = (Damper, translation.Damper)
    twists = [name.split(".")[0] for name in free.state_names if name.endswith("_rel")]
    idle = sum(isinstance(parts[part], damper) for part in twists)
    cyclic = len(expected.stiffness) - rank(expected.stiffness)
    assert len(kept.state_names) == len(expected.A)
    assert len(free.state_names) == len(expected.A) - cyclic + idle

    x = rng.normal(size=len(expected.A))
    q, speed, acceleration = expected.motion(x)
    meaning = graph.meanings()
    start = {n: float(meaning[n][0] @ (q, speed)[meaning[n][1]]) for n in kept.state_names}
    point = lp.start_point(kept, start=start)
    bodies = list(graph.body)
    names = [graph.coordinate(i, 2) for i in bodies] + graph.torques()
    values = np.asarray(kept.function(names)(point.x, point.theta, 0.0, point.settings)).ravel()
    torque = [c * (row @ q - rest) + d * row @ speed for _, row, c, d, rest in graph.links]

    modes = lp.modes(free)
    assert modes.rigid == expected.rigid
    oscillating = np.concatenate([modes.eigenvalues, modes.eigenvalues.conj()])
    eigenvalues = np.concatenate([oscillating, modes.decays, np.zeros(expected.rigid)])

    run = lp.simulate(kept, until=END, start=start, grid=[END / 2, END], rtol=1e-10)
    speeds = [expected.motion(expected.later(x, t))[1][bodies] for t in run.t]
    return {
        "accelerations": deviation(values[: len(bodies)], acceleration[bodies]),
        "torques": deviation(values[len(bodies) :], torque),
        "eigenvalues": deviation(*matched(eigenvalues, expected.eigenvalues())),
        "speeds": deviation(run.table([graph.coordinate(i, 1) for i in bodies]), speeds),
    }


@pytest.mark.parametrize("first", range(0, SEEDS, SHARE))
def test_random_drives_move_as_their_projected_matrices_say(first):
    found = [check(seed) for seed in range(first, first + SHARE)]
    worst = {name: max(e[name] for e in found) for name in LIMITS}
    print(", ".join(f"{name} {value:.1e}" for name, value in worst.items()))
    assert all(worst[name] < limit for name, limit in LIMITS.items())


def test_a_kept_angle_adds_no_rigid_body_mode():
    model = in_rows(
        "a.flange_b one.flange_a gear.sun",
        "one.flange_b b.flange_a two.flange_a gear.ring",
        "two.flange_b c.flange_a gear.carrier",
        a=Inertia(J=1.0),
        b=Inertia(J=2.0),
        c=Inertia(J=3.0),
        one=Spring(c=100.0),
        two=Spring(c=300.0),
        gear=Planetary(ratio=1.7),
    )
    assert lp.modes(lp.assemble(model)).rigid == 1
    assert lp.modes(lp.assemble(model, keep=["a.phi"])).rigid == 1


def test_two_three_shaft_gears_that_lock_each_other_turn_as_one_body():
    model = in_rows(
        "a.flange_b shaft.flange_b set.sun gear.flange_b",
        "b.flange_b shaft.flange_a set.ring gear.flange_a",
        "set.carrier gear.support",
        a=Inertia(J=1.0),
        b=Inertia(J=2.0),
        shaft=Spring(c=100.0),
        set=Planetary(ratio=1.3),
        gear=IdealGear(ratio=-0.7),
    )
    modes = lp.modes(lp.assemble(model))
    assert (modes.rigid, len(modes.hertz), len(modes.decays)) == (1, 0, 0)
