"""Periodic motions over a range of speeds, against tables and independent solutions."""

import numpy as np
import pytest
from periodic_motions import ROTOR, Rotor, torque_for
from torsional_cases import RPM, columns

import lumped as lp
from lumped.errors import OptionError

JR, K1, K3, P = 60 / 7, 20e3, 2.0e6, 150.0
C = 2 * 0.03 * np.sqrt(K1 * JR)


class Hardening(lp.Component):
    """``JR x'' + c x' + k1 x + k3 x^3 == P cos(2 n t)``."""

    x: lp.Var = lp.var("rad", "relative twist")
    v: lp.Var = lp.var("rad/s", "its rate")
    n: lp.Param = lp.param("rad/s", "speed", 30.0)
    c: lp.Param = lp.param("N.m.s/rad", "damping", C)
    J: lp.Param = lp.param("kg.m2", "reduced inertia", JR)
    k1: lp.Param = lp.param("N.m/rad", "stiffness", K1)
    k3: lp.Param = lp.param("N.m/rad3", "its growth", K3)
    P: lp.Param = lp.param("N.m", "torque", P)

    def equations(self):
        yield lp.der(self.x) == self.v
        load = self.P * lp.ops.cos(2 * self.n * lp.time)
        elastic = self.k1 * self.x + self.k3 * self.x**3
        yield self.J * lp.der(self.v) == load - self.c * self.v - elastic


CASE = "09_elastic_coupling"


@pytest.fixture(scope="module")
def sweeps():
    """Motions over rising and falling speeds, 60 periods after rest at the first."""
    system = lp.assemble(Hardening())
    table = columns(CASE, "duffing_hard_branches.csv", texts=("sweep",))
    found = {}
    for sweep in ("up", "down"):
        order = np.argsort(table["n_rpm"], kind="stable")[:: 1 if sweep == "up" else -1]
        own = order[table["sweep"][order] == sweep]
        rows = {key: values[own] for key, values in table.items()}
        motions = lp.orbits.periodic_range(
            system,
            speeds={"n": rows["n_rpm"] * RPM},
            of=["x"],
            orders=[2, 6],
            warm_up=60 * np.pi / (rows["n_rpm"][0] * RPM),
        )
        found[sweep] = motions, rows
    return found


@pytest.mark.parametrize("sweep", ["up", "down"])
def test_branches_of_a_cubic_spring_are_those_of_the_table(sweeps, sweep):
    motions, rows = sweeps[sweep]
    count = len(motions.speeds)
    wanted = {key: rows[key][:count] for key in rows if key != "sweep"}
    first = motions.magnitude("x", 2) / wanted["first_harmonic_exact_rad"] - 1
    third = motions.magnitude("x", 6) / wanted["third_harmonic_exact_rad"] - 1
    top = motions.greatest("x") / wanted["largest_twist_exact_rad"] - 1
    # order 2: a turn is two periods of the torque
    grows = motions.largest / wanted["largest_multiplier"] ** 2 - 1
    worst = [float(np.abs(v).max()) for v in (first, third, top, grows)]
    assert count == {"up": 31, "down": 30}[sweep]
    assert max(worst[:2]) < 1e-7
    assert max(worst[2:]) < 1e-6


@pytest.mark.parametrize(("sweep", "row"), [("up", 1), ("down", 0)])
def test_ranges_end_at_the_folds(sweeps, sweep, row):
    motions, _ = sweeps[sweep]
    fold = columns(CASE, "duffing_hard_folds.csv", texts=("what",))["speed_exact_rpm"][row]
    text = motions.ended
    ended = float(text.removeprefix("ends at ").partition(" ")[0])
    print(text)
    assert 0 < (fold - ended) * (1 if sweep == "up" else -1) < 4 / 2**8
    assert text in repr(motions)
    # all of these are stable; the other sweep tells the motions beyond
    assert (motions.largest < 1).all()


def test_a_linear_range_is_its_closed_form():
    system = lp.assemble(Hardening())
    speeds = np.linspace(20.0, 28.0, 9)
    motions = lp.orbits.periodic_range(
        system, speeds={"n": speeds}, of=["x"], orders=[2], parameters={"k3": 0.0}
    )
    w = 2 * speeds
    wanted = P / (K1 - JR * w**2 + 1j * C * w)
    assert motions["x"][:, 0] == pytest.approx(wanted, rel=1e-8)
    assert motions.multipliers.shape == (9, 2)
    # det of the monodromy matrix: exp(-c T / J)
    det = np.prod(motions.multipliers, axis=1)
    assert det == pytest.approx(np.exp(-C / JR * 2 * np.pi / speeds), rel=1e-8)
    assert motions.synthesis("x").maximum == pytest.approx(np.abs(wanted), rel=1e-8)


SPEEDS = np.linspace(6.0, 20.0, 8)


@pytest.fixture(scope="module")
def rotor():
    system = ROTOR
    response = lp.vibration.order_response(
        system, speeds=SPEEDS, of=["w"], shaft="phi", free="tau", orders=[1]
    )
    return system, response


def test_an_order_response_is_a_first_guess_that_needs_no_simulation(rotor):
    system, response = rotor
    for speed in SPEEDS[[0, 3, 7]]:
        orbit = lp.periodic(system, start=response, speed=speed)
        assert orbit.iterations <= 4
        assert orbit.free["tau"] == pytest.approx(torque_for(2 * np.pi / speed), rel=1e-8), speed
        assert orbit.mean("w") == pytest.approx(speed, rel=1e-9)


def test_a_drive_that_turns_is_followed_over_its_speed(rotor):
    system, response = rotor
    falling = SPEEDS[::-1]
    down = lp.orbits.periodic_range(
        system, start=response, speeds=falling, orders=range(1, 13), of=["w", "phi"]
    )
    assert not down.ended
    torques = [orbit.free["tau"] for orbit in down.orbits]
    assert torques == pytest.approx([torque_for(2 * np.pi / w) for w in falling], rel=1e-8)
    assert down.mean("w") == pytest.approx(falling, rel=1e-9)
    # orders count over the mean angle: there the orders of the angle itself have no mean
    for k, orbit in enumerate(down.orbits):
        mean_angle = falling[k] * orbit.run.t + orbit.mean("phi") - np.pi
        wave = falling[k] + down.synthesis("w").at(mean_angle)[k]
        assert np.abs(wave - orbit.run["w"]).max() < 1e-6 * falling[k]
    limit = lp.vibration.Limit("w", permitted=0.2, measure="half range")
    (barred,) = lp.vibration.verdict(down, [limit]).barred
    assert barred.begin == SPEEDS[0]
    assert SPEEDS[0] < barred.end < SPEEDS[-1]


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"speeds": [1.0, 3.0, 2.0]}, "must ascend or descend"),
        ({"speeds": [0.0, 3.0]}, "above zero"),
        ({"start": None}, "start= an order response, or name the parameter"),
        ({"speeds": {"tau": SPEEDS}}, "start= an order response, or name the parameter"),
        ({"start": None, "speeds": {"tau": SPEEDS, "J": SPEEDS}}, "one parameter is the speed"),
        ({"turns": 2}, "leave these out"),
        ({"orders": [0.5]}, "whole numbers of periods in 1 turn"),
        ({"start": None, "speeds": {"tau": SPEEDS}, "of": ["w"]}, "no function of time acts"),
    ],
)
def test_slips_of_a_range_are_named(rotor, options, text):
    system, response = rotor
    with pytest.raises(OptionError, match=text):
        lp.orbits.periodic_range(system, **{"start": response, "speeds": SPEEDS, **options})


def test_slips_of_a_guess_are_named(rotor):
    system, response = rotor
    with pytest.raises(OptionError, match="the nearest is"):
        lp.periodic(system, start=response, speed=6.5)
    for more in ({}, {"speed": 6.0, "period": 1.0}, {"speed": 6.0, "free": ["tau"]}):
        with pytest.raises(OptionError, match="goes with one of its speeds"):
            lp.periodic(system, start=response, **more)
    with pytest.raises(OptionError, match="that of another system"):
        lp.periodic(lp.assemble(Rotor()), start=response, speed=6.0)
    unbalanced = lp.vibration.order_response(
        system, speeds=[6.0], of=["w"], shaft="phi", orders=[1]
    )
    with pytest.raises(OptionError, match="does not balance the mean torques"):
        lp.periodic(system, start=unbalanced, speed=6.0)
    given = lp.vibration.order_response(
        system,
        speeds=[6.0],
        of=["w"],
        shaft="phi",
        free="tau",
        orders=[1],
        excitations={"G": {1: 0.1}},
    )
    with pytest.raises(OptionError, match=r"a run has no excitations= \(G\)"):
        lp.periodic(system, start=given, speed=6.0)
