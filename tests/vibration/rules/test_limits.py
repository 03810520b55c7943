from dataclasses import replace

import numpy as np
import pytest
from rows import assemble_row
from torsional_cases import RPM, blades, columns, marine, rows

import lumped as lp
from lumped.components import Fixed, Inertia, Spring, Torque
from lumped.errors import LumpedError, OptionError
from lumped.vibration import BarredRange, Limit, MarineShaft


def test_marine_limits_are_those_of_the_table():
    for row in rows("07_iacs_m68", "limits.csv"):
        share = float(row["lambda"])
        shaft = MarineShaft(
            d=float(row["d_mm"]) / 1e3,
            tensile=1e6 * float(row["sigma_B_MPa"]),
            rated=10.0,
            form_factor=float(row["c_K"]),
        )
        pairs = [(shaft.continuous(10.0 * share) / 1e6, row["tau_C_MPa"])]
        pairs += [(shaft.size_factor, row["c_D"])]
        if row["tau_T_MPa_lambda_up_to_0.8"]:
            pairs += [(shaft.transient(10.0 * share) / 1e6, row["tau_T_MPa_lambda_up_to_0.8"])]
        for found, wanted in pairs:
            assert found == pytest.approx(float(wanted), rel=1e-9)


def test_barred_ranges_are_those_of_the_table():
    for row in rows("07_iacs_m68", "barred_range.csv"):
        shaft = MarineShaft(d=0.3, tensile=5e8, rated=float(row["rated_rpm"]) * RPM)
        found = shaft.barred(float(row["critical_rpm"]) * RPM)
        assert found.begin / RPM == pytest.approx(float(row["barred_from_rpm"]), rel=1e-9)
        assert found.end / RPM == pytest.approx(float(row["barred_to_rpm"]), rel=1e-9)


def turbine(rpm):
    return lp.vibration.order_response(
        marine(damped=True),
        speeds=rpm * RPM,
        of=["shaft.tau"],
        excitations={"blades.tau": {5: blades}},
        damping_ratio=0.00398,
    )


def test_a_verdict_tells_utilisation_place_and_barred_range():
    table = columns("01_marine_steam_turbine", "response.csv")
    response = turbine(table["n_rpm"])
    torque = table["propeller_shaft_Nm"]
    found = lp.vibration.verdict(
        response,
        [
            Limit("shaft.tau", "200 kN.m", name="coupling", measure="sum", source="maker"),
            Limit("shaft.tau", ((0.0, 1e6), (20.0, 2e6)), name="shaft"),
        ],
    )
    coupling, shaft = found.results
    assert coupling.utilisation == pytest.approx(torque.max() / 200e3, rel=1e-7)
    assert coupling.utilisation > torque.max() / 200e3
    assert abs(coupling.speed / RPM - table["n_rpm"][torque.argmax()]) < 0.2
    assert shaft.utilisation == pytest.approx(
        (torque / (1e6 + 1e6 * table["n_rpm"] * RPM / 20)).max(), rel=1e-4
    )
    assert (coupling.passed, shaft.passed, found.passed) == (False, True, False)
    above = table["n_rpm"][torque > 200e3]
    (barred,) = found.barred
    assert above[0] - 0.2 < barred.begin / RPM <= above[0]
    assert above[-1] <= barred.end / RPM < above[-1] + 0.2
    assert "FAILED: 1 of 2 limits kept" in repr(found)
    assert "maker" in repr(found)


def test_barred_ranges_that_meet_are_joined():
    response = turbine(np.linspace(20.0, 60.0, 81))
    limits = [Limit("shaft.tau", value, name=f"{value:g}") for value in (1.5e5, 2e5)]
    found = lp.vibration.verdict(response, limits)
    widest = max(found.results, key=lambda r: r.beyond[0].end - r.beyond[0].begin)
    assert [(r.begin, r.end) for r in found.barred] == [
        (widest.beyond[0].begin, widest.beyond[0].end)
    ]


def test_separation_is_the_distance_from_the_speeds_of_operation():
    modes = lp.modes(marine(damped=False))
    critical = lp.vibration.critical_speeds(modes, orders=[5])
    first = float(modes.hertz[0]) * 2 * np.pi / 5
    found = lp.vibration.separation(critical[:1], between=(1.2 * first, 2 * first), margin=0.1)
    (result,) = found.results
    assert result.value == pytest.approx(0.2 / 1.2)
    assert found.passed
    near = lp.vibration.separation(critical[:1], between=(1.05 * first, 2 * first), margin=0.1)
    assert near.barred == (BarredRange(first / 1.1, first / 0.9),)
    inside = lp.vibration.separation(critical[:1], between=(0.9 * first, 2 * first))
    assert not inside.passed
    assert inside.results[0].utilisation == np.inf


def test_a_diagram_must_reach_as_far_as_the_operation_and_its_margin():
    diagram = lp.campbell(marine(damped=False), speeds=[1.0, 60.0], orders=[5])
    for between in ((55.0, 58.0), (1.05, 2.0)):
        with pytest.raises(OptionError, match="reaches from 1 to 60 rad/s"):
            lp.vibration.separation(diagram, between=between, margin=0.1)
        with pytest.raises(OptionError, match="reaches from 1 to 60 rad/s"):
            lp.vibration.separation(diagram.critical[1:], between=between, margin=0.1)
    assert lp.vibration.separation(diagram, between=(40.0, 44.0), margin=0.1).passed
    low = lp.campbell(diagram.system, speeds=[1.0, 2.0], orders=[1])
    found = lp.vibration.separation(low, between=(1.2, 1.5), margin=0.1)
    assert found.passed
    assert found.notes == (
        f"no critical speed lies from {30 / np.pi:.6g} to {60 / np.pi:.6g} 1/min",
    )


@pytest.mark.parametrize("grid", [3, 40, None])
def test_a_run_is_judged_between_its_output_times(grid):
    """``tau = 20 sin(38.7 t)`` on a fixed spring: its greatest is 20, its mean square 200."""
    torque = Torque(tau=20 * lp.ops.sin(38.7 * lp.time))
    drive = assemble_row(torque=torque, spring=Spring(c=1e3), ground=Fixed())
    run = lp.simulate(drive, until=20 * np.pi / 38.7, grid=grid)
    found = lp.vibration.verdict(run, [Limit("spring.tau", 19.999)])
    assert found.results[0].value == pytest.approx(20.0, rel=1e-6)
    assert not found.passed


def test_a_run_is_judged_by_conditions_of_functionals():
    """``w = 2 t``, so its mean square over 3 s is ``4 * 3**2 / 3``."""
    run = lp.simulate(assemble_row(motor=Torque(tau=4.0), body=Inertia(J=2.0)), until=3.0)
    w, fun = "body.w", lp.functionals
    conditions = [fun.rms(w) <= 4.0, fun.final(w) >= "60 rpm", fun.lowest(w) <= -1.0]
    found = {(r.quantity, r.measure): r for r in lp.vibration.verdict(run, conditions).results}
    assert found["rms(body.w)", "at most"].utilisation == pytest.approx(np.sqrt(12) / 4, rel=1e-7)
    assert found["final(body.w)", "at least"].utilisation == pytest.approx(2 * np.pi / 6, rel=1e-7)
    assert not found["lowest(body.w)", "at most"].passed
    with pytest.raises(LumpedError, match="is no functional of a run"):
        lp.vibration.verdict(run, [fun.frequency(0) <= 3.0])
    with pytest.raises(LumpedError, match="limit of a run"):
        lp.vibration.verdict(turbine(np.array([20.0])), [fun.rms("shaft.tau") <= 3.0])


@pytest.mark.parametrize(
    ("limit", "match"),
    [
        (Limit("shaft.tau", "200 MPa"), "MPa"),
        (Limit("shaft.tau", "much"), "much"),
        (Limit("shaft.tau", -1.0), "positive"),
        (Limit("shaft.tau", ((50.0, 1.0), (60.0, 1.0))), "nothing is given"),
        (Limit("shaft.tau", ((5.0, 1.0), (4.0, 1.0))), "increase"),
        (Limit("shaft.taw", 1.0), "shaft.tau"),
        (Limit("shaft.tau", 1.0, speeds=(500.0, 600.0)), "no speed was computed"),
    ],
)
def test_slips_in_limits_are_named(limit, match):
    response = turbine(np.array([20.0, 30.0]))
    with pytest.raises(LumpedError, match=match):
        lp.vibration.verdict(response, [limit])


def test_values_in_other_units_are_noticed():
    with pytest.raises(OptionError, match=r"d = 340 m must lie"):
        MarineShaft(d=340.0, tensile=6e8, rated=10.0)
    with pytest.raises(OptionError, match=r"tensile = 600 Pa"):
        MarineShaft(d=0.34, tensile=600.0, rated=10.0)
    with pytest.raises(OptionError, match=r"1\.05"):
        MarineShaft(d=0.34, tensile=6e8, rated=10.0).continuous([11.0])


def test_a_rule_bars_more_than_where_its_limit_is_exceeded():
    shaft = MarineShaft(d=0.3, tensile=5e8, rated=80.0 * RPM)
    response = turbine(columns("01_marine_steam_turbine", "response.csv")["n_rpm"])
    continuous, passing = shaft.limits("shaft.tau")
    permitted = 0.99 * lp.vibration.verdict(response, [Limit("shaft.tau", 1e9)]).results[0].value
    found = lp.vibration.verdict(
        response, [replace(each, permitted=permitted) for each in (continuous, passing)]
    )
    speed = found.results[0].speed
    (barred,) = found.barred
    share = speed / shaft.rated
    assert barred.begin == pytest.approx(16 * speed / (18 - share))
    assert barred.end == pytest.approx((18 - share) * speed / 16)
    assert found.notes[-1].endswith("too much even to pass quickly, so barring does not help")
