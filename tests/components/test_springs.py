"""Springs with a characteristic, and contacts whose damping is not limited."""

import numpy as np
import pytest
import scipy
from rows import in_a_row

import lumped as lp
from lumped.components import Fixed, Inertia, NonlinearSpring
from lumped.errors import EquationError

SOFT, HARD, KNEE = 200.0, 1500.0, 0.01
ROWS = ((0.0, 0.0), (KNEE, SOFT * KNEE), (3 * KNEE, SOFT * KNEE + 2 * KNEE * HARD))
MIRRORED = (*((-x, -f) for x, f in reversed(ROWS)), *ROWS[1:])
MASS = 0.5


def oscillator(characteristic, v):
    return in_a_row(
        wall=Fixed(),
        spring=NonlinearSpring(characteristic=characteristic),
        body=Inertia(J=MASS, w=v, phi=0.0),
    )


def knee_and_peak(v):
    """Instants at which the knee and the peak are reached, and the peak: two harmonic arcs."""
    slow, fast = np.sqrt(SOFT / MASS), np.sqrt(HARD / MASS)
    knee = np.arcsin(KNEE * slow / v) / slow
    left = np.sqrt(v**2 - (slow * KNEE) ** 2)
    begin = SOFT * KNEE / HARD  # distance of the knee from the middle of the second arc
    rise = np.arctan2(left, fast * begin) / fast
    return knee, knee + rise, KNEE - begin + np.hypot(begin, left / fast)


@pytest.mark.parametrize("rows", [ROWS, MIRRORED], ids=["one-sided", "both"])
@pytest.mark.parametrize("way", [1, -1])
def test_a_progressive_coupling_swings_in_two_arcs(rows, way):
    v = 0.8
    knee, quarter, peak = knee_and_peak(v)
    system = lp.assemble(oscillator(rows, way * v), keep=["body.phi"])
    times = [knee, quarter, 2 * quarter, 3 * quarter, 5 * quarter]
    run = lp.simulate(system, until=6 * quarter, grid=times, rtol=1e-11, atol=1e-13)
    received = way * run["body.phi"]
    error = np.abs(received - [KNEE, peak, 0.0, -peak, peak]).max() / peak
    print(f"knee and peaks: {error:.1e}")
    assert error < 1e-6
    assert way * run["body.w"][2] == pytest.approx(-v, rel=1e-6)


def test_a_spring_by_a_cubic_has_the_period_of_the_elliptic_integral():
    a, b, amplitude = 300.0, 4e4, 0.1
    model = oscillator(lambda x: a * x + b * x**3, 0.0).with_(
        {"body": Inertia(J=MASS, w=0.0, phi=amplitude)}
    )
    stiff = (a + b * amplitude**2) / MASS
    modulus = b * amplitude**2 / (2 * (a + b * amplitude**2))
    quarter = scipy.special.ellipk(modulus) / np.sqrt(stiff)
    system = lp.assemble(model, keep=["body.phi"])
    run = lp.simulate(system, until=8 * quarter, grid=quarter * np.arange(9), rtol=1e-11)
    expected = amplitude * np.tile([1.0, 0.0, -1.0, 0.0], 3)[:9]
    assert np.abs(run["body.phi"] - expected).max() < 1e-8


@pytest.mark.parametrize("law", [MIRRORED, lambda x: 300 * x + 4e4 * x**3], ids=["rows", "cubic"])
def test_a_spring_says_what_it_stores(law):
    """The audit of a run counts it among the components whose energy is kept."""
    system = lp.assemble(oscillator(law, 0.8))
    audit = lp.simulate(system, until=0.5, rtol=1e-10, certify=True).certificate.energy
    print(audit)
    assert set(audit.components) == {"spring", "body"}
    assert audit.turnover == pytest.approx(MASS * 0.8**2 / 2, rel=1e-6)
    assert audit.error < 1e-6


@pytest.mark.parametrize(
    ("rows", "text"),
    [
        ((), "2 rows or more"),
        (((0, 0),), "2 rows or more"),
        (((0, 1.0), (1, 2)), r"\(0, 0\)"),
        (((0, 0), (0.2, 1), (0.1, 2)), "must increase, but 0.2 -> 0.1"),
        (((0, 0), (float("inf"), 1)), "finite"),
    ],
)
def test_rows_without_sense_are_refused_by_the_part_that_has_them(rows, text):
    with pytest.raises(EquationError, match=f"(?s)spring.*{text}"):
        lp.assemble(oscillator(rows, 0.0))
