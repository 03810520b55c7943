import numpy as np
import pytest

import lumped as lp
from lumped.components import CrankSlider, Cylinder, Engine, Inertia, SpringDamper
from lumped.errors import OptionError, UnknownNameError
from lumped.models.diesel_genset import scenes
from tests.vibration.torsional_cases import FIRST, INERTIAS, SERIES, STIFFNESSES

TABLE = ((0.0, 0.0), (3.0, 1e5), (5.5, 1e6), (6.4, 8e6), (7.5, 2e6), (9.5, 1e5))
SIZE = {"bore": 0.1, "r": 0.05, "L": 0.18, "m": 4.0}


def chain(part, J=0.3):
    return lp.assemble(
        lp.compose(
            part=part,
            crank=Inertia(J=0.05),
            shaft=SpringDamper(c=2e5, d=10.0),
            wheel=Inertia(J=J),
            connections=lambda m: [
                lp.connect(m.part.flange, m.crank.flange_a),
                *lp.chain(m.crank, m.shaft, m.wheel),
            ],
        )
    )


def lever(a):
    tilt = np.arcsin(0.05 / 0.18 * np.sin(a))
    return 0.05 * np.sin(a + tilt) / np.cos(tilt)


def two_masses(J, J_2=0.3):
    """Frequency, rad/s, and damping ratio of two inertias with the shaft between them."""
    inverse = 1 / J + 1 / J_2
    w = np.sqrt(2e5 * inverse)
    return w, 10.0 * inverse / (2 * w)


ANGLES = 2 * np.pi * np.arange(4096) / 4096


def test_an_excitation_by_masses_leaves_the_mean_inertia():
    system = chain(Cylinder(**SIZE, pressure=TABLE, masses="excitation"))
    modes = lp.vibration.mean_modes(system, over="wheel.phi", speed=150.0, turns=2)
    w, damping = two_masses(0.05 + 4.0 * np.mean(lever(ANGLES) ** 2))
    assert modes.hertz[0] * 2 * np.pi == pytest.approx(w, rel=1e-12)
    assert modes.damping[0] == pytest.approx(damping, rel=1e-10)
    # at a single angle the gas is a spring to the ground, which it is not over a cycle
    assert modes.rigid == 1
    fired = lp.start_point(system, start={"crank.phi": 6.6})
    assert lp.modes(system, at=fired).rigid == 0


def test_an_exact_inertia_counts_with_the_mean_of_its_inverse():
    J = 0.05 + 4.0 * lever(ANGLES) ** 2
    w, _ = two_masses(1 / np.mean(1 / J))
    for part in (Cylinder(**SIZE), CrankSlider(r=0.05, L=0.18, m=4.0)):
        modes = lp.vibration.mean_modes(chain(part), over="wheel.phi", speed=1e-3)
        assert modes.hertz[0] * 2 * np.pi == pytest.approx(w, rel=1e-9)
        assert modes.accuracy.residuals.max() < 1e-12


def test_the_six_cylinders_have_their_constant_inertias():
    modes = scenes.mean_modes()
    # symmetric problem of the inertias and stiffnesses alone; damping changes its square
    K = np.zeros((9, 9))
    for i, c in enumerate(STIFFNESSES):
        K[i : i + 2, i : i + 2] += c * np.array([[1, -1], [-1, 1]])
    scale = 1 / np.sqrt(INERTIAS)
    expected = np.sqrt(np.linalg.eigvalsh(scale[:, None] * K * scale)[1:]) / (2 * np.pi)
    error = np.abs(modes.hertz / expected - 1).max()
    print(f"{error:.1e}")
    assert error < 3e-4


def test_analyses_of_a_point_refuse_modes_of_a_mean():
    system = chain(Cylinder(**SIZE))
    modes = lp.vibration.mean_modes(system, over="wheel.phi", speed=100.0)
    for analysis in (lp.vibration.modal_energies, lp.vibration.eigen_sensitivity):
        with pytest.raises(OptionError, match="mean over turns"):
            analysis(modes)
    with pytest.raises(OptionError, match="mean over turns"):
        lp.vibration.shape_sensitivity(modes, of=["crank.phi"])


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"speed": 0.0}, "above zero"),
        ({"speed": np.nan}, "finite"),
        ({"turns": 0}, "whole number"),
        ({"turns": 1}, "Give turns="),
    ],
)
def test_slips_of_mean_modes_are_named(change, match):
    system = chain(Cylinder(**SIZE, pressure=TABLE))
    options = {"over": "wheel.phi", "speed": 100.0, "turns": 2, **change}
    with pytest.raises(OptionError, match=match):
        lp.vibration.mean_modes(system, **options)


def test_vector_sums_of_a_rigid_shape_are_those_of_the_firing_order():
    # with a shaft of 1e9 N.m/rad all throws move alike in the first mode
    engine = Engine(
        cylinders=6, firing_order=(1, 5, 3, 6, 2, 4), J=0.05, c=1e9, **SIZE, masses="series",
        series=SERIES,
    )  # fmt: skip
    model = lp.compose(
        engine=engine,
        shaft=SpringDamper(c=1e4),
        load=Inertia(J=2.0),
        connections=lambda m: [
            lp.connect(m.engine.rear, m.shaft.flange_a),
            *lp.chain(m.shaft, m.load),
        ],
    )
    modes = lp.vibration.mean_modes(
        lp.assemble(model), over="load.phi", speed=100.0, parameters={"engine.m": 0.0}
    )
    phases = {f"engine.throw[{i}].phi": p for i, p in enumerate(model.engine.phases)}
    sums = lp.vibration.vector_sums(modes, phases, orders=np.arange(1, 13) / 2)
    whole = np.isin(sums.orders, (3.0, 6.0))
    received = np.abs(sums.values[0])
    np.testing.assert_allclose(received[whole], 6.0, rtol=1e-4)
    assert received[~whole].max() < 1e-4
    np.testing.assert_allclose(sums.critical_rpm[0], 60 * modes.hertz[0] / sums.orders, rtol=1e-12)
    assert "order" in repr(sums)
    assert len(sums.plot(0).axes) == 12


def test_vector_sums_turn_the_amplitudes_of_a_mode():
    modes = scenes.mean_modes()
    names = [f"engine.throw[{i}].phi" for i in range(6)]
    phases = 2 * np.pi / 3 * np.array(FIRST)
    sums = lp.vibration.vector_sums(modes, dict(zip(names, phases, strict=True)), orders=[1.5, 4])
    for k in range(3):
        for o, order in enumerate((1.5, 4)):
            amplitudes = np.array([modes.shape(name)[k] for name in names])
            expected = abs(
                sum(a * np.exp(-1j * order * p) for a, p in zip(amplitudes, phases, strict=True))
            )
            assert abs(sums.values[k, o]) == pytest.approx(expected, rel=1e-12)
    with pytest.raises(OptionError, match="positive"):
        lp.vibration.vector_sums(modes, {"engine.throw[0].phi": 0.0}, orders=[0.0])
    with pytest.raises(OptionError, match="finite"):
        lp.vibration.vector_sums(modes, {"engine.throw[0].phi": np.inf}, orders=[1])
    with pytest.raises(OptionError, match="name the angles"):
        lp.vibration.vector_sums(modes, {}, orders=[1])
    with pytest.raises(UnknownNameError):
        lp.vibration.vector_sums(modes, {"engine.throw[99].phi": 0.0}, orders=[1])
    with pytest.raises(OptionError, match="no mode 99"):
        sums.plot(99)
