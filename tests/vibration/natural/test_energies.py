"""Energies of modes against shapes and matrices, participation against differences."""

import numpy as np
import pytest
from drive_chains import Geared, in_turn
from rows import in_a_row, in_rows

import lumped as lp
from lumped.components import (
    Capacitor,
    Fixed,
    Ground,
    IdealGear,
    Inductor,
    Inertia,
    Spring,
    SpringDamper,
    translation,
)
from lumped.errors import OptionError


def test_two_inertias_share_the_kinetic_energy_as_momentum_says(two_mass):
    received = lp.vibration.modal_energies(lp.modes(lp.assemble(two_mass)))
    elastic, kinetic = received.ranked(0)
    assert elastic == [("shaft", pytest.approx(1.0, rel=1e-12))]
    # J_a w_a == -J_b w_b, so the energies are as 1/J
    assert [name for name, _ in kinetic] == ["b", "a"]
    assert [v for _, v in kinetic] == pytest.approx([2 / 3, 1 / 3], rel=1e-12)


def geared(n):
    rng = np.random.default_rng(3)
    J, c = rng.uniform(0.1, 3.0, n), rng.uniform(1e3, 1e5, n - 1)
    model = in_turn(
        body=[Inertia(J=float(x)) for x in J],
        shaft=[Spring(c=float(x)) for x in c],
        gear=[IdealGear(ratio=2.5) for _ in c],
    )
    return J, c, lp.modes(lp.assemble(model))


def test_a_geared_drive_has_the_energies_of_its_matrices():
    n = 7
    J, c, modes = geared(n)
    received = lp.vibration.modal_energies(modes)
    names = {f"body[{i}]" for i in range(n)} | {f"shaft[{i}]" for i in range(n - 1)}
    assert set(received.components) == names
    same, root = Geared(J, c, 0 * c, np.full(n - 1, 2.5)), np.sqrt(J)
    _, _, K = same.matrices()
    _, vectors = np.linalg.eigh(K / np.outer(root, root))
    place = {name: i for i, name in enumerate(received.components)}
    for k in range(n - 1):
        angles = vectors[:, k + 1] / root
        elastic, kinetic = c * (same.twist @ angles) ** 2, J * angles**2
        found = received.elastic[k][[place[f"shaft[{i}]"] for i in range(n - 1)]]
        assert found == pytest.approx(elastic / elastic.sum(), rel=1e-8, abs=1e-11)
        found = received.kinetic[k][[place[f"body[{i}]"] for i in range(n)]]
        assert found == pytest.approx(kinetic / kinetic.sum(), rel=1e-8, abs=1e-11)


def test_translation_and_rotation_count_alike():
    wall, spring, mass = translation.Fixed(), translation.Spring(c=100.0), translation.Mass(m=2.0)
    model = lp.compose(
        straight=in_a_row(wall=wall, spring=spring, mass=mass),
        turning=in_a_row(ground=Fixed(), shaft=Spring(c=50.0), body=Inertia(J=1.0)),
    )
    received = lp.vibration.modal_energies(lp.modes(lp.assemble(model)))
    found = [[x[0][0] for x in received.ranked(i)] for i in range(2)]
    expected = [["straight.spring", "straight.mass"], ["turning.shaft", "turning.body"]]
    assert sorted(found) == expected
    assert "100.0 %" in repr(received)


def test_bad_input_is_refused(two_mass):
    with pytest.raises(OptionError, match="mode 3 of 1"):
        lp.vibration.modal_energies(lp.modes(lp.assemble(two_mass))).ranked(3)
    with pytest.raises(OptionError, match="no oscillating mode"):
        lp.vibration.modal_energies(lp.modes(lp.assemble(lp.compose(body=Inertia(J=1.0)))))


class Feeding(lp.Component):
    """A damper that may feed, as friction that falls with the speed does."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    d: lp.Param = lp.param("N.m.s/rad", "damping")

    def equations(self):
        w = lp.der(self.flange_b.phi - self.flange_a.phi)
        yield self.flange_b.tau == self.d * w
        yield self.flange_a.tau == -self.d * w


def test_contributions_to_damping_add_up_and_name_who_damps():
    """Strong damping in two places and one that feeds: q^H D q of numbers written here."""
    model = in_a_row(
        ground=Fixed(),
        bearing=Feeding(d=-0.2),
        a=Inertia(J=1.0),
        shaft=SpringDamper(c=30.0, d=2.0),
        b=Inertia(J=2.0),
        coupling=SpringDamper(c=20.0, d=0.7),
        c=Inertia(J=3.0),
    )
    modes = lp.modes(lp.assemble(model))
    received = lp.vibration.modal_energies(modes)
    total = received.damping.sum(axis=1)
    assert total == pytest.approx(modes.damping, rel=1e-12)
    place = {name: i for i, name in enumerate(received.components)}
    J = np.array([1.0, 2.0, 3.0])
    for k, value in enumerate(modes.eigenvalues):
        q = np.array([modes.shape(f"{name}.phi")[k] for name in "abc"])
        mass = 2 * abs(value) * (J * np.abs(q) ** 2).sum()
        losses = {"bearing": -0.2 * abs(q[0]) ** 2, "shaft": 2.0 * abs(q[1] - q[0]) ** 2}
        losses["coupling"] = 0.7 * abs(q[2] - q[1]) ** 2
        for name, loss in losses.items():
            assert received.damping[k, place[name]] == pytest.approx(loss / mass, rel=1e-9)
        # shares of the energies hold with damping as well
        elastic = 30.0 * abs(q[1] - q[0]) ** 2, 20.0 * abs(q[2] - q[1]) ** 2
        share = received.elastic[k][[place["shaft"], place["coupling"]]]
        assert share == pytest.approx(np.array(elastic) / sum(elastic), rel=1e-9)
        kinetic = J * np.abs(q) ** 2 / (J * np.abs(q) ** 2).sum()
        assert received.kinetic[k][[place[name] for name in "abc"]] == pytest.approx(kinetic)
    assert (received.damping[:, place["bearing"]] < 0).all()


def test_nodes_lie_where_the_shape_passes_zero(two_mass):
    modes = lp.modes(lp.assemble(two_mass))
    (node,) = lp.vibration.modal_energies(modes).nodes(0)
    # J_a : J_b as 2 : 1, so the node is twice as far from b as from a
    assert (node.component, node.fraction) == ("shaft", pytest.approx(1 / 3, rel=1e-12))
    assert node.amplitude == pytest.approx(0, abs=1e-14)
    _, _, modes = geared(8)
    energies = lp.vibration.modal_energies(modes)
    for k in range(len(modes.hertz)):
        assert len(energies.nodes(k)) == k + 1  # Sturm: one more from mode to mode
    with pytest.raises(OptionError, match="mode 9 of 7"):
        energies.nodes(9)


def test_participation_is_the_derivative_by_the_diagonal_of_the_state_matrix():
    model = in_a_row(
        a=Inertia(J=1.0),
        shaft=SpringDamper(c=30.0, d=1.0),
        b=Inertia(J=2.0),
        coupling=SpringDamper(c=20.0, d=0.7),
        c=Inertia(J=3.0),
    )
    modes = lp.modes(lp.assemble(model))
    found = lp.vibration.participation(modes)
    assert found.factors.sum(axis=1) == pytest.approx(np.ones(2), rel=1e-12)
    A = lp.linearise(modes.system).A

    def moved(i, step):
        values = np.linalg.eigvals(A + step * np.diag(np.eye(len(A))[i]))
        return np.array([values[np.abs(values - v).argmin()] for v in modes.eigenvalues])

    for i in range(len(A)):
        difference = (moved(i, 1e-5) - moved(i, -1e-5)) / 2e-5
        assert found.factors[:, i] == pytest.approx(difference, rel=1e-6, abs=1e-8)
    assert found.ranked(0)[0][1] == pytest.approx(np.abs(found.factors[0]).max())
    assert "participation" in repr(found)


def test_a_mode_of_currents_alone_has_no_shares():
    circuit = in_rows(
        "ground.pin coil.n buffer.n",
        "coil.p buffer.p",
        "wall shaft body",
        ground=Ground(),
        coil=Inductor(L=0.1),
        buffer=Capacitor(C=1e-3),
        wall=Fixed(),
        shaft=Spring(c=50.0),
        body=Inertia(J=1.0),
    )
    modes = lp.modes(lp.assemble(circuit))
    received = lp.vibration.modal_energies(modes)
    assert modes.hertz * 2 * np.pi == pytest.approx([np.sqrt(50.0), 100.0])
    assert received.kinetic.sum(axis=1).tolist() == [1.0, 0.0]
    assert received.elastic.sum(axis=1).tolist() == [1.0, 0.0]
    assert not received.damping.any()
    assert "nan" not in repr(received)
