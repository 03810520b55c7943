"""Planetary stages with planets one by one, against matrices in NumPy and published modes."""

import numpy as np
import pytest
import scipy.linalg
from planet_matrices import static, stiffness

import lumped as lp
from benchmarks.published.torsional import PLANETS, planetary
from lumped import errors
from lumped.components import (
    ElasticPlanetary,
    Fixed,
    Inertia,
    PlanarPlanetaryStage,
    Planetary,
    PlanetaryStage,
    Spring,
    Torque,
)

TEETH = {"z_s": 40, "z_p": 20, "z_r": 80}
DATA = TEETH | {"r_s": 0.05, "alpha": 0.4, "m_p": 0.8, "J_p": 3e-4}
CENTRES = {"m_sun": 0.7, "m_carrier": 4.0, "m_ring": 3.0, "c_carrier": 2e8, "c_ring": 3e8}


def shaken(rng, n):
    """Random numbers of a stage in its plane, the planets alike."""
    names = ("c_s", "c_r", "c_b", "c_sun", "c_carrier", "c_ring")
    found = {name: rng.uniform(0.5, 5.0) * 1e8 for name in names}
    found |= {name: rng.uniform(0.3, 5.0) for name in ("m_sun", "m_carrier", "m_ring", "m_p")}
    found |= {"J_p": rng.uniform(1e-4, 1e-3), "r_s": rng.uniform(0.03, 0.1)}
    return TEETH | found | {"alpha": rng.uniform(0.3, 0.5), "n": n}


def driven(stage, J=(0.01, 0.1, 0.05), torque=0.0, ring=None):
    """Inertias on sun, carrier and ring; the carrier held, and the ring held by a spring."""
    return lp.compose(
        stage=stage,
        sun=Inertia(J=J[0]),
        carrier=Inertia(J=J[1]),
        ring=Inertia(J=J[2]),
        drive=Torque(tau=torque),
        hold=Spring(c=1e9) if ring is None else Spring(c=ring),
        ground=Fixed(),
        connections=lambda m: [
            *lp.chain(m.drive, m.sun, m.stage.sun),
            lp.connect(m.stage.carrier, m.carrier.flange_a),
            *lp.chain(m.stage.ring, m.ring, m.hold, m.ground),
        ],
    )


class TestLinParker:
    @pytest.mark.parametrize("n", PLANETS)
    def test_modes_have_the_published_frequencies_and_kinds(self, n):
        system = lp.assemble(planetary(n))
        modes = lp.modes(system)
        kinds = np.array(system.model.stage.mode_kinds(modes))
        rotational, pairs, planets = PLANETS[n]
        assert modes.rigid == 1
        for kind, expected in (
            ("rotational", rotational),
            ("translational", np.repeat(pairs, 2)),
            ("planet", np.repeat(planets, n - 3)),
        ):
            received = modes.hertz[kinds == kind]
            assert received == pytest.approx(np.array(expected), abs=0.051), kind

    @pytest.mark.parametrize("seed", range(6))
    def test_any_stage_has_six_rotations_six_pairs_and_three_planet_modes(self, seed):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(3, 7))
        J = rng.uniform(1e-3, 1e-2, 3)
        given = shaken(rng, n)
        system = lp.assemble(driven(PlanarPlanetaryStage(**given), J, ring=rng.uniform(1e6, 1e7)))
        modes = lp.modes(system)
        kinds = np.array(system.model.stage.mode_kinds(modes))
        assert modes.rigid == 1
        assert (kinds == "rotational").sum() == 5  # the rigid one is the sixth
        pairs = modes.hertz[kinds == "translational"]
        assert len(pairs) == 12
        assert pairs[0::2] == pytest.approx(pairs[1::2], rel=1e-9)
        planets = modes.hertz[kinds == "planet"].reshape(3, -1)
        assert planets.shape[1] == n - 3
        assert planets == pytest.approx(planets[:, :1] * np.ones(n - 3), rel=1e-9)

    def test_planets_that_differ_have_the_frequencies_of_their_matrices(self):
        rng = np.random.default_rng(11)
        n = 4
        given = shaken(rng, n)
        own = {name: tuple(given[name] * rng.uniform(0.7, 1.4, n)) for name in ("c_s", "c_r")}
        own["c_b"] = tuple(given["c_b"] * rng.uniform(0.7, 1.4, n))
        psi = np.array([0, 31, 59, 90]) * 2 * np.pi / 120  # whole numbers of teeth
        J, ring = (0.01, 0.1, 0.05), 1e7
        stage = PlanarPlanetaryStage(**given | own, psi=psi)
        modes = lp.modes(lp.assemble(driven(stage, J, ring=ring)))
        s = given | own | {"psi": psi, "pin_t": np.zeros(n), "pin_r": np.zeros(n)}
        rows, c, _ = stiffness(s, given["c_sun"], given["c_carrier"], given["c_ring"])
        K = rows.T @ (c[:, None] * rows)
        K[8, 8] += ring
        wheels = zip((given["m_sun"], given["m_carrier"], given["m_ring"]), J, strict=True)
        masses = [(m, m, inertia) for m, inertia in wheels]
        masses += [(given["m_p"], given["m_p"], given["J_p"])] * n
        w2 = scipy.linalg.eigh(K, np.diag(np.ravel(masses)), eigvals_only=True)
        expected = np.sqrt(w2[1:]) / (2 * np.pi)
        assert modes.hertz == pytest.approx(expected, rel=1e-9)


def held(stage, torque):
    """A torque on the sun, carrier and ring held."""
    return lp.compose(
        stage=stage,
        drive=Torque(tau=torque),
        sun=Inertia(J=0.01),
        grounds=[Fixed(), Fixed()],
        connections=lambda m: [
            *lp.chain(m.drive, m.sun, m.stage.sun),
            lp.connect(m.stage.carrier, m.grounds[0].flange),
            lp.connect(m.stage.ring, m.grounds[1].flange),
        ],
    )


PINS = {"pin_t": (30e-6, -10e-6, 0.0, 5e-6), "pin_r": (0.0, 8e-6, -20e-6, 0.0)}
OWN = {"c_s": (4e8, 5e8, 4.5e8, 5e8), "c_r": (6e8, 5e8, 5.5e8, 6e8), "c_b": (2e8, 1e8, 3e8, 2e8)}


@pytest.mark.parametrize("c_sun", [0.0, 1e8])
@pytest.mark.parametrize("torque", [2000.0, 300.0])
def test_planets_share_a_torque_as_a_linear_solve_says(c_sun, torque):
    given = DATA | PINS | OWN | CENTRES | {"n": 4, "c_sun": c_sun}
    at = lp.equilibrium(lp.assemble(held(PlanarPlanetaryStage(**given), torque)))
    psi = np.arange(4) * np.pi / 2
    forces = static(given | {"psi": psi}, torque, c_sun, 2e8, 3e8)
    received = np.array([at[f"stage.planets[{i}].f_s"] for i in range(4)])
    assert received == pytest.approx(forces, rel=1e-9)
    assert at["stage.sharing"] == pytest.approx(forces.max() / forces.mean(), rel=1e-9)
    assert forces.sum() * given["r_s"] == pytest.approx(torque, rel=1e-9)


def test_only_errors_along_matter_where_nothing_moves_across():
    """Each planet is a spring in series: ``dtau_i = k_i (mean(k e) / mean(k) - e_i)``."""
    given = DATA | {"n": 4} | PINS | {name: OWN[name] for name in ("c_s", "c_r")}
    at = lp.equilibrium(lp.assemble(held(PlanetaryStage(**given), 500.0)))
    k = 1 / (1 / np.array(OWN["c_s"]) + 1 / np.array(OWN["c_r"]))
    stretch = 2 * np.cos(0.4) * np.array(PINS["pin_t"])
    force = k * ((500.0 / 0.05 + k @ stretch) / k.sum() - stretch)
    received = np.array([at[f"stage.planets[{i}].tau"] for i in range(4)])
    assert received == pytest.approx(0.05 * force, rel=1e-9)


def test_without_a_torque_the_planets_share_it_evenly():
    at = lp.equilibrium(lp.assemble(held(PlanetaryStage(**DATA, c_s=4e8, c_r=5e8), 0.0)))
    assert at["stage.sharing"] == 1.0


def test_mirrored_flanks_carry_a_reversed_torque_alike():
    """Reversed torque on the other flanks is the mirror image: errors along change their sign."""
    given = DATA | OWN | CENTRES | {"n": 4, "c_sun": 1e7}
    loads = []
    for sign, order in ((1, [0, 1, 2, 3]), (-1, [0, 3, 2, 1])):
        own = OWN | {"pin_t": [sign * e for e in PINS["pin_t"]], "pin_r": PINS["pin_r"]}
        picked = {name: tuple(values[i] for i in order) for name, values in own.items()}
        stage = PlanarPlanetaryStage(**given | picked, flank=sign)
        at = lp.equilibrium(lp.assemble(held(stage, sign * 900.0)))
        loads.append([sign * at[f"stage.planets[{i}].tau"] for i in order])
    assert loads[1] == pytest.approx(loads[0], rel=1e-9)


def test_alike_planets_on_rigid_pins_are_an_elastic_planetary():
    own = {"c_s": 4e8, "c_r": 5e8}
    stage = PlanetaryStage(**DATA, **own)
    a = 0.075 / np.cos(0.4)
    old = ElasticPlanetary(ratio=2.0, r_s=0.05, n=3, J_p=3e-4, **own)
    new = lp.modes(lp.assemble(driven(stage, ring=1e6))).hertz
    expected = lp.modes(lp.assemble(driven(old, (0.01, 0.1 + 3 * 0.8 * a**2, 0.05), ring=1e6)))
    relative = np.abs(new[:, None] / expected.hertz - 1).min(axis=0)
    assert relative.max() < 1e-9


@pytest.mark.parametrize("kind", [PlanetaryStage, PlanarPlanetaryStage])
def test_stiff_and_light_it_moves_as_the_rigid_set(kind):
    """Accelerations of three free shafts under a torque, after the vibration has died."""
    stiff = {"c_s": 1e12, "c_r": 1e12, "d_s": 1e6, "d_r": 1e6}
    given = DATA | {"m_p": 1e-6, "J_p": 1e-9} | stiff
    if kind is PlanarPlanetaryStage:
        given |= CENTRES | {"c_sun": 1e12, "c_b": 1e12, "d_b": 1e6}
    ends = []
    for stage in (kind(**given), Planetary(ratio=2.0)):
        model = lp.compose(
            stage=stage,
            bodies=[Inertia(J=J) for J in (0.1, 0.2, 0.3)],
            loads=[Torque(tau=tau) for tau in (5.0, -3.0, 2.0)],
            connections=lambda m: [
                lp.connect(port, body.flange_a, load.flange)
                for port, body, load in zip(
                    (m.stage.sun, m.stage.carrier, m.stage.ring), m.bodies, m.loads, strict=True
                )
            ],
        )
        run = lp.simulate(lp.assemble(model), until=0.1, rtol=1e-9)
        ends.append([run[f"bodies[{i}].w"][-1] for i in range(3)])
    assert ends[0] == pytest.approx(ends[1], rel=1e-6)


def test_meshes_that_vary_have_the_phases_of_their_planets():
    """Sun 42: neighbours of four planets are half a tooth apart. The potential has its minimum."""
    given = DATA | {"z_s": 42, "z_p": 18, "z_r": 78, "n": 4, "c_s": 4e8, "c_r": 6e8}
    rows = {"stiffness_s": ((1, 0.3, 0.2),), "error_r": ((1, 4e-6, 0.5), (2, 2e-6, 1.0))}
    stage = PlanetaryStage(**given, **rows)
    wheels = lp.compose(
        stage=stage,
        drive=Torque(tau=900.0),
        sun=Inertia(J=0.01),
        ring=Inertia(J=0.02),
        grounds=[Fixed(), Spring(c=1e6), Fixed()],
        connections=lambda m: [
            *lp.chain(m.drive, m.ring, m.stage.ring),
            lp.connect(m.stage.carrier, m.grounds[0].flange),
            *lp.chain(m.stage.sun, m.sun, m.grounds[1], m.grounds[2]),
        ],
    )
    at = lp.equilibrium(lp.assemble(wheels))

    def mean_torques(angles):
        """What is left of both torques, by complex steps of the potential."""
        return [potential(angles + 1e-30j * np.eye(2)[i]).imag / 1e-30 for i in range(2)]

    def potential(angles):
        sun, ring = angles
        total = 5e5 * sun**2 - 900.0 * ring
        for phase in (0.0, np.pi, 0.0, np.pi):
            c_s = 4e8 * (1 + 0.3 * np.cos(42 * sun - phase + 0.2))
            x = 78 * ring - phase
            e_r = 4e-6 * np.cos(x + 0.5) + 2e-6 * np.cos(2 * x + 1.0)
            both = 0.05 * sun + 0.05 * 78 / 42 * ring - e_r
            total += both**2 / (1 / c_s + 1 / 6e8) / 2
        return total

    angles = np.array([at["stage.sun.phi"], at["stage.ring.phi"]])
    assert np.abs(mean_torques(angles)).max() < 1e-6
    assert at["stage.sharing"] > 1.1


WRONG = {
    "teeth": ({"z_r": 82}, r"z_r = 82 teeth do not mesh .* z_s \+ 2 z_p = 80 teeth"),
    "assembly": ({"n": 7}, r"n = 7 planets .* \(z_s \+ z_r\) / n = 17.1429 is not whole"),
    "room": ({"n": 12}, r"planets collide: their centres are 15.53 modules apart.* 22 modules"),
    "angle": ({"psi": (0.0, 2.0, 4.0)}, r"planets\[1\] cannot .* psi = 2 rad.* 1.98968 rad"),
    "count": ({"n": 2.5}, r"n = 2.5 planets: a whole number, at least 1"),
    "none": ({"z_p": 0}, r"z_p = 0 teeth: a whole number, at least 3"),
    "each": ({"c_s": (1e8, 2e8)}, r"c_s = .*one number for all, or 3 of them"),
    "damping": ({"d_b": 3.0}, r"d_b = 3.0 damps bearings of planets; give their stiffness c_b"),
    "flank": ({"flank": 0}, r"flank = 0: 1, or -1"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_does_not_fit_is_refused(case):
    changed, text = WRONG[case]
    stage = PlanetaryStage(**DATA | {"c_s": 4e8, "c_r": 5e8} | changed)
    with pytest.raises(errors.DeclarationError, match=rf"^stage \(PlanetaryStage\): .*{text}"):
        lp.assemble(driven(stage))


def test_shifted_gears_mesh_unless_their_pressure_angle_is_none():
    given = DATA | {"c_s": 4e8, "c_r": 5e8, "profile_shift": True}
    fits = lp.assemble(held(PlanetaryStage(**given | {"z_r": 83}), 100.0))
    at = lp.equilibrium(fits)
    tau = -at["stage.carrier.tau"]
    assert tau == pytest.approx(100.0 * (1 + 83 / 40), rel=1e-9)
    with pytest.raises(errors.ParameterError, match=r"alpha = 0.4 rad .* greater than 0.51"):
        lp.assemble(held(PlanetaryStage(**given | {"z_r": 89}), 100.0))


def test_a_single_parameter_of_one_planet_is_out_of_range():
    stage = PlanetaryStage(**DATA, c_s=(4e8, -1.0, 4e8), c_r=5e8)
    with pytest.raises(errors.ParameterError, match=r"stage.planets\[1\].c_s = -1 N/m"):
        lp.start_point(lp.assemble(held(stage, 1.0)))
