"""Numbers by hand from the Rules for Steel Ships of the Korean Register, 2025, Pt 5 Ch 4."""

import numpy as np
import pytest
from rows import assemble_row

import lumped as lp
from lumped.components import Inertia, Shaft, Solid, Torque
from lumped.errors import OptionError
from lumped.vibration import EngineShaft, MarineShaft

RATED = 75.0


@pytest.mark.parametrize(
    ("kind", "firing", "share", "continuous", "passing"),
    [
        ("main engine", "four strokes", 0.0, 45.0, 90.0),
        ("main engine", "four strokes", 0.5, 39.0, 78.0),
        ("main engine", "others", 0.5, 37.75, 75.5),
        ("main engine", "four strokes", 0.8, 29.64, 59.28),
        ("main engine", "four strokes", 1.0, 21.0, None),
        ("main engine", "others", 1.0, 16.0, None),
        ("main engine", "four strokes", 1.09, 21.0 + 237 * 0.29 * 0.3, None),
        ("main engine", "others", 1.09, 16.0 + 237 * 0.29 * 0.3, None),
        ("generating set", "four strokes", 0.9, 21.0, 90.0),
        ("generating set", "others", 0.9, 16.0, 90.0),
        ("generator", "four strokes", 0.9, 31.0, 118.0),
        ("generator", "others", 1.1, 31.0, None),
    ],
)
def test_permitted_stresses_are_those_of_the_rule(kind, firing, share, continuous, passing):
    shaft = EngineShaft(RATED, kind, firing)
    assert shaft.continuous(share * RATED) == pytest.approx(1e6 * continuous, rel=1e-12)
    if passing is None:
        with pytest.raises(OptionError, match=r"holds from 0 to 0\.[89]"):
            shaft.transient(share * RATED)
    else:
        assert shaft.transient(share * RATED) == pytest.approx(1e6 * passing, rel=1e-12)


def test_better_material_permits_more():
    """``1 + 2/3 (660/440 - 1) = 4/3`` of 39 MPa, and ``450/225 = 2`` times 78 MPa."""
    shaft = EngineShaft(RATED, tensile=660e6, yield_stress=450e6)
    assert shaft.continuous(0.5 * RATED) == pytest.approx(52e6, rel=1e-12)
    assert shaft.transient(0.5 * RATED) == pytest.approx(156e6, rel=1e-12)
    weak = EngineShaft(RATED, tensile=400e6, yield_stress=200e6)
    assert weak.continuous(0.5 * RATED) == pytest.approx(39e6, rel=1e-12)
    assert weak.transient(0.5 * RATED) == pytest.approx(78e6, rel=1e-12)


def test_the_barred_range_is_that_of_propulsion_shafts():
    """Critical at half of the rated speed: ``16/17.5`` to ``17.5/16`` of it."""
    found = EngineShaft(RATED).barred(0.5 * RATED)
    assert found.begin == pytest.approx(0.5 * RATED * 16 / 17.5, rel=1e-12)
    assert found.end == pytest.approx(0.5 * RATED * 17.5 / 16, rel=1e-12)
    assert found == MarineShaft(d=0.3, tensile=6e8, rated=RATED).barred(0.5 * RATED)


def test_a_verdict_judges_the_stress_of_a_generating_set():
    """``tau = T J_2 / (J_1 + J_2) / (1 - (2 n / w_0)^2)``, below resonance largest at 110 %."""
    j_1, j_2, d, torque = 20.0, 60.0, 0.12, 600.0
    shaft = Shaft(sections=[Solid(d=d, L=1.0)], rho=1e-3)
    ends = {"engine": Torque(tau=0.0), "crank": Inertia(J=j_1)}
    drive = assemble_row(**ends, shaft=shaft, machine=Inertia(J=j_2))
    w_0 = 2 * np.pi * float(lp.modes(drive).hertz[0])
    assert 0.2 * w_0 < 2 * 1.1 * RATED < 0.8 * w_0
    response = lp.vibration.order_response(
        drive,
        speeds=np.linspace(0.5, 1.1, 25) * RATED,
        of=["shaft.sections[0].stress"],
        shaft="crank.phi",
        excitations={"engine.tau": {2: torque}},
    )

    def stress(n):
        share = j_2 / (j_1 + j_2) / (1 - (2 * n / w_0) ** 2)
        return torque * share * 16 / (np.pi * d**3)

    found = lp.vibration.verdict(
        response, EngineShaft(RATED, "generating set").limits("shaft.sections[0].stress")
    )
    rows = {row.name: row for row in found.results}
    running, passing = rows["continuous operation"], rows["transient passage"]
    assert running.value == pytest.approx(stress(1.1 * RATED), rel=1e-7)
    assert running.utilisation == pytest.approx(stress(1.1 * RATED) / 21e6, rel=1e-7)
    assert passing.utilisation == pytest.approx(stress(0.9 * RATED) / 90e6, rel=1e-7)
    assert "tau_1 read in KR Rules for Steel Ships 2025, 5-4-203" in repr(found)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"rated": 0.0}, r"rated = 0 rad/s must lie"),
        ({"tensile": 440.0}, r"tensile = 440 Pa must lie"),
        ({"tensile": 900e6}, r"tensile = 9e\+08 Pa must lie between 5e\+07 and 8.35e\+08 Pa"),
        ({"yield_stress": 500e6}, r"yield_stress = 5e\+08 Pa must lie"),
        ({"kind": "turbine"}, "one of main engine, generating set, generator is needed"),
        ({"firing": "two"}, "one of four strokes, others is needed"),
    ],
)
def test_slips_are_named(options, match):
    with pytest.raises(OptionError, match=match):
        EngineShaft(**{"rated": RATED, **options})
    with pytest.raises(
        OptionError, match=r"1\.2 of the rated speed; the rule holds from 0 to 1\.15"
    ):
        EngineShaft(RATED).continuous(1.2 * RATED)
