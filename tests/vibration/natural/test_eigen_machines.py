"""Eigenvalues of the five machines in motion: derivatives against differences of sixth order."""

from dataclasses import replace

import numpy as np
import pytest
from differences import slope

import lumped as lp
from lumped.models.carrousel_coiler import scenes as coiler
from lumped.models.eccentric_shear import scenes as shear
from lumped.models.pilger_mill import drive as pilger
from lumped.models.reversing_mill.stand import CreepingGap
from lumped.models.rotary_arm import control as arm
from lumped.points.linearise import moving


def rolling():
    system = lp.assemble(CreepingGap())
    return lp.start_point(system), ["upper.spindle.c", "lower.motor.J", "K_s", "upper.gearbox.J"]


def winding():
    run = coiler.elastic_winding(until=0.3)
    return run.point(0.2), ["drive.rotor.J", "drive.r", "drive.h", "drive.gear.ratio_1"]


def piercing():
    part = pilger.ElasticallyDriven(c=2e6, d=500.0)
    run = pilger.running(part, until=0.3)
    return run.point(0.2), ["c", "mill.m1", "mill.L", "motor.T", "control.k", "mill.T_f"]


def cutting():
    run = shear.free_run(until=0.5)
    return run.point(0.3), ["motor.J", "motor.L", "motor.k", "loaded.shear.upper.J"]


def turning():
    run = arm.run_controlled(until=2.5)
    return run.point(2.2), ["motor.J", "arm.m_x", "reducer.eta", "arm.arms.m"]


def eigenvalues(point):
    """Other than zero, by numpy from the linearisation."""
    own = moving(point.system, point)
    values = np.linalg.eigvals(lp.linearise(point.system, at=point).A[own][:, own])
    return values[np.abs(values) > 1e-9 * np.abs(values).max()]


def by_differences(point, name, values):
    place = point.system.places([name])[0]

    def moved(value):
        theta = point.theta.copy()
        theta[place] = value
        near = eigenvalues(replace(point, theta=theta))
        return near[np.abs(near[None, :] - values[:, None]).argmin(axis=1)]

    own = point.theta[place]
    return slope(moved, own, 1e-3 * abs(own)) * own


@pytest.mark.parametrize(
    ("scene", "oscillating"),
    [(rolling, 3), (winding, 1), (piercing, 2), (cutting, 1), (turning, 0)],
)
def test_the_machines_agree_with_differences_of_sixth_order(scene, oscillating):
    """The arm is rigid and does not oscillate there: its decays alone are compared."""
    point, to = scene()
    modes = lp.modes(point.system, at=point)
    print(modes, modes.decays)
    assert len(modes.eigenvalues) == oscillating
    assert len(modes.decays)
    found = lp.vibration.eigen_sensitivity(modes, by=to)
    values = np.append(modes.eigenvalues, modes.decays)
    received = np.vstack([found.eigenvalues, found.decays]) * [point.parameters[n] for n in to]
    expected = np.column_stack([by_differences(point, name, values) for name in to])
    error = np.abs(received - expected) / np.abs(values)[:, None]
    assert np.abs(received).max(axis=0).min() > 0
    assert error.max() < 1e-8
