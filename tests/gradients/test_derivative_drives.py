"""Derivatives of drives of library parts against differences of tight runs."""

import numpy as np
import pytest
from checks import in_all_engines
from derivative_drives import DRIVES
from differences import slope

import lumped as lp


def numbers(system, of, until, changes):
    """Functionals of one run: values only, from a run of its own."""
    parameters = {k: v for k, v in changes.items() if k in system.parameters}
    start = {k: v for k, v in changes.items() if k not in parameters}
    found = lp.gradient(
        system,
        of=of,
        by=[next(iter(system.parameters))],
        until=until,
        parameters=parameters,
        start=start,
        rtol=1e-13,
    )
    return found.values


def by_differences(system, of, to, until):
    """Central differences of sixth order, shape (len(of), len(to))."""
    columns = []
    begin = lp.start_point(system)
    for name in to:
        value = system.parameters.get(name)
        value = begin[name] if value is None else value

        def moved(x, name=name):
            return numbers(system, of, until, {name: x})

        columns.append(slope(moved, value, 1e-4 * (abs(value) or 0.1)))
    return np.array(columns).T


@pytest.mark.parametrize("name", DRIVES)
def test_derivatives_are_those_of_differences(name):
    system, of, to, until = DRIVES[name]()
    back = lp.gradient(system, of=of, by=to, until=until, rtol=1e-11)
    forward = lp.sensitivity(system, of=of, by=to, until=until, rtol=1e-11)
    assert forward.values == pytest.approx(back.values, rel=1e-8, abs=1e-12)
    expected = by_differences(system, of, to, until)
    size = np.abs(expected).max(axis=1)[:, None]
    for what, found in (("gradient", back.derivatives), ("sensitivity", forward.slopes)):
        error = np.abs(found - expected) / np.maximum(np.abs(expected), 1e-3 * size)
        assert error.max() < 1e-5, (what, np.argwhere(error > 1e-5).tolist())


def test_changes_are_crossed_with_the_same_bits_in_all_engines():
    system, of, to, until = DRIVES["dog_clutch_at_an_instant"]()
    llvm, c, python = in_all_engines(
        lambda: lp.gradient(system, of=of, by=to, until=until).derivatives
    )
    assert np.abs(llvm).min(axis=1).max() > 0
    assert (c == llvm).all()
    assert (python == llvm).all()
