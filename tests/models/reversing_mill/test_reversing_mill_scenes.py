"""The reversing mill with a gap that sticks, skids, closes and opens.

References are closed forms, modal sums, a second formulation with SciPy's DOP853 and events of its
own, and the reference files (see mill_by_hand). By hand: kgf, m and s.
"""

import numpy as np
import pytest
from checks import worst
from mill_by_hand import (
    C1,
    C2,
    CLOSED,
    J1,
    J3,
    JR,
    OPEN,
    chain,
    changes,
    course,
    data,
    relative,
    step_torques,
)
from scipy.integrate import solve_ivp

import lumped as lp
from lumped.models.reversing_mill import scenes
from lumped.models.reversing_mill.scenes import JoinedGap, StripGap
from lumped.models.reversing_mill.stand import C_SPINDLE, KGF, RATED, SHAFTS, UpperBranch

MR = RATED / KGF
SIGNALS = (*SHAFTS, "gap.w_rel", "gap.tau")


def skid_by_hand(M_s: float, M_k: float, times: np.ndarray):
    """Torques, slip and M_u at some times, and instants of changes, for motors at 1.6 and 0.4 Mr.

    Five masses; three twists and five speeds by DOP853, from one event to the next.
    """

    def torque_of_gap(y, mode):
        if mode:
            return mode * M_k
        return (C2 * y[1] - C2 * y[2]) / 2  # equal rolls at one speed

    def rates(t, y, mode):
        p, q, s, w1, w3, wv, w2, wn = y
        m1, m2 = (1.6 * MR, 0.4 * MR) if t < 0.12 else (MR, MR)
        gap = torque_of_gap(y, mode)
        return [
            *(w1 - w3, w3 - wv, w2 - wn),
            *((m1 - C1 * p) / J1, (C1 * p - C2 * q) / J3, (C2 * q - MR - gap) / JR),
            *((m2 - C2 * s) / (J1 + J3), (C2 * s - MR + gap) / JR),
        ]

    def over(t, y, mode):
        return M_s - abs(torque_of_gap(y, 0)) if mode == 0 else 1.0

    def still(t, y, mode):
        return mode * (y[5] - y[7]) if mode else 1.0

    over.terminal = still.terminal = True
    over.direction = still.direction = -1
    t, mode, found, instants = 0.0, 0, [], []
    y = np.array([MR / C1, MR / C2, MR / C2, 0, 0, 0, 0, 0])
    while t < times[-1]:
        end = 0.12 if t < 0.12 else times[-1]
        run = solve_ivp(
            rates,
            (t, end),
            y,
            "DOP853",
            dense_output=True,
            events=(over, still),
            args=(mode,),
            rtol=1e-12,
            atol=1e-13,
        )
        inside = times[(times >= t) & ((times < run.t[-1]) | (run.t[-1] == times[-1]))]
        values = run.sol(inside) if len(inside) else np.zeros((8, 0))
        gap = [torque_of_gap(v, mode) for v in values.T]
        torques = (C1 * values[0], C2 * values[1], C2 * values[2])
        found += zip(*torques, values[5] - values[7], gap, strict=True)
        t, y = run.t[-1], run.y[:, -1]
        if run.status == 1:
            needed = torque_of_gap(y, 0)
            if mode:
                y[5] = y[7] = (y[5] + y[7]) / 2
                mode = 0 if abs(needed) <= M_s else int(np.sign(needed))
            else:
                mode = int(np.sign(needed))
                y += 1e-12 * np.array(rates(t, y, mode))  # off zero slip
            instants.append((t, {0: "stuck", 1: "forward", -1: "backward"}[mode]))
    return np.array(found), instants


class TestSkidding:
    def test_instants_and_modes_are_those_of_the_reference(self):
        run = scenes.skidding(rtol=1e-10)
        table = data("skid_events")
        received = changes(run)
        expected = table[:, 0]
        assert [mode for _, mode in received] == ["forward", "stuck", "forward", "stuck"]
        error = np.abs([t for t, _ in received] - expected).max()
        assert error < 1e-8
        assert np.abs(expected - [0.031472, 0.205081, 0.212507, 0.231298]).max() < 5.1e-7

    def test_signals_and_their_peaks_are_those_of_the_reference(self):
        table = data("skid")
        run = scenes.skidding(grid=table[:, 0], rtol=1e-10)
        received, expected = run.table(SIGNALS), table[:, 2:]
        error = np.abs(received - expected).max(axis=0) / np.abs(expected).max(axis=0)
        assert error.max() < 1e-6
        assert relative(received.max(axis=0), expected.max(axis=0)) < 1e-6
        assert (run["gap.position"] == table[:, 1]).all()

    def test_after_the_fourth_change_it_sticks_for_ever(self):
        run = scenes.skidding(until=10.0, grid=20_000, rtol=1e-8)
        last = changes(run)[3][0]
        # energies of the modes of four masses after it bound the equalizing torque for ever
        k = np.flatnonzero(run.t == last)[-1]
        bodies = ("upper.motor", "upper.gearbox", "upper.rolls", "lower.motor")
        root_J, root_C, (U, _, V) = chain(*CLOSED)
        speeds = U.T @ (root_J * [run[f"{body}.w"][k] for body in bodies])
        torques = V @ ([run[name][k] / KGF - MR for name in SHAFTS] / root_C)
        largest = np.hypot(speeds, torques) @ np.abs((V * root_C) @ [0, 0.5, -0.5]) * KGF
        assert len(changes(run)) == 4
        assert largest < scenes.STATIC
        received = np.abs(run["gap.tau"][k:]).max()
        assert 0.99 * largest < received < largest * (1 + 1e-6)

    @pytest.mark.parametrize(
        ("M_s", "M_k"), [(0.40, 0.30), (0.40, 0.40), (0.30, 0.30), (0.20, 0.05), (0.5, 0.0)]
    )
    def test_any_limits_give_the_course_of_a_second_formulation(self, M_s, M_k):
        times = np.linspace(0, 0.4, 401)
        limits = {"M_s": M_s * RATED, "M_k": M_k * RATED}
        run = scenes.skidding(parameters=limits, grid=times, rtol=1e-10)
        expected, instants = skid_by_hand(M_s * MR, M_k * MR, times)
        received = changes(run)
        assert [mode for _, mode in received] == [mode for _, mode in instants]
        assert np.abs(np.subtract([t for t, _ in received], [t for t, _ in instants])).max() < 1e-8
        expected[:, [0, 1, 2, 4]] *= KGF
        error = np.abs(run.table(SIGNALS) - expected).max(axis=0) / np.abs(expected).max(axis=0)
        assert error[:4].max() < 1e-6

    def test_a_gap_that_holds_anything_makes_four_masses(self):
        times = np.linspace(0, 0.4, 401)
        limits = {"M_s": 1e6 * RATED, "M_k": 1e6 * RATED}
        run = scenes.skidding(parameters=limits, grid=times, rtol=1e-10)
        expected = RATED + KGF * pulse(CLOSED, [0.6 * MR, 0, 0, -0.6 * MR], times)
        assert changes(run) == []
        assert np.abs(run.table(SHAFTS) - expected).max() < 1e-7 * RATED

    def test_a_gap_that_holds_nothing_makes_two_free_branches(self):
        times = np.linspace(0, 0.4, 401)
        run = scenes.skidding(parameters={"M_s": 0.0, "M_k": 0.0}, grid=times, rtol=1e-10)
        expected = RATED + KGF * pulse(OPEN, [0.6 * MR, 0, 0, -0.6 * MR, 0], times)
        assert np.abs(run.table(SHAFTS) - expected).max() < 1e-7 * RATED
        assert (run["gap.tau"] == 0).all()

    @pytest.mark.parametrize("M_s", [0.0, 1e-6 * RATED, 0.4 * RATED])
    def test_equal_branches_exchange_no_torque(self, M_s):
        step = lp.ops.where(lp.time < 0.12, 1.6 * RATED, RATED)
        stand = StripGap(lower=UpperBranch(), M_s=M_s, M_k=M_s, enters=0.01).with_(
            {"upper.drive.tau": step, "lower.drive.tau": step}
        )
        run = lp.simulate(lp.assemble(stand), until=0.4)
        assert np.abs(run["gap.tau"]).max() < 1e-10 * RATED
        assert np.abs(run["gap.w_rel"]).max() < 1e-12 * np.abs(run["upper.rolls.w"]).max()


def pulse(hand, torques, times: np.ndarray) -> np.ndarray:
    """Torques of the shafts by modal sums if the outer torques act for 0.12 s."""
    after = np.maximum(times - 0.12, 0)
    return step_torques(*hand, torques, times) - step_torques(*hand, torques, after)


class TestStripBreak:
    """The strip breaks at 20 ms of steady rolling."""

    @pytest.mark.parametrize(("share", "columns"), [(0.0, slice(1, 5)), (0.1, slice(5, 9))])
    def test_signals_are_those_of_the_reference(self, share, columns):
        table = data("break")
        run = scenes.strip_break(share, grid=0.02 + table[:, 0], rtol=1e-10)
        received, expected = run.table(SIGNALS[:4]), table[:, columns]
        error = np.abs(received - expected).max(axis=0) / np.abs(expected).max(axis=0)
        assert error.max() < 1e-6
        assert relative(received[:, :3].min(axis=0), expected[:, :3].min(axis=0)) < 1e-6
        assert relative(received[:, :3].max(axis=0), expected[:, :3].max(axis=0)) < 1e-6
        assert [mode for _, mode in changes(run)] == ["free"]

    @pytest.mark.parametrize("share", [0.0, 0.1])
    def test_steady_rolling_goes_on_until_the_strip_breaks(self, share):
        run = scenes.strip_break(share, until=0.0199)
        upper, lower = (1 + share) * RATED, (1 - share) * RATED
        expected = np.array([upper, upper, lower, 0.0, share * RATED])
        assert np.abs(run.table(SIGNALS) - expected).max() < 1e-8 * RATED

    def test_torques_swing_about_small_means_to_full_reversal(self):
        until = 2.02
        run = scenes.strip_break(until=until, grid=np.linspace(0.02, until, 40_001))
        expected = 1 + step_torques(*OPEN, [0, 0, MR, 0, MR], run.t - 0.02) / MR
        received = run.table(SHAFTS) / RATED
        assert np.abs(received - expected).max() < 1e-4
        assert np.abs(received.min(axis=0) - [-0.513, -0.941, -0.943]).max() < 1.1e-3
        assert abs(received[:, 0].max() - 1.454) < 1.1e-3

    def test_both_branches_accelerate_alike(self):
        run = scenes.strip_break(grid=[0.02, 0.22], rtol=1e-10)
        bodies = {
            "upper": {"motor": J1, "gearbox": J3, "rolls": JR},
            "lower": {"motor": J1, "gearbox": J3, "rolls": JR},
        }
        for side, inertias in bodies.items():
            momentum = sum(J * run[f"{side}.{part}.w"] for part, J in inertias.items())
            acceleration = np.diff(momentum)[0] / 0.2 / (J1 + J3 + JR)
            assert relative(acceleration, MR / (J1 + J3 + JR)) < 1e-8
            assert abs(acceleration - 64.95) < 5.1e-3


class TestPlay:
    """The strip breaks, and spindles with play change their flanks."""

    @pytest.mark.parametrize("play", [0.002, 0.02, 0.05])
    def test_back_flanks_are_hit_as_hard_as_energy_tells(self, play):
        grid = np.linspace(0.02, 0.06, 40_001)
        run = scenes.strip_break(play=play, until=0.06, grid=grid, rtol=1e-10)
        # The twist x of the two masses moves in the potential of the flanks and of the constant
        # torque F: it starts at rest at b / 2 + M / C and stops at -b / 2 - y.
        force = RATED * JR / (JR + J1 + J3)
        level = RATED**2 / (2 * C_SPINDLE) - force * (play + RATED / C_SPINDLE)
        hit = np.sqrt(force**2 + 2 * C_SPINDLE * level) - force
        assert relative(run["lower.spindle.tau"].min(), -hit) < 1e-7
        assert hit < RATED * (1 - 2 * JR / (JR + J1 + J3))  # without play

    def test_a_spindle_in_its_play_carries_nothing(self):
        play = 0.02
        run = scenes.strip_break(play=play, until=0.3, grid=3000, rtol=1e-9)
        for name in ("upper.spindle", "lower.spindle"):
            inside = np.abs(run[f"{name}.phi_rel"]) < play / 2 * (1 - 1e-9)
            assert (run[f"{name}.tau"][inside] == 0).all()
            assert 0.1 < inside.mean() < 0.9
            beyond = np.abs(run[f"{name}.phi_rel"]) - play / 2
            expected = C_SPINDLE * np.maximum(beyond, 0)
            assert np.abs(np.abs(run[f"{name}.tau"]) - expected).max() < 1e-9 * RATED

    def test_a_vanishing_play_changes_nothing(self):
        grid = np.linspace(0, 0.1, 201)
        received, expected = (
            scenes.strip_break(play=play, until=0.1, grid=grid, rtol=1e-10).table(SHAFTS)
            for play in (1e-8, 0.0)
        )
        assert np.abs(received - expected).max() < 1e-5 * RATED


class TestEntryAtUnequalSpeeds:
    """Strip enters at 20 ms between rolls of different speed."""

    @pytest.mark.parametrize("heavier", [1.0, 3.0])
    def test_momentum_is_kept_and_the_rest_of_the_energy_lost(self, heavier):
        lead, J_v, J_n = 2.0, heavier * JR * KGF, JR * KGF
        run = scenes.entry_at_speed(JoinedGap().with_({"upper.rolls.J": J_v}), lead)
        (hit,) = (event for event in run.events if event.loss)
        assert (hit.time, hit.component, hit.after) == (0.02, "gap", "stuck")
        assert relative(hit.loss, J_v * J_n / (J_v + J_n) * lead**2 / 2) < 1e-12
        w_v, w_n = (run[f"{side}.rolls.w"][run.t == 0.02] for side in ("upper", "lower"))
        assert relative(w_v[[0, -1]], [lead, J_v / (J_v + J_n) * lead]) < 1e-12
        assert abs(w_n[0]) < 1e-12
        assert relative(w_n[-1], w_v[-1]) < 1e-12

    def test_torques_are_those_of_four_masses_with_these_speeds(self):
        lead, times = 2.0, np.linspace(0, 0.18, 181)
        run = scenes.entry_at_speed(JoinedGap(), lead, grid=0.02 + times, rtol=1e-10)
        received = run.table(SHAFTS) / KGF
        expected = course(*CLOSED, [MR, 0, -2 * MR, MR], [lead, lead, lead / 2, 0], times)
        assert worst(received, expected) < 1e-8

    def test_friction_without_bound_joins_them_at_once(self):
        times = 0.02 + np.linspace(0, 0.18, 181)
        joined = scenes.entry_at_speed(JoinedGap(), 2.0, grid=times, rtol=1e-10).table(SHAFTS)
        errors = []
        for M in (10 * RATED, 100 * RATED, 1000 * RATED):
            stand = StripGap(M_s=M, M_k=M)
            run = scenes.entry_at_speed(stand, 2.0, grid=times, rtol=1e-10)
            errors.append(np.abs(run.table(SHAFTS) - joined).max())
        assert relative(np.divide(errors[:-1], errors[1:]), 10.0) < 0.05
        assert errors[-1] < 1e-4 * np.abs(joined).max()
