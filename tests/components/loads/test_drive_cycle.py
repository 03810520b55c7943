"""The WLTC against the totals that its regulation publishes, and a vehicle that drives it."""

import numpy as np
import pytest
from rows import assemble_rows

import lumped as lp
from lumped.components import WLTC_3B, Speed, Vehicle

V = np.array(WLTC_3B)
PHASES = {
    "low": (0, 589, 3095, 56.5),
    "medium": (589, 1022, 4756, 76.6),
    "high": (1022, 1477, 7162, 97.4),
    "extra high": (1477, 1800, 8254, 131.3),
}
CAR = {"m": 1500.0, "R": 0.31, "A": 2.2, "cd": 0.3, "cr": 0.01}


def test_the_cycle_has_the_length_and_the_top_speed_of_its_regulation():
    """1800 s, 23 266 m, 131.3 km/h."""
    assert len(V) == 1801
    assert np.trapezoid(V) == pytest.approx(23266, abs=0.5)
    assert 3.6 * V.max() == pytest.approx(131.3, rel=1e-12)
    assert V[0] == V[-1] == 0


@pytest.mark.parametrize("phase", PHASES)
def test_each_phase_has_its_length_and_top_speed(phase):
    begin, end, length, top = PHASES[phase]
    assert np.trapezoid(V[begin : end + 1]) == pytest.approx(length, abs=0.6)
    assert 3.6 * V[begin : end + 1].max() == pytest.approx(top, rel=1e-12)


def test_work_of_a_vehicle_is_that_of_air_and_tyres():
    """``k int v^3 dt + f int v dt``, exact for the straight lines between the seconds."""
    wanted = lp.ops.table(range(1801), V)
    car = Vehicle(**CAR, inclination=0.0, v_wind=0.0, v_reg=1e-6)
    system = assemble_rows(
        "turn.flange car.wheel",
        turn=Speed(w=wanted / CAR["R"]),
        car=car,
        keep=["turn.flange.tau", "car.v"],
    )
    work = lp.functionals.integral("turn.flange.tau", "car.v")
    run = lp.simulate(system, until=1800.0, rtol=1e-9)
    u, v = V[:-1], V[1:]
    drag = 1.2 / 2 * CAR["cd"] * CAR["A"] * np.sum((u**3 + u**2 * v + u * v**2 + v**3) / 4)
    rolling = CAR["cr"] * CAR["m"] * 9.80665 * np.trapezoid(V)
    assert run.value(work) / -CAR["R"] == pytest.approx(drag + rolling, rel=1e-6)
