"""Hoist on an elastic rope: frequency, virtual work, slack rope, against ODEs of SciPy."""

import numpy as np
import pytest
from rows import assemble_rows
from scipy.integrate import solve_ivp

import lumped as lp
from lumped.components import HoistRope, Inertia, Position, Speed, Torque, translation
from lumped.errors import ParameterError, SolverError

R, EA, L_0, M, G = 0.4, 4e6, 30.0, 2000.0, 9.80665
ROPE = HoistRope(r=R, EA=EA, l_0=L_0)


def hanging(drive, rope=ROPE, start=None, keep=()):
    """A hoist: what drives the drum, the rope, a load with its weight."""
    return assemble_rows(
        *("drive drum rope.drum" if start else "drive rope.drum", "rope.load body pull"),
        drive=drive,
        rope=rope,
        body=translation.Mass(m=M),
        pull=translation.Force(f=-M * G),
        keep=["rope.T", "rope.l", "drive.flange.tau", *keep],
        **({"drum": start} if start else {}),
    )


@pytest.mark.parametrize("angle", [0.0, 40.0, -100.0])
def test_a_load_swings_with_the_frequency_of_its_length(angle):
    """``w^2 = EA / (l m)``, from a start at rest without stretch."""
    l = L_0 - R * angle  # noqa: E741
    w = np.sqrt(EA / (l * M))
    rope = ROPE.with_({"l_0": l})
    system = hanging(Speed(w=0.0), rope)
    run = lp.simulate(system, until=5.0, rtol=1e-11, start={"rope.e": 0.0, "body.v": 0.0})
    assert run["rope.T"] == pytest.approx(M * G * (1 - np.cos(w * run.t)), abs=1e-5)
    e = M * G * l / EA
    at = lp.start_point(system, start={"rope.e": e, "body.s": -e, "body.v": 0.0})
    found = lp.vibration.modes(system, at=at)
    assert max(found.hertz) == pytest.approx(w / (2 * np.pi), rel=1e-9)


@pytest.mark.parametrize("D", [0.0, 3e4])
def test_a_load_that_is_hoisted_moves_as_the_equation_of_the_shortening_rope(D):
    w = 2.0  # 0.8 m/s
    system = hanging(Speed(w=w), ROPE.with_({"D": D}))
    e_0 = M * G * L_0 / EA
    start = {"rope.e": e_0, "body.s": -e_0, "body.v": 0.7}
    run = lp.simulate(system, until=25.0, rtol=1e-12, grid=60, start=start)

    def rates(t, y):
        s, v = y
        e, length = R * w * t - s, L_0 - R * w * t
        return v, (EA * e + D * (R * w - v)) / length / M - G

    exact = solve_ivp(rates, (0, 25), (-e_0, 0.7), "DOP853", run.t, rtol=1e-13, atol=1e-13)
    e = R * w * run.t - exact.y[0]
    assert run["rope.e"] == pytest.approx(e, rel=1e-7)
    assert run["rope.l"][-1] == pytest.approx(10.0, rel=1e-12)


def test_the_torque_of_the_drum_is_the_slope_of_the_energy():
    rope = ROPE.with_({"m_l": 3.0})
    model = assemble_rows(
        "turn rope.drum",
        "rope.load hold",
        turn=Position(phi=20.0 + 0 * lp.time),
        rope=rope,
        hold=translation.Position(s=7.9 + 0 * lp.time),
    )
    point = lp.start_point(model)

    def energy(phi, s=7.9):
        l = L_0 - R * phi  # noqa: E741
        return EA * (R * phi - s) ** 2 / (2 * l) - 3.0 * G * l**2 / 2

    h = 1e-20
    slope = energy(20.0 + 1j * h).imag / h
    pull = energy(20.0, 7.9 + 1j * h).imag / h
    assert point["rope.drum.tau"] == pytest.approx(slope, rel=1e-12)
    assert point["rope.load.f"] == pytest.approx(pull, rel=1e-12)
    assert slope > R * -pull


def test_energy_is_kept_while_a_free_drum_and_the_load_swing():
    J = 50.0
    system = assemble_rows(
        *("drum rope.drum", "rope.load body pull"),
        drum=Inertia(J=J, w=0.0),
        rope=ROPE.with_({"m_l": 2.0}),
        body=translation.Mass(m=M),
        pull=translation.Force(f=-M * G),
        keep=["rope.l", "body.s"],
    )
    run = lp.simulate(system, until=1.0, rtol=1e-12, start={"rope.e": 0.1, "body.v": 0.0})
    kinetic = J * run["drum.w"] ** 2 / 2 + M * run["body.v"] ** 2 / 2
    length, e = run["rope.l"], run["rope.e"]
    stretch = np.where(e > 0, EA * e**2 / (2 * length), 0.0)
    total = kinetic + stretch + M * G * run["body.s"] - 2.0 * G * length**2 / 2
    assert np.ptp(total) < 1e-8 * np.ptp(kinetic)
    assert np.ptp(length) > 1.0


def test_a_load_thrown_up_comes_back_into_the_rope_after_its_flight():
    v_0 = 3.0
    system = hanging(Speed(w=0.0))
    run = lp.simulate(system, until=1.0, rtol=1e-11, start={"rope.e": 0.0, "body.v": v_0})
    tight = next(event.time for event in run.events if event.after == "tight")
    assert tight == pytest.approx(2 * v_0 / G, rel=1e-9)
    w = np.sqrt(EA / (L_0 * M))
    # then free vibration from the speed -v_0: T / m = g + amplitude
    t = run.t - tight
    expected = M * G * (1 - np.cos(w * t)) + M * w * v_0 * np.sin(w * t)
    after = (t > 0) & (expected > 0)
    assert run["rope.T"][after] == pytest.approx(expected[after], rel=1e-7, abs=1e-3)
    assert (run["rope.T"][run.t < tight] == 0).all()


def test_a_slack_rope_jerks_a_resting_load():
    """Without weight: tight after ``slack / (r w)``, then ``T = v sqrt(EA m / l)`` at most."""
    slack, w, long = 0.05, 2.5, 1e5
    rope = HoistRope(r=R, EA=EA * long / L_0, l_0=long)
    system = assemble_rows(
        *("turn rope.drum", "rope.load body"),
        turn=Speed(w=w),
        rope=rope,
        body=translation.Mass(m=M),
        keep=["rope.T"],
    )
    start = {"rope.e": -slack, "body.v": 0.0}
    run = lp.simulate(system, until=0.4, rtol=1e-11, grid=4000, start=start)
    tight = next(event.time for event in run.events if event.after == "tight")
    assert tight == pytest.approx(slack / (R * w), rel=1e-9)
    assert run["rope.T"].max() == pytest.approx(R * w * np.sqrt(EA * M / L_0), rel=1e-5)


class TestRefused:
    def test_a_load_that_reaches_the_drum(self):
        system = hanging(Speed(w=5.0))
        with pytest.raises(SolverError, match="free length above l_min"):
            lp.simulate(system, until=15.1, start={"rope.e": M * G * L_0 / EA, "body.v": 2.0})

    def test_a_rope_that_is_too_short_at_the_start(self):
        system = hanging(Speed(w=0.5), ROPE.with_({"l_0": 0.05}))
        with pytest.raises(SolverError, match=r"above l_min = -0\.05 m .* longer l_0"):
            lp.simulate(system, until=0.01)

    @pytest.mark.parametrize("given", [{"EA": -1.0}, {"l_0": 0.0}, {"m_l": -2.0}])
    def test_numbers_that_make_no_sense(self, given):
        (name,) = given
        with pytest.raises(ParameterError, match=f"rope.{name} = "):
            hanging(Torque(tau=0.0), ROPE.with_(given))
