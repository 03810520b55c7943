"""The marine turbine against the published example, matrices by hand and a run in time."""

import numpy as np
import pytest
from mill_by_hand import hertz
from torsional_cases import columns

import lumped as lp
from lumped.models import machine
from lumped.models.marine_turbine.drive import BLADES, LBF_IN, RPM, ZETA, MarineTurbine
from lumped.models.marine_turbine.figures import FIGURE
from lumped.models.marine_turbine.scenes import SHAFTS, response, run_up

CASE = "01_marine_steam_turbine"


def by_hand():
    """Natural frequencies, 1/min, from matrices at the propeller: propeller, bull, LP, HP."""
    J = [2.454e6, 0.826e6, 1.283e4 * 9.4094**2, 1.509e4 * 40.0424**2]
    J += [2.723e4 * 9.4094**2, 2.612e2 * 78.2365**2]
    shafts = [(0, 1, 826e6), (1, 2, 203.94e6 * 9.4094**2), (2, 3, 30.51e6 * 40.0424**2)]
    shafts += [(1, 4, 24.17e6 * 9.4094**2), (4, 5, 14.26e6 * 78.2365**2)]
    return 60 * hertz(J, shafts)


def test_natural_frequencies_are_the_published_ones_and_those_of_the_matrices():
    rows = machine("marine_turbine").rows()[:5]
    received = [row.computed for row in rows]
    assert received == pytest.approx(by_hand(), rel=1e-9)
    printed = [row.published for row in rows[:3]]
    assert [round(value, 1) for value in received[:3]] == printed
    remarks = [float(row.remark.split()[0]) for row in rows[3:]]
    assert remarks == pytest.approx(by_hand()[3:], abs=1e-3)


def test_the_vibration_over_the_speed_is_that_of_the_reference_and_of_the_figure():
    table = columns(CASE, "response.csv")
    steady = response(table["n_rpm"])
    pairs = (
        (steady.magnitude("shaft.tau", BLADES), table["propeller_shaft_Nm"]),
        (steady.magnitude("low.intermediate.tau", BLADES), table["lp_intermediate_shaft_Nm"]),
    )
    worst = max(np.abs(found / wanted - 1).max() for found, wanted in pairs)
    print(f"{worst:.1e}")
    assert worst < 1e-8
    rpm, torque = np.array(FIGURE).T
    published = columns(CASE, "digitised_published_curve.csv")
    assert torque * LBF_IN == pytest.approx(published["propeller_shaft_Nm"], rel=1e-4)
    off = np.abs(response(rpm).magnitude("shaft.tau", BLADES) / (torque * LBF_IN) - 1)
    assert np.median(off) < 0.03
    assert off.max() < 0.09


def test_the_run_up_has_the_steady_amplitudes_of_the_speed_shortly_before():
    """Without the damping ratio of the modes, which a run does not have."""
    run = run_up(grid=60_000, rtol=1e-8)
    rise = np.polyfit(run.t[30_000:], run["propeller.w"][30_000:], 1)
    assert rise[0] == pytest.approx(25 * RPM / 240, rel=1e-2)
    found = lp.vibration.order_tracks(run, "shaft.tau", shaft="propeller.phi", turns=3)
    received = np.abs(found.track(BLADES))
    later = found.rpm > 27.0
    # the vibration answers late by the time in which it fades: it is that of a lower speed
    late = -1 / lp.modes(lp.assemble(MarineTurbine())).eigenvalues[0].real
    before = found.rpm[later] - 25 / 240 * late
    steady = response(before, damping_ratio=0.0)
    expected = steady.magnitude("shaft.tau", BLADES)
    off = np.abs(received[later] - expected).max() / expected.max()
    print(f"{off:.1e}")
    assert off < 0.03
    assert received.max() == pytest.approx(expected.max(), rel=0.01)
    assert found.largest(1) == (BLADES,)


def test_mass_elastic_data_are_those_of_the_source():
    modes = lp.modes(lp.assemble(MarineTurbine()))
    found = lp.vibration.mass_elastic(modes, shaft="propeller.phi")
    assert found.left_out == ()
    sizes = {part.name: part.J / LBF_IN for part in found.inertias}
    expected = {"propeller": 2.454e6, "bull": 0.826e6, "low.wheel": 1.283e4, "low.rotor": 1.509e4}
    assert sizes == pytest.approx(expected | {"high.wheel": 2.723e4, "high.rotor": 2.612e2})
    ratios = {part.name: part.ratio for part in found.shafts}
    assert ratios["high.shaft"] == pytest.approx(78.2365)
    assert {f"{name}.tau" for name in ratios} == set(SHAFTS)


def test_what_is_changed_changes():
    heavy = response([50.0], parameters={"propeller.J": 1e6}).magnitude("shaft.tau", BLADES)
    assert heavy != pytest.approx(response([50.0]).magnitude("shaft.tau", BLADES), rel=0.1)
    assert response([35.6], damping_ratio=0.0).magnitude("shaft.tau", 5) > response(
        [35.6], damping_ratio=ZETA
    ).magnitude("shaft.tau", 5)
