"""Linkages with a spring between two bars, whose twist is a state of a small nominal size."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Bar, SpringDamper
from lumped.components import translation as tr

LENGTHS = {"crank": 2.1, "coupler": 2.4, "rocker": 1.6}
FRAME, STIFFNESS, TWIST = 1.0, 2.7, 0.2


def four_bar(**given):
    bars = {
        name: Bar(length=length, m=2.0, J=0.5, g=9.81, **given[name])
        for name, length in LENGTHS.items()
    }
    parts = {"spring": SpringDamper(c=STIFFNESS, phi_rel0=TWIST), "low": tr.Fixed()}
    parts |= {"left": tr.Fixed(), "right": tr.Fixed(s0=FRAME)}

    def connections(m):
        yield lp.connect(m.crank.flange, m.spring.flange_a)
        yield lp.connect(m.coupler.flange, m.spring.flange_b)
        yield lp.connect(m.left.flange, m.crank.a_x)
        yield lp.connect(m.right.flange, m.rocker.a_x)
        yield lp.connect(m.low.flange, m.crank.a_y, m.rocker.a_y)
        for way in "xy":
            crank, coupler, rocker = (
                getattr(bar, f"b_{way}") for bar in (m.crank, m.coupler, m.rocker)
            )
            yield lp.connect(crank, getattr(m.coupler, f"a_{way}"))
            yield lp.connect(coupler, rocker)

    return lp.compose(connections=lambda m: list(connections(m)), **bars, **parts)


@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
def test_energy_stays_where_a_rocker_passes_the_line_of_its_pivots(rtol):
    """There the angles of crank and rocker alone could not meet the constraints."""
    system = lp.assemble(
        four_bar(crank={"phi": -1.566, "w": 2.7}, coupler={"phi": 0.4}, rocker={"phi": -0.7})
    )
    run = lp.simulate(system, until=3.0, rtol=rtol, grid=300)
    assert any(event.after == "redundant coordinates" for event in run.events)
    angle = run["rocker.phi"]
    assert angle.min() < -0.1 < 0.1 < angle.max()
    energy = STIFFNESS * (run["coupler.phi"] - run["crank.phi"] - TWIST) ** 2 / 2
    for name in LENGTHS:
        at = {key: run[f"{name}.{key}"] for key in ("v_x", "v_y", "w", "y")}
        energy += at["v_x"] ** 2 + at["v_y"] ** 2 + 0.25 * at["w"] ** 2 + 2.0 * 9.81 * at["y"]
    assert np.abs(energy - energy[0]).max() < 100 * rtol * np.ptp(9.81 * 2.0 * run["coupler.y"])


def test_guesses_of_all_angles_choose_the_assembly_where_a_twist_leads():
    rough = {"crank": -1.566, "coupler": 0.4, "rocker": -0.7}
    system = lp.assemble(four_bar(**{name: {"phi": phi} for name, phi in rough.items()}))
    point = lp.start_point(system, start={"crank.w": 2.7})
    found = {name: point[f"{name}.phi"] for name in rough}
    arms = {name: LENGTHS[name] * np.exp(1j * phi) for name, phi in found.items()}
    assert arms["crank"] + arms["coupler"] - arms["rocker"] == pytest.approx(FRAME, abs=1e-12)
    assert found == pytest.approx(rough, abs=0.1)
    assert point["crank.w"] == pytest.approx(2.7, rel=1e-12)
    named = {text.split()[0] for text in point.lost}
    assert named <= {f"{name}.phi" for name in rough}
    assert named
