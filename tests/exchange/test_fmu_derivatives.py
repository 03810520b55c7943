"""Derivatives and dependencies of exported models, also as CasADi's DaeBuilder reads them."""

import zipfile

import casadi as ca
import numpy as np
import pytest
from exchanged import Exchanged
from fmus import LIMITED, fmpy
from linkages import four_bar
from test_fmu import Drive

import lumped as lp
from lumped.components import Brake, Inertia, SpringDamper, Torque
from lumped.ops import where

VERSIONS = ("2.0", "3.0")
INPUTS, OUTPUTS = ["motor.tau"], ["wheel.tau", "load.w"]


class Rough(lp.Component):
    """A motor with a law of its speed, a progressive spring, and a brake that slips."""

    motor: Torque = Torque(tau=5.0)
    rotor: Inertia = Inertia(J=0.5, w=3.0)
    shaft: SpringDamper = SpringDamper(c=400.0, d=2.0)
    load: Inertia = Inertia(J=2.0, w=1.0)
    brake: Brake = Brake(characteristic=((0, 0.5), (2, 0.8), (6, 1.5)), f_max=3.0, u=1.0)

    def connections(self):
        yield from lp.chain(self.motor.flange, self.rotor, self.shaft, self.load, self.brake)


MODELS = {
    "drive": (Drive(), ["motor.tau"], ["wheel.tau", "load.w"]),
    "rough": (Rough(), ["motor.tau"], ["brake.tau", "shaft.tau"]),
    "four_bar": (four_bar(w=10.0), [], ["rocker.phi", "rocker.w"]),
}
WAYS = [("drive", "2.0"), ("rough", "3.0"), ("four_bar", "3.0")]


@pytest.fixture(scope="module", params=WAYS, ids="-".join)
def exported(request, tmp_path_factory):
    name, version = request.param
    model, inputs, outputs = MODELS[name]
    path = tmp_path_factory.mktemp("derivatives") / f"{name}.fmu"
    system = lp.assemble(model)
    options = {"version": version, "kind": "model_exchange"}
    lp.export_fmu(system, path, inputs=inputs, outputs=outputs, **options)
    unit = Exchanged(path).integrate()
    yield system, unit, inputs, outputs
    unit.close()


def unknown_and_known(unit, outputs):
    """Rates, outputs and indicators; states, inputs and parameters that can be tuned."""
    indicators = unit.facts.eventIndicators if unit.new else []
    rates = [u.variable.name for u in unit.facts.derivatives]
    unknown = [*rates, *outputs, *(u.variable.name for u in indicators)]
    states = [u.variable.derivative.name for u in unit.facts.derivatives]
    free = [
        v.name
        for v in unit.facts.modelVariables
        if v.causality == "input" or v.variability == "tunable"
    ]
    return unknown, [*states, *free]


def jacobian_of(system, known, outputs):
    """The same by CasADi."""
    count = len(system.state_names)
    matrices = lp.linearise(system, inputs=known[count:], outputs=outputs)
    found = np.block([[matrices.A, matrices.B], [matrices.C, matrices.D]])
    if not system.switching:
        return found
    x, p, *_ = system.inputs
    margins = sum(system.margins(*system.inputs), start=ca.SX(0))
    slopes = ca.jacobian(margins, ca.vertcat(x, p[system.places(known[count:])]))
    point = lp.start_point(system)
    at = point.x, point.theta, point.time, point.settings
    more = ca.Function("slopes", system.inputs, [slopes])(*at).full()
    return np.vstack([found, more])


def test_derivatives_are_those_of_the_linearisation(exported):
    system, unit, _, outputs = exported
    unknown, known = unknown_and_known(unit, outputs)
    expected = jacobian_of(system, known, outputs)
    found = unit.jacobian(unknown, known)
    scale = np.abs(expected).max(axis=0) + 1e-300
    print(f"{(np.abs(found - expected) / scale).max():.1e}")
    assert np.abs(expected).min() < np.abs(expected).max()
    assert (np.abs(found - expected) <= 1e-10 * scale).all()
    if not unit.new:
        return
    lists = {u.variable.name: u.dependencies for u in unit.facts.eventIndicators}
    for name, row in zip(unknown, found, strict=True):
        if name in lists:
            depends = {known[k] for k in np.flatnonzero(row)}
            tuned = {v.name for v in unit.facts.modelVariables if v.causality == "parameter"}
            assert depends - tuned <= {v.name for v in lists[name]}
    weights = np.random.default_rng(1).uniform(-1.0, 1.0, len(unknown))
    received, wanted = unit.reverse(unknown, known, weights), weights @ expected
    assert (np.abs(received - wanted) <= 1e-10 * len(unknown) * scale).all()


def test_derivatives_are_slopes_of_values_at_states_that_were_set(exported):
    """States, inputs and parameters are set by value references while the importer integrates."""
    _, unit, _, outputs = exported
    unknown, known = unknown_and_known(unit, outputs)
    rng = np.random.default_rng(2)
    values = unit.get(known) * rng.uniform(1.01, 1.02, len(known)) + 1e-3
    unit.set(dict(zip(known, values.tolist(), strict=True)))
    np.testing.assert_array_equal(unit.get(known), values)
    found, slopes = unit.jacobian(unknown, known), []
    for name, value in zip(known, values.tolist(), strict=True):
        step = 1e-5 * max(abs(value), 1e-2)
        sides = []
        for side in (value + step, value - step):
            unit.set({name: side})
            sides.append(unit.get(unknown))
        unit.set({name: value})
        slopes.append((sides[0] - sides[1]) / (2 * step))
    size = np.abs(found).max(axis=0) + np.abs(unit.get(unknown)).max() * 1e-3
    error = (np.abs(found - np.array(slopes).T) / size).max()
    print(f"{error:.1e}")
    assert error < 1e-6


def test_an_acceleration_falls_with_its_inertia(tmp_path):
    """The load takes (torque / J): d a / d J = -a / J; the drive at t = 0 in any motion."""
    path = tmp_path / "drive.fmu"
    lp.export_fmu(lp.assemble(Drive()), path, inputs=["motor.tau"])
    unit = Exchanged(path).integrate()
    unit.set({"wheel.phi_rel": 0.01})
    (slope,) = unit.forward(["der(load.w)"], ["load.J"], [3.0])
    acceleration = unit.get(["der(load.w)"])[0]
    assert acceleration != 0
    assert slope == pytest.approx(-3.0 * acceleration / 2.0, rel=1e-13)
    assert unit.forward(["der(rotor.w)"], ["motor.tau"], [1.0])[0] == pytest.approx(2.0, rel=1e-13)
    for unknown, known, text in (
        ("der(load.w)", "ratio", "no derivatives by ratio: it is fixed"),
        ("load.J", "rotor.w", "no derivatives of the variable"),
        ("der(load.w)", "der(load.w)", "no derivatives by the variable"),
    ):
        with pytest.raises(fmpy.fmi1.FMICallException):
            unit.forward([unknown], [known], [1.0])
        assert text in unit.told[-1]
    unit.close()
    begun = Exchanged(path)
    with pytest.raises(fmpy.fmi1.FMICallException):
        begun.forward(["der(load.w)"], ["load.w"], [1.0])
    assert "by the start of load.w: it follows from others" in begun.told[-1]
    begun.close()


# -- what depends on what ----------------------------------------------------------------------


def listed(unit, group):
    return {u.variable.name: [v.name for v in u.dependencies] for u in getattr(unit.facts, group)}


def effects(path, unknown, known):
    """Which unknown values at the start change with each known one."""
    base = Exchanged(path)
    before, values = base.get(unknown), base.get(known)
    base.close()
    found = {name: set() for name in unknown}
    for name, value in zip(known, values.tolist(), strict=True):
        unit = Exchanged(path, {name: 1.25 * value + (0.01 if value == 0 else 0.0)})
        after = unit.get(unknown)
        for key, was, now in zip(unknown, before.tolist(), after.tolist(), strict=True):
            if abs(now - was) > 1e-9 * max(abs(was), 1.0):
                found[key].add(name)
        unit.close()
    return found


@pytest.mark.parametrize(
    ("model", "version", "outputs"),
    [(Drive(), "2.0", ["wheel.tau"]), (LIMITED, "3.0", ["limiter.y"])],
    ids=("drive", "limited"),
)
def test_a_start_depends_on_what_is_listed(tmp_path, model, version, outputs):
    """Nothing else changes a value, and not everything is listed."""
    path = tmp_path / "unit.fmu"
    options = {"version": version, "kind": "model_exchange"}
    lp.export_fmu(lp.assemble(model), path, outputs=outputs, **options)
    unit = Exchanged(path)
    said = listed(unit, "initialUnknowns")
    known = [v.name for v in unit.facts.modelVariables if v.start is not None]
    unit.close()
    found = effects(path, list(said), known)
    for name, names in said.items():
        assert found[name] <= set(names)
    if version == "2.0":
        assert said["rotor.w"] == ["w_0"]
        twisted = {"load.J", "wheel.c", "wheel.d", "ratio", "w_0", "wheel.phi_rel", "pinion.w"} | {
            "wheel.phi_rel0"
        }
        assert set(said["der(load.w)"]) == twisted
    else:
        assert set(said["lag.x"]) == {"first.x", "limiter.y_min", "limiter.y_max", "lag.T"}


def kinds_of(unit):
    return {
        u.variable.name: dict(
            zip((v.name for v in u.dependencies), u.dependenciesKind, strict=True)
        )
        for u in (*unit.facts.outputs, *unit.facts.derivatives)
    }


def test_kinds_of_dependencies(tmp_path):
    """A constant factor, a parameter, one that conditions choose, and what is not linear."""

    class Kinds(lp.Component):
        g: lp.Param = lp.param("1", "factor", 2.0)
        x: lp.Var = lp.var("1", "state", start=1.0, state="always")
        z: lp.Var = lp.var("1", "state", start=1.0, state="always")
        y: lp.Var = lp.var("1", "three times")
        tuned: lp.Var = lp.var("1", "by a parameter")
        bent: lp.Var = lp.var("1", "steeper beyond one")
        square: lp.Var = lp.var("1", "not linear")
        late: lp.Var = lp.var("1", "with the time")

        def equations(self):
            yield lp.der(self.x) == -self.x
            yield lp.der(self.z) == self.x - self.z
            yield self.y == 3 * self.x
            yield self.tuned == self.g * self.x
            yield self.bent == where(self.z > 1.5, 2 * self.x, 3 * self.x)
            yield self.square == self.x**2
            yield self.late == self.x * lp.time

    path, names = tmp_path / "kinds.fmu", ["y", "tuned", "bent", "square", "late"]
    for version in VERSIONS:
        system = lp.assemble(lp.compose(k=Kinds()))
        lp.export_fmu(system, path, version=version, outputs=[f"k.{n}" for n in names])
        unit = Exchanged(path)
        found = kinds_of(unit)
        unit.close()
        assert found["k.y"] == {"k.x": "constant"}
        assert found["k.tuned"] == {"k.x": "tunable"}
        assert found["k.bent"] == {"k.x": "discrete", "k.z": "dependent"}
        assert found["k.square"] == {"k.x": "dependent"}
        assert found["k.late"] == {"k.x": "dependent", "time": "dependent"}
        assert found["der(k.z)"] == {"k.x": "constant", "k.z": "constant"}


# -- another client ----------------------------------------------------------------------------


@pytest.mark.parametrize("version", VERSIONS)
def test_the_dae_builder_of_casadi_evaluates_units_and_their_jacobians(tmp_path, version):
    model, inputs, outputs = MODELS["rough"]
    system = lp.assemble(model)
    lp.export_fmu(system, tmp_path / "x.fmu", version=version, inputs=inputs, outputs=outputs)
    with zipfile.ZipFile(tmp_path / "x.fmu") as archive:
        archive.extractall(tmp_path / "unit")
    builder = ca.DaeBuilder("unit", str(tmp_path / "unit"))
    assert (builder.x(), builder.u(), builder.y()) == (system.state_names, inputs, outputs)
    names = ["x", "u"], ["ode", "y"]
    function = builder.create("f", *names)
    # the C code of the unit against the functions of the system; the brake goes on slipping
    point = lp.start_point(system, start={"rotor.w": 3.5, "load.w": 1.5, "shaft.phi_rel": 0.02})
    given = point.x, point.theta[system.places(inputs)]
    rates, values = function(*given)
    evaluated = point.x, point.theta, point.time, point.settings
    np.testing.assert_allclose(rates.full(), system.rhs(*evaluated).full(), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(
        values.full(), system.function(outputs)(*evaluated).full(), rtol=1e-12, atol=1e-12
    )
    exact = lp.linearise(system, at=point, inputs=inputs, outputs=outputs)
    parts = [f"jac_{of}_{by}" for of in names[1] for by in names[0]]
    found = builder.create("j", names[0], parts)(*given)
    for matrix, expected in zip(found, (exact.A, exact.B, exact.C, exact.D), strict=True):
        assert np.abs(expected).max() > 0 or expected is exact.D
        np.testing.assert_allclose(matrix.full(), expected, rtol=1e-10, atol=1e-12)
