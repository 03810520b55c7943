"""Eigenvalues followed over a parameter, against closed forms and crossings known beforehand."""

import numpy as np
import pytest
from rows import assemble_row

import lumped as lp
from lumped.components import Fixed, Inertia, LinearTorque, Spring, SpringDamper
from lumped.errors import OptionError, ParameterError


def oscillator(d=0.0):
    return assemble_row(ground=Fixed(), shaft=SpringDamper(c=200.0, d=d), body=Inertia(J=2.0))


def test_a_damped_oscillator_follows_its_circle_and_splits_on_the_axis():
    d = np.linspace(0.0, 60.0, 25)  # critical at 40
    locus = lp.vibration.root_locus(oscillator(), along={"shaft.d": d})
    expected = np.sort_complex(np.array([np.roots([2.0, value, 200.0]) for value in d]))
    received = np.sort_complex(locus.eigenvalues)
    error = np.abs(received - expected).max(axis=1)
    assert error[np.abs(d - 40) > 1].max() < 1e-12 * 30
    assert locus.damping[0] == pytest.approx([0, 0], abs=1e-15)
    assert not locus.unstable.any()


def two_drives():
    """Two drives whose frequencies cross where one stiffness changes."""
    return assemble_row(
        ground=Fixed(),
        one=Spring(c=100.0),
        a=Inertia(J=1.0),
        coupling=Spring(c=1e-3),
        b=Inertia(J=1.0),
        two=Spring(c=400.0),
        wall=Fixed(),
    )


def test_modes_are_followed_through_a_crossing():
    """The coupling is so weak that over the grid each keeps its shape; counting would swap them."""
    locus = lp.vibration.root_locus(two_drives(), along={"one.c": np.linspace(100.0, 900.0, 12)})
    upper = np.flatnonzero(locus.eigenvalues[0].imag > 0)
    slow, fast = upper[np.argsort(locus.hertz[0, upper])]
    expected = np.sqrt(np.linspace(100.0, 900.0, 12)) / (2 * np.pi)
    assert locus.hertz[:, slow] == pytest.approx(expected, rel=1e-5)
    assert locus.hertz[:, fast] == pytest.approx(np.full(12, 20 / (2 * np.pi)), rel=1e-5)
    assert not locus.doubtful


def test_veering_modes_exchange_their_shapes_without_crossing():
    """With a strong coupling the lower stays the lower: exact eigenvalues of two by two."""
    system = two_drives()
    c = np.linspace(100.0, 900.0, 9)
    locus = lp.vibration.root_locus(
        system,
        along={"one.c": c},
        at=lambda value: lp.start_point(system, parameters={"one.c": value, "coupling.c": 150.0}),
    )
    upper = np.flatnonzero(locus.eigenvalues[0].imag > 0)
    received = np.sort(locus.hertz[:, upper], axis=1)
    for row, value in zip(received, c, strict=True):
        K = np.array([[value + 150.0, -150.0], [-150.0, 550.0]])
        assert row == pytest.approx(np.sqrt(np.linalg.eigvalsh(K)) / (2 * np.pi), rel=1e-12)
    assert (np.diff(locus.hertz[:, upper], axis=1) != 0).all()
    order = np.argsort(locus.hertz[:, upper], axis=1)
    assert (order == order[0]).all()


def test_an_unstable_side_is_told():
    system = assemble_row(
        ground=Fixed(),
        shaft=Spring(c=200.0),
        body=Inertia(J=2.0),
        load=LinearTorque(tau_nominal=1.0, w_nominal=1.0),
    )
    locus = lp.vibration.root_locus(system, along={"load.tau_nominal": [1.0, 0.5, -0.5, -1.0]})
    assert locus.unstable.tolist() == [True, True, False, False]
    assert locus.eigenvalues.real[:, 0] == pytest.approx([0.25, 0.125, -0.125, -0.25], rel=1e-12)
    assert "evaluations" in repr(locus)
    assert locus.plot().axes


def test_bad_input_is_refused():
    with pytest.raises(OptionError, match="at least two values"):
        lp.vibration.root_locus(oscillator(), along={"shaft.d": [1.0]})
    with pytest.raises(OptionError, match="ascending or descending"):
        lp.vibration.root_locus(oscillator(), along={"shaft.d": [1.0, 3.0, 2.0]})
    with pytest.raises(ParameterError, match=r"body\.J"):
        lp.vibration.root_locus(oscillator(), along={"body.J": [1.0, 0.0]})
