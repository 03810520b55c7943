"""Derivatives of mode shapes, and of eigenvalues that repeat, by closed forms and matrices."""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from checks import refused
from differences import slope
from drive_chains import Geared, damped_pair, star
from progressive_drive import CUBIC, Progressive, cubic_stiffness
from rows import assemble_row

import lumped as lp
from lumped.components import Fixed, Inertia, Spring, Torque
from lumped.errors import OptionError, SolverError, UnknownNameError


def test_two_inertias_have_the_shape_derivatives_of_the_closed_form(two_mass):
    """Angles a : b == -J_b : J_a, and the torque of the shaft is c (b - a)."""
    modes = lp.modes(lp.assemble(two_mass))
    found = lp.vibration.shape_sensitivity(modes, of=["a.phi", "b.phi", "shaft.tau", "b.w"])
    a, b, c = 2.0, 1.0, 300.0
    expected = {
        ("a.phi", "a.J"): b / a**2,
        ("a.phi", "b.J"): -1 / a,
        ("a.phi", "shaft.c"): 0.0,
        ("shaft.tau", "a.J"): -c * b / a**2,
        ("shaft.tau", "b.J"): c / a,
        ("shaft.tau", "shaft.c"): 1 + b / a,
        ("b.phi", "a.J"): 0.0,
        ("b.w", "shaft.c"): 0.5j * np.sqrt((1 / a + 1 / b) / c),
    }
    for pair, value in expected.items():
        assert found[pair] == pytest.approx([value], rel=1e-11, abs=1e-11), pair
    assert not found.moving
    assert found.residual < 1e-14
    print(found)
    assert "residual" in repr(found)


def shape_by_matrices(drive, value):
    """Angles of the mode near an eigenvalue, from mass, damping and stiffness, to be scaled."""
    n = len(drive.J)
    M, D, K = drive.matrices()
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    values, vectors = scipy.linalg.eig(A)
    return vectors[:n, np.abs(values - value).argmin()]


def test_a_damped_geared_drive_agrees_with_differences_of_matrices():
    drive = Geared.random(6, seed=8)
    modes = lp.modes(lp.assemble(drive.model()))
    to = {"body[2].J": ("J", 2), "shaft[1].c": ("c", 1), "shaft[3].d": ("d", 3)}
    to["gear[4].ratio"] = "ratio", 4
    of = [f"body[{i}].phi" for i in range(6)]
    found = lp.vibration.shape_sensitivity(modes, of=of, by=list(to))
    worst = 0.0
    for k, value in enumerate(modes.eigenvalues):
        shape = np.array([modes.shape(name)[k] for name in of])
        # the largest angle may be one between gears; bodies relative to their largest are compared
        top = np.abs(shape).argmax()
        for name, (kind, place) in to.items():

            def near(x, kind=kind, place=place, value=value, top=top):
                given = getattr(drive, kind).copy()
                given[place] = x
                found = shape_by_matrices(replace(drive, **{kind: given}), value)
                return found / found[top]

            h = 1e-3 * getattr(drive, kind)[place]
            total = slope(near, getattr(drive, kind)[place], h)
            change = np.array([found[n, name][k] for n in of])
            received = change / shape[top] - shape * change[top] / shape[top] ** 2
            size = np.abs(total).max() + 1e-9 / h
            worst = max(worst, np.abs(received - total).max() / size)
    assert worst < 1e-7


def test_shapes_follow_an_equilibrium_that_moves():
    """Wall, progressive coupling, body, spring, body; stiffness at the twist of the load."""
    system = assemble_row(
        wall=Fixed(),
        coupling=Progressive(),
        a=Inertia(J=2.0),
        shaft=Spring(c=3e4),
        b=Inertia(J=1.0),
        load=Torque(tau=900.0),
    )
    modes = lp.modes(system, at=lp.equilibrium(system))
    found = lp.vibration.shape_sensitivity(
        modes, of=["a.phi", "b.phi"], by=["load.tau", "coupling.cubic"]
    )
    assert found.moving

    def ratio(cubic, load):
        """Angle b over a in both modes."""
        c = cubic_stiffness(load, cubic=cubic)
        K, M = np.array([[c + 3e4, -3e4], [-3e4, 3e4]]), np.diag([2.0, 1.0])
        vectors = scipy.linalg.eigh(K, M)[1]
        return vectors[1] / vectors[0]

    point = {"coupling.cubic": CUBIC, "load.tau": 900.0}
    for name in point:
        total = slope(
            lambda x, name=name: ratio(*(point | {name: x}).values()),
            point[name],
            1e-3 * point[name],
        )
        a, b = modes.shape("a.phi"), modes.shape("b.phi")
        received = found["b.phi", name] / a - b * found["a.phi", name] / a**2
        assert received == pytest.approx(total, rel=1e-8)


def test_eigenvalues_that_repeat_part_as_perturbation_theory_says():
    """Tips against each other: of two modes, one does not feel an arm, the other takes 2/3 of it.

    With a tip's inertia the hub is at rest to first order, and the same holds for the inertia.
    """
    found = lp.vibration.eigen_sensitivity(lp.modes(lp.assemble(star(3))))
    assert found.repeated == (0, 1)
    w = 10.0
    expected = [0.0, 1j * (2 / 3) / (2 * w)]
    assert found.split(0, "arm[0].c") == pytest.approx(expected, abs=1e-12)
    expected = [-1j * (2 / 3) * w / 2, 0.0]
    assert found.split(1, "tip[2].J") == pytest.approx(expected, abs=1e-12)
    assert found.split(1, "hub.J") == pytest.approx([0.0, 0.0], abs=1e-12)
    shapes = lp.vibration.shape_sensitivity(found.modes, of=["tip[0].phi"], by=["arm[0].c"])
    assert np.isnan(shapes.derivatives[:2]).all()
    assert np.isfinite(shapes.derivatives[2]).all()
    refused(OptionError, lambda: found.split(2, "arm[0].c"), "mode 2 does not repeat")


def test_bad_input_is_refused(two_mass):
    modes = lp.modes(lp.assemble(two_mass))
    with pytest.raises(OptionError, match="at least one quantity"):
        lp.vibration.shape_sensitivity(modes, of=[])
    refused(UnknownNameError, lambda: lp.vibration.shape_sensitivity(modes, of=["a.phy"]), "a.phi")
    found = lp.vibration.shape_sensitivity(modes, of=["a.phi"], by=["a.J"])
    refused(UnknownNameError, lambda: found["a.phi", "b.J"], "'b.J' was not asked for")
    free = lp.modes(lp.assemble(lp.compose(body=Inertia(J=1.0))))
    with pytest.raises(OptionError, match="no oscillating mode"):
        lp.vibration.shape_sensitivity(free, of=["body.phi"])


def test_an_eigenvalue_with_too_few_shapes_has_infinite_derivatives():
    """Critical damping, but for rounding: two equal eigenvalues, one shape."""
    modes = lp.modes(lp.assemble(damped_pair(1 - 1e-14)))
    found = lp.vibration.eigen_sensitivity(modes)
    assert found.repeated == (0,)
    assert np.isnan(found.hertz[0]).all()
    refused(SolverError, lambda: found.split(0, "shaft.c"), "fewer shapes than eigenvalues")
