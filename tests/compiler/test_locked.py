"""Rigid loops that leave no motion: refused where they lock themselves, reported where held."""

import re

import numpy as np
import pytest
from random_graphs import locked, random_drive
from rows import assemble_rows

import lumped as lp
from lumped.components import Fixed, IdealGear, Inertia, Planetary, RackAndPinion, Speed, Torque
from lumped.errors import SingularModelError
from lumped.language.declared import values_of


def find_constraint_row(graph, k):
    """Constraint of a gear, rack or planetary set, by coordinate."""
    part, ends, row = graph.parts[k], graph.ends[k], np.zeros(graph.n + 1)
    node = {port: ends.get(port, graph.n) for port in (*ends, "support")}  # the last is fixed
    given = values_of(part)
    if isinstance(part, RackAndPinion):
        factors = {"flange_b": 1.0, "flange_a": -given["radius"]}
    elif isinstance(part, IdealGear):
        ratio = given["ratio"]
        factors = {"flange_a": 1.0, "flange_b": -ratio, "support": ratio - 1}
    else:
        ratio = given["ratio"]
        factors = {"carrier": 1 + ratio, "sun": -1.0, "ring": -ratio}
    for port, factor in factors.items():
        row[node[port]] += factor
    return row[:-1]


@pytest.mark.parametrize("first", range(0, 180, 60))
def test_random_drives_that_lock_are_refused_with_the_loop_that_locks(first):
    for seed in range(first, first + 60):
        graph, _ = random_drive(np.random.default_rng(seed), lock=True)
        with pytest.raises(SingularModelError, match="leave no motion") as caught:
            lp.assemble(graph.model())
        named = [int(k) for k in re.findall(r" in part\[(\d+)\] ", str(caught.value))]
        couplings = [np.eye(graph.n)[i] - np.eye(graph.n)[j] for i, j in graph.couplings]
        loop = np.array([find_constraint_row(graph, k) for k in named])
        assert len(named) == len(set(named)) > 0
        assert locked(np.array([*loop, *couplings]))[np.any(loop, axis=0)].all()


def gearbox(one, two):
    """Two planetary sets with common ring and carrier; something at each sun."""
    return assemble_rows(
        "front.sun one.flange",
        "rear.sun two.flange",
        "front.ring rear.ring ring.flange_a drive.flange",
        "front.carrier rear.carrier carrier.flange_a",
        drive=Torque(tau=5.0),
        ring=Inertia(J=1.0),
        carrier=Inertia(J=2.0),
        front=Planetary(ratio=2.0),
        rear=Planetary(ratio=3.0),
        one=one,
        two=two,
    )


def entries(system):
    """What the system lists as locked."""
    return [entry for entry in system.left_out if entry.why.startswith("locked")]


def test_a_gearbox_held_by_two_brakes_is_reported_and_its_brakes_bear_the_torque():
    system = gearbox(Fixed(), Fixed(phi0=0.3))
    (entry,) = entries(system)
    assert entry.what == "ring.phi, carrier.phi"
    assert "front (Planetary), rear (Planetary)" in entry.why
    # virtual work of the drive and of torques t on the suns, for any speeds of ring and carrier:
    # 5 - 2 t_1 - 3 t_2 = 0, 3 t_1 + 4 t_2 = 0
    expected = np.linalg.solve([[2.0, 3.0], [3.0, 4.0]], [5.0, 0.0])
    point = lp.start_point(system)
    received = [-point["one.flange.tau"], -point["two.flange.tau"]]
    assert received == pytest.approx(expected, abs=1e-12)
    assert point["ring.w"] == point["carrier.w"] == 0


def test_a_gearbox_with_a_brake_and_a_prescribed_speed_turns():
    system = gearbox(Fixed(), Speed(w=6.0))
    assert entries(system) == []
    # 0 = 3 w_c - 2 w_r, 6 = 4 w_c - 3 w_r
    expected = np.linalg.solve([[3.0, -2.0], [4.0, -3.0]], [0.0, 6.0])
    point = lp.start_point(system)
    assert [point["carrier.w"], point["ring.w"]] == pytest.approx(expected, abs=1e-12)


def side_by_side(housing, port):
    """Two gears of unequal ratio between two shafts, in one housing."""
    return lp.assemble(
        lp.compose(
            drive=Torque(tau=5.0),
            a=Inertia(J=1.0),
            b=Inertia(J=2.0),
            one=IdealGear(ratio=2.0),
            two=IdealGear(ratio=3.0),
            housing=housing,
            connections=lambda m: [
                lp.connect(m.drive.flange, m.a.flange_a),
                lp.connect(m.a.flange_b, m.one.flange_a, m.two.flange_a),
                lp.connect(m.one.flange_b, m.two.flange_b, m.b.flange_a),
                lp.connect(m.one.support, m.two.support, getattr(m.housing, port)),
            ],
        )
    )


def test_gears_that_lock_each_other_turn_as_one_body_with_their_housing():
    system = side_by_side(Inertia(J=3.0), "flange_a")
    assert entries(system) == []
    assert lp.start_point(system)["b.a"] == pytest.approx(5.0 / (1.0 + 2.0 + 3.0), rel=1e-12)


class Wall(lp.Component):
    """A support without a parameter: phi = 0."""

    flange = lp.Flange()

    def equations(self):
        yield self.flange.phi == 0


@pytest.mark.parametrize("wall", [Fixed(phi0=0.2), Wall()])
def test_gears_that_lock_each_other_in_a_held_housing_are_reported(wall):
    (entry,) = entries(side_by_side(wall, "flange"))
    assert entry.what == "a.phi, b.phi"


def test_a_held_body_is_no_locked_loop():
    system = assemble_rows(
        "wall.flange set.carrier",
        "set.sun set.ring a.flange_a",
        "a gear b",
        wall=Fixed(),
        set=Planetary(ratio=2.0),
        a=Inertia(J=1.0),
        gear=IdealGear(ratio=3.0),
        b=Inertia(J=1.0),
    )
    assert entries(system) == []
    assert lp.start_point(system)["b.w"] == 0
