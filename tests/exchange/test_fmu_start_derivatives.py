"""Derivatives of exported models at the start, by parameters and start values."""

import numpy as np
import pytest
from exchanged import Exchanged
from fmus import LIMITED, fmpy
from rows import in_a_row, in_rows
from test_fmu_derivatives import MODELS

import lumped as lp
from lumped.components import Filter, Ramp, translation
from lumped.points.start_slopes import start_slopes
from lumped.points.start_values import read_start_values

STARTS = {**MODELS, "limited": (LIMITED, [], ["limiter.y"])}


def derivatives_at_start(system, known, outputs):
    """Of rates, outputs and states, from those of our own start and of the equations."""
    varied, directions = {}, np.eye(len(known))
    seed, theta = np.zeros((system.theta(None).size, len(known))), system.theta(None)
    free = [name for name in known if name in system.parameters]
    for name, direction in zip(known, directions, strict=True):
        if name in free:
            seed[system.places([name])[0]] = direction
        else:
            varied |= dict.fromkeys(read_start_values(system, {name: 0.0}), direction)
    _, states = start_slopes(system, theta, {}, 0.0, seed, varied)
    matrices = lp.linearise(system, inputs=free, outputs=outputs)
    picked = directions[[known.index(name) for name in free]]
    rates, values = matrices.A @ states + matrices.B @ picked, matrices.C @ states
    return np.vstack([rates, values + matrices.D @ picked, states])


def slope(unit, unknown, name, value):
    """By finite differences; to one side where the other is out of range."""
    step = 1e-6 * max(abs(value), 1e-2)

    def at(part):
        unit.set({name: value + part * step})
        return unit.get(unknown)

    try:
        found = (at(1) - at(-1)) / (2 * step)
    except fmpy.fmi1.FMICallException:
        found = (4 * at(1) - 3 * at(0) - at(2)) / (2 * step)
    at(0)
    return found


@pytest.mark.parametrize(
    ("name", "version"), [("drive", "2.0"), ("four_bar", "3.0"), ("limited", "3.0")]
)
def test_derivatives_of_the_start(tmp_path, name, version):
    """In the initialisation mode, by parameters (also fixed ones) and start values."""
    path, (model, inputs, outputs) = tmp_path / "unit.fmu", STARTS[name]
    system = lp.assemble(model)
    options = {"version": version, "kind": "model_exchange"}
    lp.export_fmu(system, path, inputs=inputs, outputs=outputs, **options)
    unit = Exchanged(path)
    facts = unit.facts
    known = [v.name for v in facts.modelVariables if v.start is not None]
    unknown = [*(u.variable.name for u in facts.derivatives), *outputs, *system.state_names]
    count = len(unknown)
    unknown += [u.variable.name for u in facts.eventIndicators]
    found = unit.jacobian(unknown, known)
    expected = derivatives_at_start(system, known, outputs)
    scale = np.abs(expected).max(axis=0)
    assert len(expected) == count
    error = (np.abs(found[:count] - expected) / (scale + 1e-300)).max()
    slopes = np.array(
        [slope(unit, unknown, k, v) for k, v in zip(known, unit.get(known), strict=True)]
    )
    size = np.abs(found).max(axis=0) + 1e-3 * np.abs(unit.get(unknown)).max()
    rough = (np.abs(found - slopes.T) / size).max()
    assert scale.min() < scale.max()
    assert error < 1e-10
    assert rough < 1e-6
    if unit.new:
        weights = np.random.default_rng(1).uniform(-1.0, 1.0, len(unknown))
        received = unit.reverse(unknown, known, weights)
        assert np.abs(received - weights @ found).max() < 1e-12 * np.abs(found).sum(axis=0).max()
    unit.close()


def test_a_lag_at_rest_starts_where_its_input_is_and_moves_with_the_time(tmp_path):
    """There x = u = 3 + 2 t: by the time of the start 2, by the offset 1."""
    model = in_rows(
        "signal.y lag.u",
        signal=Ramp(height=8.0, duration=4.0, offset=3.0),
        lag=Filter(T=0.1),
        initial_equations=lambda m: [lp.der(m.lag.x) == 0],
    )
    path = tmp_path / "lag.fmu"
    lp.export_fmu(lp.assemble(model), path, version="3.0", kind="model_exchange")
    unit = Exchanged(path)
    known = ["time", "signal.offset", "signal.height", "signal.duration"]
    found = unit.jacobian(["lag.x", "der(lag.x)"], known)
    assert unit.get(["lag.x"]) == pytest.approx([3.0], rel=1e-12)
    np.testing.assert_allclose(found, [[2.0, 1.0, 0.0, 0.0], [0.0] * 4], rtol=1e-12, atol=1e-12)
    unit.close()


def test_what_collides_at_the_start_has_no_derivatives_there(tmp_path):
    """A body that starts at its stop, towards it, leaves it at once."""
    model = in_a_row(
        floor=translation.Stop(restitution=0.5), mass=translation.Mass(m=1.0, s=0.0, v=-2.0)
    )
    path = tmp_path / "ball.fmu"
    system = lp.assemble(model)
    lp.export_fmu(system, path, version="3.0", kind="model_exchange")
    unit = Exchanged(path)
    (speed,) = [n for n in system.state_names if n.endswith((".v", ".v_rel"))]
    assert abs(unit.get([speed])[0]) == pytest.approx(1.0, rel=1e-12)
    with pytest.raises(fmpy.fmi1.FMICallException):
        unit.forward([f"der({speed})"], ["mass.m"], [1.0])
    assert "what collides at the start" in unit.told[-1]
    unit.set({"floor.s_min": 1.0})
    with pytest.raises(fmpy.fmi1.FMICallException, match="discard"):
        unit.get([speed])
    assert "starts 1 m inside the body" in unit.told[-1]
    unit.set({"floor.s_min": 0.0})
    unit.integrate()
    assert unit.forward([f"der({speed})"], ["mass.m"], [1.0]) == [0.0]
    unit.close()
