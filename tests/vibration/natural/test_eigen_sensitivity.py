"""Derivatives of eigenvalues against closed forms and the theorem on mass and stiffness."""

import numpy as np
import pytest
from checks import refused
from drive_chains import Geared, Pendulum, damped_pair, in_turn, star
from rows import in_a_row

import lumped as lp
from lumped.components import Fixed, Inertia, Spring, SpringDamper
from lumped.errors import OptionError, UnknownNameError


def derived(model, *, to=None, **options):
    return lp.vibration.eigen_sensitivity(lp.modes(lp.assemble(model), **options), by=to)


@pytest.mark.parametrize("zeta", [0.0, 0.02, 0.8])
def test_damping_ratios_have_the_derivatives_of_the_closed_form(zeta):
    c, reduced = 300.0, 2.0 / 3.0
    received = derived(damped_pair(zeta), to=["shaft.c", "shaft.d"])
    f = np.sqrt(c / reduced) / (2 * np.pi)
    expected = [-zeta / (2 * c), 1 / (2 * np.sqrt(c * reduced))]
    assert received.damping[0] == pytest.approx(expected, rel=1e-9, abs=1e-15)
    assert received.hertz[0] == pytest.approx([f / (2 * c), 0.0], rel=1e-9, abs=1e-12)


def test_a_damped_geared_drive_agrees_with_the_theorem_on_mass_and_stiffness():
    """``dl = -v'(l^2 dM + l dD + dK)v / v'(2 l M + D)v`` in absolute angles."""
    drive, n = Geared.random(12, seed=8), 12
    received = derived(drive.model())
    M, D, K = drive.matrices()
    column = {name: i for i, name in enumerate(received.by)}
    worst = 0.0
    for k, value in enumerate(received.modes.eigenvalues):
        v = np.linalg.svd(value**2 * M + value * D + K)[2][-1].conj()
        under = v @ (2 * value * M + D) @ v
        expected = {"brake.d": -value * v[-1] ** 2 / under}
        for i in range(n):
            expected[f"body[{i}].J"] = -(value**2) * v[i] ** 2 / under
        for i in range(n - 1):
            angle = drive.twist[i] @ v
            expected[f"shaft[{i}].c"] = -(angle**2) / under
            expected[f"shaft[{i}].d"] = -value * angle**2 / under
            law = drive.c[i] + value * drive.d[i]
            expected[f"gear[{i}].ratio"] = -2 * law * angle * v[i + 1] / under
        row = received.eigenvalues[k]
        size = max(abs(e) for e in expected.values())
        for name, e in expected.items():
            worst = max(worst, abs(row[column[name]] - e) / (abs(e) + 1e-6 * size))
    assert worst < 1e-7


def test_stiffnesses_share_a_half_and_inertias_a_half_taken_away():
    """Frequencies are homogeneous: Euler's theorem; here of some modes of a large drive."""
    rng = np.random.default_rng(9)
    n = 400
    model = in_turn(
        body=[Inertia(J=float(x)) for x in rng.uniform(0.1, 3, n)],
        shaft=[Spring(c=float(x)) for x in rng.uniform(1e3, 1e6, n - 1)],
    )
    received = derived(model, near=0.0, count=6)
    stiff = np.array([name.endswith(".c") for name in received.by])
    heavy = np.array([name.endswith(".J") for name in received.by])
    assert received.relative[:, stiff].sum(axis=1) == pytest.approx([0.5] * 6, rel=1e-9)
    assert received.relative[:, heavy].sum(axis=1) == pytest.approx([-0.5] * 6, rel=1e-9)
    assert (received.relative[:, stiff] >= 0).all()


def test_a_point_that_is_no_equilibrium_is_held():
    system = lp.assemble(lp.compose(p=Pendulum()))
    modes = lp.modes(system, at=lp.start_point(system, start={"p.phi": 1.0}))
    received = lp.vibration.eigen_sensitivity(modes, by=["p.weight", "p.torque"])
    f = np.sqrt(15.0 * np.cos(1.0)) / (2 * np.pi)
    assert received.hertz[0] == pytest.approx([f / 60.0, 0.0], rel=1e-10, abs=1e-15)
    assert not received.moving


def test_modes_that_repeat_in_one_drive_have_no_derivatives():
    received = derived(star(3))
    assert received.repeated == (0, 1)
    assert np.isnan(received.hertz[:2]).all()
    # all arms against the hub: w^2 = c (1/J + 3/J), arms share the half
    names = [f"arm[{i}].c" for i in range(3)]
    shares = dict(received.ranked(2))
    assert [shares[n] for n in names] == pytest.approx([1 / 6] * 3, rel=1e-11)
    assert "repeated" in repr(received)
    refused(OptionError, lambda: received.ranked(1), "repeats, so it has no derivative")


def test_equal_separate_drives_do_not_repeat(two_mass):
    model = lp.compose(one=two_mass, other=type(two_mass)(), connections=lambda m: [])
    received = derived(model, to=["one.shaft.c", "other.shaft.c"])
    assert received.repeated == ()
    assert np.sort(received.relative, axis=1) == pytest.approx(
        np.array([[0.0, 0.5], [0.0, 0.5]]), rel=1e-11, abs=1e-14
    )


@pytest.mark.parametrize(("c", "d"), [(1.0, 2.0), (3.0, 2 * np.sqrt(3.0)), (100.0, 20.0)])
def test_critical_damping_has_no_derivatives_whether_it_rounds_to_decays_or_a_mode(c, d, capfd):
    """``l^2 + d l + c == 0`` with ``d^2 == 4 c``: both roots are -d / 2, with one shape."""
    model = in_a_row(body=Inertia(J=1.0), shaft=SpringDamper(c=c, d=d), wall=Fixed())
    received = derived(model, to=["shaft.d"])
    found = np.append(received.modes.eigenvalues, received.modes.decays)
    assert np.abs(found + d / 2).max() < 1e-7 * d
    assert np.isnan(np.append(received.eigenvalues, received.decays)).all()
    assert "repeated" in repr(received)
    assert capfd.readouterr().err == ""


def test_beside_critical_damping_decays_have_the_derivatives_of_the_closed_form():
    """``l = -d / 2 -+ sqrt(d^2 / 4 - c)``."""
    c, d = 1.0, 2.0 + 1e-6
    model = in_a_row(body=Inertia(J=1.0), shaft=SpringDamper(c=c, d=d), wall=Fixed())
    received = derived(model, to=["shaft.d", "shaft.c"])
    root = np.sqrt((d / 2 - 1) * (d / 2 + 1))
    expected = [[-0.5 - d / 4 / root, 0.5 / root], [-0.5 + d / 4 / root, -0.5 / root]]
    assert received.decays == pytest.approx(np.array(expected), rel=1e-6)


def test_bad_input_is_refused(two_mass):
    modes = lp.modes(lp.assemble(two_mass))
    with pytest.raises(UnknownNameError, match=r"shaft\.c"):
        lp.vibration.eigen_sensitivity(modes, by=["shaft.C"])
    refused(OptionError, lambda: lp.vibration.eigen_sensitivity(modes).ranked(5), "mode 5 of 1")
    refused(OptionError, lambda: derived(lp.compose(body=Inertia(J=1.0))), "no oscillating mode")


def test_the_tornado_shows_the_ranking(two_mass):
    (axis,) = derived(two_mass).plot().axes
    names = [text.get_text() for text in axis.get_yticklabels()]
    assert names[:3] == ["shaft.c", "b.J", "a.J"]
    assert [bar.get_width() for bar in axis.patches][:3] == pytest.approx([1 / 2, -1 / 3, -1 / 6])
