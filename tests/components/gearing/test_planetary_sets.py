"""Planetary sets of meshes on a carrier, differentials and bevel gears, against closed forms."""

import numpy as np
import pytest
import scipy.linalg
from rows import assemble_rows

import lumped as lp
from lumped.components import (
    EfficientGear,
    ElasticPlanetary,
    Fixed,
    IdealGear,
    Inertia,
    Speed,
    Torque,
)

SHAFTS = ("s_1", "s_2", "carrier", "ring")


class Ravigneaux(lp.Component):
    """Ravigneaux set of four meshes on one carrier.

    The small sun drives short planets, these the long ones, which mesh with the large sun and with
    the ring.
    """

    s_1 = lp.Flange(free=True)
    s_2 = lp.Flange(free=True)
    carrier = lp.Flange(free=True)
    ring = lp.Flange(free=True)
    z_1: lp.Param = lp.param("1", "teeth of the small sun", 30.0)
    z_2: lp.Param = lp.param("1", "teeth of the large sun", 36.0)
    z_3: lp.Param = lp.param("1", "teeth of the ring", 72.0)
    short: lp.Param = lp.param("1", "teeth of a short planet", 17.0)
    long: lp.Param = lp.param("1", "teeth of a long planet", 18.0)
    inner: IdealGear = IdealGear(ratio=-short / z_1)
    middle: IdealGear = IdealGear(ratio=-long / short)
    large: IdealGear = IdealGear(ratio=-long / z_2)
    outer: IdealGear = IdealGear(ratio=z_3 / long)

    def connections(self):
        meshes = (self.inner, self.middle, self.large, self.outer)
        yield lp.connect(self.carrier, *(mesh.support for mesh in meshes))
        yield from lp.chain(self.s_1, self.inner, self.middle, self.outer, self.ring)
        yield from lp.chain(self.s_2, self.large, self.outer.flange_a)


def geared(gears, drive, held, load, tau=-7.0):
    """Point of a set: `drive` turned at 1 rad/s, `held` fixed, `load` with a torque."""
    system = assemble_rows(
        *(f"drive.flange set.{drive}", f"held.flange set.{held}", f"body.flange_a set.{load}"),
        "load body",
        drive=Speed(w=1.0),
        held=Fixed(),
        body=Inertia(J=1.0),
        load=Torque(tau=tau),
        set=gears,
    )
    return lp.start_point(system)


RAVIGNEAUX = {
    # drive, held: speed of the drive over that of the ring, by hand from both sun-ring ratios
    ("s_1", "carrier"): 72 / 30,
    ("s_2", "carrier"): -72 / 36,
    ("s_1", "s_2"): (1 + 36 / 30) / (1 + 36 / 72),
    ("carrier", "s_2"): 1 / (1 + 36 / 72),
    ("carrier", "s_1"): 1 / (1 - 30 / 72),
}


class TestRavigneaux:
    @pytest.mark.parametrize(("drive", "held"), RAVIGNEAUX)
    def test_ratio_and_torques_are_those_of_its_teeth(self, drive, held):
        found = geared(Ravigneaux(), drive, held, "ring")
        expected = RAVIGNEAUX[drive, held]
        assert abs(found["drive.w"] / found["body.w"] - expected) < 1e-12
        into_set, support = -found["drive.flange.tau"], -found["held.flange.tau"]
        assert abs(into_set - 7.0 / expected) < 1e-12  # power in is power out
        assert abs(into_set + support - 7.0) < 1e-12  # and torques have no sum

    def test_free_set_moves_by_its_two_equations(self):
        """Four bodies on the shafts against Lagrange's equations with both sun-ring ratios."""
        J, tau = np.array([1.0, 2.0, 3.0, 4.0]), np.array([5.0, -3.0, 2.0, 1.0])
        model = lp.compose(
            set=Ravigneaux(),
            bodies=[Inertia(J=j) for j in J],
            loads=[Torque(tau=t) for t in tau],
            connections=lambda m: (
                lp.connect(getattr(m.set, shaft), body.flange_a, load.flange)
                for shaft, body, load in zip(SHAFTS, m.bodies, m.loads, strict=True)
            ),
        )
        point = lp.start_point(lp.assemble(model))
        received = [point[f"bodies[{i}].a"] for i in range(4)]
        # w_1 = w_c + (z_3/z_1) (w_r - w_c), w_2 = w_c - (z_3/z_2) (w_r - w_c), free: w_c and w_r
        basis = np.array([[1 - 2.4, 2.4], [1 + 2, -2], [1, 0], [0, 1]])
        free = np.linalg.solve(basis.T @ np.diag(J) @ basis, basis.T @ tau)
        assert np.abs(np.subtract(received, basis @ free)).max() < 1e-13


class Set(lp.Component):
    """Sun, planet and ring on a carrier."""

    sun = lp.Flange(free=True)
    carrier = lp.Flange(free=True)
    ring = lp.Flange(free=True)
    inner: lp.Component = IdealGear(ratio=-1.0)
    outer: lp.Component = IdealGear(ratio=3.0)

    def connections(self):
        yield lp.connect(self.carrier, self.inner.support, self.outer.support)
        yield from lp.chain(self.sun, self.inner, self.outer, self.ring)


@pytest.mark.parametrize(("sun", "carrier"), [(20.0, -10.0), (-10.0, 120.0)])
def test_losses_in_the_meshes_give_the_efficiency_of_a_planetary_set(sun, carrier):
    """Sun 24, planet 18, ring 60 held; (1 + k eta) / (1 + k), back (1 + k) / (1 + k / eta)."""
    k, eta = 60 / 24, 0.9 * 0.95
    inner = EfficientGear(ratio=-18 / 24, eta=0.9)
    outer = EfficientGear(ratio=60 / 18, eta=0.95)
    system = assemble_rows(
        *("sun_torque sun", "sun.flange_a set.sun", "held.flange set.ring"),
        *("carrier_torque carrier", "carrier.flange_a set.carrier"),
        set=Set(inner=inner, outer=outer),
        sun=Inertia(J=1.0, w=100.0),
        carrier=Inertia(J=10.0),
        held=Fixed(),
        sun_torque=Torque(tau=sun),
        carrier_torque=Torque(tau=carrier),
    )
    point = lp.start_point(system)
    at_sun = point["set.inner.flange_a.tau"] * point["sun.w"]
    at_carrier = point["set.carrier.tau"] * point["carrier.w"]
    assert abs(point["sun.w"] / point["carrier.w"] - (1 + k)) < 1e-12
    if at_sun > 0:
        assert abs(-at_carrier / at_sun - (1 + k * eta) / (1 + k)) < 1e-12
    else:
        assert abs(-at_sun / at_carrier - (1 + k) / (1 + k / eta)) < 1e-12
    assert (at_sun > 0) == (sun > 0)


BODIES = {"sun": 0.01, "carrier": 0.15, "ring": 0.08}  # kg.m2


class TestElasticPlanetary:
    """A stage with elastic meshes against matrices written here, and against the rigid set."""

    K, R_S, N, J_P, C_S, C_R = 2.8, 0.04, 3, 2e-4, 2e8, 3e8

    def stage(self, **given):
        stage = ElasticPlanetary(
            ratio=self.K, r_s=self.R_S, n=self.N, J_p=self.J_P, c_s=self.C_S, c_r=self.C_R, **given
        )
        return lp.compose(
            stage=stage,
            bodies={name: Inertia(J=J) for name, J in BODIES.items()},
            torques={name: Torque(tau=0.0) for name in BODIES},
            connections=lambda m: [
                lp.connect(getattr(m.stage, name), m.bodies[name].flange_a, m.torques[name].flange)
                for name in BODIES
            ],
        )

    def test_natural_frequencies_are_those_of_its_matrices(self):
        r_s, r_r = self.R_S, self.K * self.R_S
        r_p = (r_r - r_s) / 2
        # sun, carrier, ring and all planets; what each moves in the direction of a mesh
        at_sun = np.array([r_s, -r_s - r_p, 0.0, r_p])
        at_ring = np.array([0.0, -r_r + r_p, r_r, -r_p])
        stiff = self.N * (
            self.C_S * np.outer(at_sun, at_sun) + self.C_R * np.outer(at_ring, at_ring)
        )
        mass = np.diag([*BODIES.values(), self.N * self.J_P])
        squares = np.sort(scipy.linalg.eigvals(stiff, mass).real)
        expected = np.sqrt(squares[2:]) / (2 * np.pi)
        received = lp.modes(lp.assemble(self.stage())).hertz
        print(f"modes {received} Hz, by hand {expected} Hz")
        assert received == pytest.approx(expected, rel=1e-9)

    def test_stiff_and_damped_it_moves_as_the_rigid_set(self):
        """The same torques on a `Planetary` whose bodies have the planets' spin as well."""
        given = {'torques["sun"].tau': 20.0, 'torques["carrier"].tau': -30.0}
        system = lp.assemble(self.stage(d_s=5e4, d_r=5e4).with_(given))
        run = lp.simulate(system, until=0.2, rtol=1e-9)
        r_s, r_r = self.R_S, self.K * self.R_S
        r_p = (r_r - r_s) / 2
        # speeds of sun and carrier are free; ring and planets follow
        follow = np.array(
            [[1, 0], [0, 1], [-r_s / r_r, 1 + r_s / r_r], [-r_s / r_p, 1 + r_s / r_p]]
        )
        mass = follow.T @ np.diag([*BODIES.values(), self.N * self.J_P]) @ follow
        a = np.linalg.solve(mass, [20.0, -30.0])
        for name, rate in zip(("sun", "carrier"), a, strict=True):
            received = run[f'bodies["{name}"].w'][-1]
            assert received == pytest.approx(0.2 * rate, rel=1e-3), name
        ring = run['bodies["ring"].w'][-1]
        assert ring == pytest.approx(0.2 * follow[2] @ a, rel=1e-3)
