import numpy as np
import pytest
import scipy
from drive_chains import chain_hertz
from rows import assemble_row, in_a_row, in_rows
from torsional_cases import FIRST, INERTIAS, SERIES, STIFFNESSES

import lumped as lp
from lumped.components import CrankSlider, Cylinder, Engine, Inertia, SpringDamper, Torque
from lumped.errors import OptionError, UnknownNameError
from lumped.models.diesel_genset import scenes

PRESSURE = ((0.0, 0.0), (3.0, 1e5), (5.5, 1e6), (6.4, 8e6), (7.5, 2e6), (9.5, 1e5), (12.0, 0.0))
SIZE = {"bore": 0.1, "r": 0.05, "L": 0.18, "m": 4.0}


def chain(part, J=0.3, d=10.0):
    shaft = SpringDamper(c=2e5, d=d)
    return assemble_row(part=part, crank=Inertia(J=0.05), shaft=shaft, wheel=Inertia(J=J))


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
    system = chain(Cylinder(**SIZE, pressure=PRESSURE, masses="excitation"))
    modes = lp.vibration.mean_modes(system, shaft="wheel.phi", speed=150.0, turns=2)
    w, damping = two_masses(0.05 + 4.0 * np.mean(lever(ANGLES) ** 2))
    assert modes.hertz[0] * 2 * np.pi == pytest.approx(w, rel=1e-12)
    assert modes.damping[0] == pytest.approx(damping, rel=1e-10)
    # at a single angle the gas is a spring to the ground, which it is not over a cycle
    assert modes.rigid == 1
    fired = lp.start_point(system, start={"crank.phi": 6.6})
    assert lp.modes(system, at=fired).rigid == 0


def crank_inertia(a, r, L, m, m_rod, J_rod, k):
    """By the speeds of slider and rod, their derivatives by a complex step; shaft speed 1 rad/s."""
    a = a + 1e-30j
    tilt = -np.arcsin(r / L * np.sin(a))
    slider = r * np.cos(a) + L * np.cos(tilt)
    x, y = (1 - k) * r * np.cos(a) + k * slider, (1 - k) * r * np.sin(a)
    slider, x, y, turn = (part.imag / 1e-30 for part in (slider, x, y, tilt))
    return m * slider**2 + m_rod * (x**2 + y**2) + J_rod * turn**2


@pytest.mark.parametrize("speed", [1e-3, 150.0])
def test_an_exact_inertia_counts_with_its_mean(speed):
    rod = {"r": 0.05, "L": 0.18, "m": 4.0, "m_rod": 2.0, "J_rod": 0.01, "k": 0.3}
    for part, mean in (
        (Cylinder(**SIZE), np.mean(4.0 * lever(ANGLES) ** 2)),
        (CrankSlider(r=0.05, L=0.18, m=4.0), np.mean(4.0 * lever(ANGLES) ** 2)),
        (CrankSlider(**rod), np.mean(crank_inertia(ANGLES, **rod))),
    ):
        modes = lp.vibration.mean_modes(chain(part), shaft="wheel.phi", speed=speed)
        w, damping = two_masses(0.05 + mean)
        assert modes.hertz[0] * 2 * np.pi == pytest.approx(w, rel=1e-12)
        assert modes.damping[0] == pytest.approx(damping, rel=1e-10)
        assert modes.accuracy.residuals.max() < 1e-12


def test_a_damping_ratio_is_that_of_the_shaft_where_gas_springs_have_kinks():
    """Of two inertias that turn freely it is the damper ``2 ratio c / w``, w without damping."""
    w, _ = two_masses(0.05 + 4.0 * np.mean(lever(ANGLES) ** 2))
    found = []
    for d, ratio in ((0.0, 0.01), (2 * 0.01 * 2e5 / w, 0.0)):
        cylinder = Cylinder(**SIZE, pressure=PRESSURE, masses="excitation")
        model = in_a_row(
            part=cylinder,
            crank=Inertia(J=0.05),
            shaft=SpringDamper(c=2e5, d=d),
            wheel=Inertia(J=0.3),
            load=Torque(tau=0.0),
        )
        given = {"shaft": "wheel.phi", "turns": 2, "free": "load.tau", "damping_ratio": ratio}
        speeds, system = np.linspace(0.1, 1.1, 7) * w, lp.assemble(model)
        found.append(
            lp.vibration.order_response(
                system, speeds=speeds, of=["shaft.phi_rel"], orders=[1, 2], **given
            )["shaft.phi_rel"]
        )
    assert found[0] == pytest.approx(found[1], rel=1e-6)


def test_masses_vibrate_alike_whether_their_variation_is_in_the_inertia_or_an_excitation():
    """To first order of the variation it is a torque, which an inertia at its mean resists."""
    given = {"shaft": "wheel.phi", "speeds": np.linspace(50.0, 700.0, 5), "turns": 2}
    found = []
    for masses in ("exact", "excitation"):
        system = chain(Cylinder(**SIZE, pressure=PRESSURE, masses=masses))
        response = lp.vibration.order_response(system, **given, of=["shaft.tau"])
        found.append(response["shaft.tau"])
        assert response.residual < 1e-10
    error = np.abs(found[0] - found[1]).max(axis=0) / np.abs(found[1]).max(axis=0)
    assert error.max() < 1e-9


def test_the_mean_inertia_stands_in_for_the_true_one_to_second_order_of_its_variation():
    """Floquet's exponents of ``J x'' + J' W x' + (c + J'' W^2 / 2) x = 0``, J at W t."""
    c, speed = 2e5, 150.0

    def true(m):
        def slope(t, y):
            a = speed * t + np.array([0, 1j]) * 1e-30
            inertia = 0.05 + m * lever(a) ** 2
            step = 1e-4
            beside = [0.05 + m * lever(speed * t + h) ** 2 for h in (-step, 0.0, step)]
            bend = (beside[0] - 2 * beside[1] + beside[2]) / step**2
            x, v = y.reshape(2, 2)
            rising = inertia[1].imag / 1e-30
            a = -(rising * speed * v + (c + bend * speed**2 / 2) * x) / inertia[0].real
            return np.concatenate([v, a])

        turn = 2 * np.pi / speed
        end = scipy.integrate.solve_ivp(
            slope, (0, turn), np.eye(2).ravel(), method="DOP853", rtol=1e-9, atol=1e-12
        ).y[:, -1]
        phase = abs(np.angle(np.linalg.eigvals(end.reshape(2, 2))[0]))
        near = np.sqrt(c / (0.05 + m * np.mean(lever(ANGLES) ** 2)))
        both = [n * speed + sign * phase / turn for n in range(40) for sign in (1, -1)]
        return min(both, key=lambda w: abs(w - near))

    errors = []
    for m in (1.6, 0.8):
        wall = chain(Cylinder(**{**SIZE, "m": m}), J=1e9, d=0.0)
        modes = lp.vibration.mean_modes(wall, shaft="wheel.phi", speed=speed)
        errors.append(true(m) / (2 * np.pi * modes.hertz[0]) - 1)
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert 0 < errors[0] < 5e-4


def test_the_six_cylinders_have_their_constant_inertias():
    modes = scenes.mean_modes()
    # by inertias and stiffnesses alone; damping changes the square of the frequency
    assert modes.hertz == pytest.approx(chain_hertz(INERTIAS, STIFFNESSES), rel=3e-4)


def test_analyses_of_a_point_refuse_modes_of_a_mean():
    system = chain(Cylinder(**SIZE))
    modes = lp.vibration.mean_modes(system, shaft="wheel.phi", speed=100.0)
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
    system = chain(Cylinder(**SIZE, pressure=PRESSURE))
    options = {"shaft": "wheel.phi", "speed": 100.0, "turns": 2, **change}
    with pytest.raises(OptionError, match=match):
        lp.vibration.mean_modes(system, **options)


def test_vector_sums_of_a_rigid_shape_are_those_of_the_firing_order():
    # with a shaft of 1e9 N.m/rad all throws move alike in the first mode
    engine = Engine(
        cylinders=6, firing_order=(1, 5, 3, 6, 2, 4), J=0.05, c=1e9, **SIZE, masses="series",
        series=SERIES,
    )  # fmt: skip
    model = in_rows(
        "engine.rear shaft load", engine=engine, shaft=SpringDamper(c=1e4), load=Inertia(J=2.0)
    )
    modes = lp.vibration.mean_modes(
        lp.assemble(model), shaft="load.phi", speed=100.0, parameters={"engine.m": 0.0}
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
    for given, order, error, match in (
        ({names[0]: 0.0}, 0.0, OptionError, "positive"),
        ({names[0]: np.inf}, 1.0, OptionError, "finite"),
        ({}, 1.0, OptionError, "name the angles"),
        ({"engine.throw[99].phi": 0.0}, 1.0, UnknownNameError, "throw"),
    ):
        with pytest.raises(error, match=match):
            lp.vibration.vector_sums(modes, given, orders=[order])
    with pytest.raises(OptionError, match="mode 99 of 8"):
        sums.plot(99)
