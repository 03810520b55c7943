"""Energies of modes against shapes, matrices and derivatives of frequencies."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Fixed, IdealGear, Inertia, Spring, SpringDamper, translation
from lumped.errors import OptionError


def test_two_inertias_share_the_kinetic_energy_as_momentum_says(two_mass):
    received = lp.modal_energies(lp.modes(lp.assemble(two_mass)))
    elastic, kinetic = received.ranked(0)
    assert elastic == [("shaft", pytest.approx(1.0, rel=1e-12))]
    # J_a w_a == -J_b w_b, so the energies are as 1/J
    assert [name for name, _ in kinetic] == ["b", "a"]
    assert [v for _, v in kinetic] == pytest.approx([2 / 3, 1 / 3], rel=1e-12)


class Stage(lp.Component):
    """A shaft and a gear."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    c: lp.Param = lp.param("N.m/rad", "stiffness", above=0)
    shaft: Spring = Spring(c=c)
    gear: IdealGear = IdealGear(ratio=2.5)

    def connections(self):
        yield lp.connect(self.flange_a, self.shaft.flange_a)
        yield from lp.chain(self.shaft, self.gear)
        yield lp.connect(self.gear.flange_b, self.flange_b)


def geared(n):
    rng = np.random.default_rng(3)
    J, c = rng.uniform(0.1, 3.0, n), rng.uniform(1e3, 1e5, n - 1)
    model = lp.compose(
        body=[Inertia(J=float(x)) for x in J],
        stage=[Stage(c=float(x)) for x in c],
        connections=lambda m: [
            x for i in range(n - 1) for x in lp.chain(m.body[i], m.stage[i], m.body[i + 1])
        ],
    )
    return J, c, lp.modes(lp.assemble(model))


def test_a_geared_drive_has_the_energies_of_its_matrices():
    n = 7
    J, c, modes = geared(n)
    received = lp.modal_energies(modes)
    assert set(received.components) == {f"body[{i}]" for i in range(n)} | {
        f"stage[{i}].shaft" for i in range(n - 1)
    }
    twist = np.zeros((n - 1, n))
    twist[np.arange(n - 1), np.arange(n - 1)] = -1.0
    twist[np.arange(n - 1), np.arange(1, n)] = 2.5
    root = np.sqrt(J)
    _, vectors = np.linalg.eigh((twist.T @ np.diag(c) @ twist) / np.outer(root, root))
    place = {name: i for i, name in enumerate(received.components)}
    for k in range(n - 1):
        angles = vectors[:, k + 1] / root
        elastic, kinetic = c * (twist @ angles) ** 2, J * angles**2
        found = received.elastic[k][[place[f"stage[{i}].shaft"] for i in range(n - 1)]]
        assert found == pytest.approx(elastic / elastic.sum(), rel=1e-8, abs=1e-11)
        found = received.kinetic[k][[place[f"body[{i}]"] for i in range(n)]]
        assert found == pytest.approx(kinetic / kinetic.sum(), rel=1e-8, abs=1e-11)


def test_shares_are_twice_the_relative_sensitivities():
    """Rayleigh's quotient: dw/w = (elastic share) / 2 dc/c."""
    _, _, modes = geared(9)
    energies, sensitivity = lp.modal_energies(modes), lp.eigen_sensitivity(modes)
    for i, name in enumerate(energies.components):
        body = name.startswith("body")
        parameter = f"{name}.J" if body else f"{name.removesuffix('.shaft')}.c"
        shares = -energies.kinetic[:, i] if body else energies.elastic[:, i]
        column = sensitivity.parameters.index(parameter)
        expected = 2 * sensitivity.relative[:, column]
        assert shares == pytest.approx(expected, rel=1e-7, abs=2e-9)


def test_light_damping_changes_shares_by_the_square_of_its_ratio(two_mass):
    zeta = 1e-3
    d = 2 * zeta * np.sqrt(300.0 * 2 / 3)
    model = two_mass.with_({"shaft": SpringDamper(c=300.0, d=d)})
    received = lp.modal_energies(lp.modes(lp.assemble(model)))
    shares = dict(received.ranked(0)[1])
    assert shares["b"] == pytest.approx(2 / 3, abs=10 * zeta**2)


def test_translation_and_rotation_count_alike():
    model = lp.compose(
        wall=translation.Fixed(),
        spring=translation.Spring(c=100.0),
        mass=translation.Mass(m=2.0),
        ground=Fixed(),
        shaft=Spring(c=50.0),
        body=Inertia(J=1.0),
        connections=lambda m: [
            *lp.chain(m.wall, m.spring, m.mass),
            *lp.chain(m.ground, m.shaft, m.body),
        ],
    )
    received = lp.modal_energies(lp.modes(lp.assemble(model)))
    found = [[x[0][0] for x in received.ranked(i)] for i in range(2)]
    assert sorted(found) == [["shaft", "body"], ["spring", "mass"]]
    assert "100.0 %" in repr(received)


def test_bad_input_is_refused(two_mass):
    with pytest.raises(OptionError, match="mode 3 of 1"):
        lp.modal_energies(lp.modes(lp.assemble(two_mass))).ranked(3)
    with pytest.raises(OptionError, match="no oscillating mode"):
        lp.modal_energies(lp.modes(lp.assemble(lp.compose(body=Inertia(J=1.0)))))
