"""Whatever lumped gives can be pickled and copied, and the copy gives the same numbers."""

import copy
import dataclasses
import functools
import pickle
import re
import types

import casadi as ca
import numpy as np
import pytest
from public_names import CLASSES
from rows import in_a_row, in_rows

import lumped as lp
from lumped import functionals as fun
from lumped.components import (
    BearingFriction,
    Damper,
    Fixed,
    HarmonicTorque,
    Inertia,
    Position,
    Solid,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.errors import LumpedError
from lumped.ops import sin, where


class Rotor(lp.Component):
    """A rotor under a torque that falls with the speed and depends on the angle."""

    J = lp.param("kg.m2", "inertia", 1.0, above=0)
    phi = lp.var("rad", "angle")
    w = lp.var("rad/s", "speed", 3.0, state="prefer")

    def equations(self):
        yield lp.der(self.phi) == self.w
        yield self.J * lp.der(self.w) == 4.0 - self.w + sin(self.phi)


class Swinging(lp.Component):
    """A hardening spring and a force that repeats."""

    n = lp.param("rad/s", "frequency of the force", 0.9, above=0)
    x = lp.var("1", "deflection")
    v = lp.var("1/s", "speed")

    def equations(self):
        yield lp.der(self.x) == self.v
        force = 0.3 * sin(self.n * lp.time)
        yield lp.der(self.v) == force - 0.1 * self.v - self.x - self.x**3


class Drive(lp.Component):
    """Two bodies on a shaft, one held by dry friction, under a torque that jumps."""

    c: lp.Param = lp.param("N.m/rad", "stiffness", 300.0, above=0)
    motor: Torque = Torque(tau=where(lp.time >= 0.3, -2.0, 5.0))
    a: Inertia = Inertia(J=2.0, w=1.0)
    shaft: SpringDamper = SpringDamper(c=c, d=0.5)
    b: Inertia = Inertia(J=1.0)
    rub: BearingFriction = BearingFriction(characteristic=((0.0, 1.0), (2.0, 0.5)))

    def connections(self):
        yield from lp.chain(self.motor, self.a, self.shaft, self.b, self.rub)


def turning():
    """A rotor under a torque that repeats twice a turn, which a free load balances."""
    return in_rows(
        "gas load.flange rotor.flange_a oil ground",
        rotor=Inertia(J=2.0),
        gas=HarmonicTorque(harmonics=((2, 3.0, 0.0),), mean=40.0),
        load=Torque(tau=-40.0),
        oil=Damper(d=0.1),
        ground=Fixed(),
    )


def composed():
    """A model of a class that no other process can import, with connections by a lambda."""
    return lp.compose(
        drive=Position(phi=0.4 * sin(5.0 * lp.time)),
        body=Inertia(J=2.0),
        spring=Spring(c=10.0),
        oil=Damper(d=3.0),
        ground=Fixed(),
        connections=lambda m: [
            lp.connect(m.drive.flange, m.body.flange_a, m.spring.flange_a, m.oil.flange_a),
            lp.connect(m.spring.flange_b, m.oil.flange_b, m.ground.flange),
        ],
    )


def linear():
    return in_a_row(
        motor=Torque(tau=0),
        a=Inertia(J=2.0),
        shaft=SpringDamper(c=300.0, d=0.5),
        b=Inertia(J=1.0),
        wheel=SpringDamper(c=30.0, d=0.1),
        ground=Fixed(),
    )


@functools.cache
def made():
    """One of each class of results, by the name of the class."""
    system = lp.assemble(linear())
    run = lp.simulate(lp.assemble(Drive()), until=0.6, certify=True)
    modes = lp.modes(system)
    point = lp.equilibrium(system)
    response = lp.frequency_response(
        system, inputs=["motor.tau"], outputs=["b.w"], hertz=np.linspace(1.0, 5.0, 7)
    )
    orders = lp.vibration.order_response(
        system, speeds=[5.0, 8.0], of=["shaft.tau"], excitations={"motor.tau": {1: 2.0, 2: 1j}}
    )
    turned_by_gas = lp.assemble(turning(), keep=["rotor.phi"])
    vibrating = lp.vibration.order_response(
        turned_by_gas,
        speeds=[20.0, 21.0],
        of=["rotor.w"],
        shaft="rotor.phi",
        orders=[2],
        free="load.tau",
    )
    up = lp.simulate(turned_by_gas, until=10.0, grid=20_000, parameters={"load.tau": 0.0})
    masses = lp.vibration.mass_elastic(modes, shaft="a.phi")
    limit = lp.vibration.Limit("shaft.tau", 10.0)
    lines = lp.vibration.sine_triangle_lines(450.0)
    orbit = lp.periodic(lp.assemble(Rotor()), turn={"phi": 2 * np.pi}, warm_up=5.0)
    swings = lp.periodic(lp.assemble(Swinging()), period=2 * np.pi / 0.9, warm_up=300.0)
    branch = lp.orbits.branch(swings, along={"n": (0.9, 1.9)}, turns=1)
    shaken = lp.simulate(lp.assemble(composed()), until=2 * np.pi / 5, grid=40)
    pull, vary = fun.rms("drive.flange.tau"), {"spring.c": (1.0, 1000.0)}
    at_rest = lp.start_point(
        lp.assemble(in_a_row(motor=Torque(tau=0), load=Inertia(J=0.5)), keep=["load.phi"])
    )
    over = {"shaft.c": lp.normal(300.0, 20.0), "b.J": lp.normal(1.0, 0.05)}
    second = fun.frequency(1)
    spreads = lp.scatter(modes, over=over, of=[second], runs=64)
    expansion = lp.scatter(modes, over=over, of=[second], runs=64, search="chaos")
    failing = lp.reliability(modes, second, above="3.8 Hz", over=over)
    rarely = lp.probability(second, above="3.8 Hz", over=over) <= 0.01
    steady = lp.tolerances.mean_plus(second, 2.0, over=over)
    stiffness = {"wheel.c": (10.0, 100.0)}
    stiff = lp.optimise(modes, vary=stiffness, minimise={"wheel.c": -1.0}, subject_to=rarely)
    low = lp.optimise(modes, vary=stiffness, minimise=steady)
    t = np.linspace(0.0, 1.0, 21)
    seen = lp.simulate(system, until=1.0, grid=t, start={"a.w": 1.0})
    coupling = lp.life.Coupling("large", "20 N.m", 100.0)
    pair = lp.life.GearPair((20, 40), 0.002, 0.02)
    strength = lp.life.GearStrength(1e9, (4e8, 4e8), (2.8, 2.4), (1.55, 1.65))
    rating = lp.life.rate_gears(pair, {"peak": 10.0}, strength=strength)
    precision = lp.simulation.work_precision(system, until=0.1, tolerances=(1e-4, 1e-6))
    diagram = lp.campbell(system, speeds=[0.0, 10.0, 30.0], orders=[1, 2])
    turned = lp.inverse(system, motion={"a.w": sin(lp.time)}, drive="motor.tau", until=1.0)
    found = [
        Drive(),
        turned,
        run,
        run.certificate,
        run.events[0],
        run.statistics,
        run.statistics.methods[0],
        point,
        system,
        modes,
        lp.linearise(system, at=point),
        lp.vibration.natural_modes(
            lp.assemble(lp.compose(bar=Solid(d=0.1, L=1.0, continuous=True))), up_to=10.0
        ),
        lp.vibration.modal_energies(modes),
        lp.vibration.modal_energies(modes).nodes(1)[0],
        lp.vibration.participation(modes),
        lp.vibration.eigen_sensitivity(modes, by=["shaft.c"]),
        lp.vibration.shape_sensitivity(modes, of=["b.phi"], by=["shaft.c"]),
        response,
        response.peaks("b.w", "motor.tau")[0],
        lp.vibration.compare_response(
            response,
            output="b.w",
            input="motor.tau",
            hertz=response.hertz,
            measured=response["b.w", "motor.tau"],
        ),
        lp.exchange.UffCurve("time", t, t, "b.w", "NONE", 1, 4, 0, 0, "rad/s"),
        lp.exchange.UffShape(2.0, 0.1, (1,), np.ones((1, 3))),
        lp.exchange.UffFile((), (), ()),
        orders,
        orders.synthesis("shaft.tau"),
        lp.vibration.order_sensitivity(orders, "shaft.tau", by=["shaft.c"]),
        limit,
        lp.vibration.verdict(orders, [limit]),
        lp.vibration.BarredRange(3.0, 4.0),
        lp.vibration.OrderAmplitudes(
            system, *[orders.speeds] * 2, ("b.w",), np.ones((2, 2, 1)), orders.means
        ),
        lp.vibration.Linearity(20.0, "rotor.w", 2.0, 0.1, ("rotor.w",), {}),
        lp.vibration.order_tracks(up, "rotor.w", shaft="rotor.phi", most=4.0),
        lp.vibration.vector_sums(modes, {"a.phi": 0.0, "b.phi": 1.0}, orders=[1, 2]),
        masses,
        masses.inertias[0],
        masses.shafts[0],
        masses.holzer(0),
        lp.orbits.check_orders(vibrating, speeds=[20.0]),
        lp.orbits.periodic_range(turned_by_gas, speeds=[20.0], start=vibrating),
        lines[0],
        lp.vibration.line_crossings(lines, [15.6], speeds=[30.0, 190.0])[0],
        lp.vibration.EngineShaft(rated=75.0),
        lp.vibration.MarineShaft(d=0.3, tensile=6e8, rated=10.0),
        lp.vibration.response_sensitivity(response, by=["shaft.c"]),
        lp.points.equilibrium_sensitivity(point, of=["shaft.tau"], by=["motor.tau"]),
        lp.vibration.root_locus(system, along={"shaft.c": [100.0, 200.0]}),
        diagram,
        diagram.critical[0],
        orbit,
        branch,
        branch.points[0],
        orbit.sensitivity(of=["w"], by=["J"]),
        lp.orbits.flywheel(orbit, inertia="J", of="w", irregularity=0.02),
        lp.vibration.Order(1, 0.5, 0.1),
        lp.sensitivity(system, of=["b.w"], by=["shaft.c"], until=0.2, start={"a.w": 1.0}),
        lp.gradient(system, of=[fun.final("b.w")], by=["shaft.c"], until=0.2, start={"a.w": 1.0}),
        lp.gradients.gradient_ensemble(
            system, over={"shaft.c": [200.0, 400.0]}, of=[fun.final("b.w")], until=0.2
        ),
        lp.identify(
            system,
            vary={"shaft.c": (100, 500)},
            t=t,
            measured={"b.w": seen["b.w"]},
            start={"a.w": 1.0},
        ),
        lp.optimise(shaken, vary=vary, minimise=pull),
        lp.optimisation.pareto(shaken, vary=vary, minimise=(pull, fun.peak("spring.tau")), count=3),
        lp.optimisation.motion(
            at_rest,
            minimise=fun.rms("motor.tau"),
            stations={"load.phi": (0, 1)},
            duration=1.0,
            drive="motor.tau",
            intervals=6,
        ),
        spreads,
        *spreads.spreads.values(),
        *expansion.spreads.values(),
        spreads["frequency(1)"].quantile(0.5),
        spreads["frequency(1)"].share(above=3.5),
        lp.tolerances.sobol_indices(modes, over=over, of=[second], pairs=64),
        lp.tolerances.scene_of(modes, over=over, of=[second]),
        failing,
        *failing.points,
        rarely,
        rarely.of,
        steady,
        lp.tolerances.quantile(second, 0.9, over=over),
        *stiff.checks,
        *low.checks,
        lp.life.rainflow(seen["shaft.tau"]),
        curve := lp.life.SNCurve(knee=60e6, cycles=2e6, slope=5.0),
        lp.life.fit_sn_curve([(90e6, 1e5), (70e6, 5e5), (60e6, 9e5)]),
        lp.life.goodman("700 MPa"),
        case := lp.life.LoadCase(run, repetitions=3),
        lp.life.duty_cycle({"start": case}, of="shaft.tau", curve=curve),
        lp.life.load_spectrum(seen, ("shaft.tau", "b.w")),
        lp.life.Bearing(1e5, 1e5, e=0.3, Y_1=2.0, Y_2=3.0, Y_0=2.0),
        coupling,
        lp.life.choose_coupling([coupling], torque=10.0, speed=50.0),
        *(pair, lp.life.MeshStiffness(pair), strength, rating, rating["peak"]),
        small := lp.vibration.symbolic(system),
        small.K,
        lp.simulation.sizing(seen, of=("shaft.tau", "b.w")),
        lp.sweep(system, over={"shaft.c": [1.0]}, until=0.1, of={"x": last}, workers=1),
        precision,
        precision.rows[0],
        run._select(None),
        lp.exchange.ExportedFMU(*[None] * 7),
    ]
    return {type(one).__name__: one for one in found}


def last(run):
    return run["b.w"][-1]


LANGUAGE = {"Connection", "Equation", "Expr", "Flange", "HeatPort", "Input", "LinearFlange"}
LANGUAGE |= {"Output", "Param", "Pin", "Port", "Var", "Component"}
"""What models are written with."""


def test_no_class_of_results_is_forgotten():
    others = {"Explorer", "Spread"}  # a page that is served, and what spreads have in common
    others |= {"RunOptions"}  # types of arguments
    assert set(CLASSES) - LANGUAGE - others <= set(made())


def same(a, b):
    """Whether two values consist of the same numbers to the last bit."""
    if type(a) is not type(b):
        return False
    if isinstance(a, lp.System):
        return answers(a) == answers(b)
    if isinstance(a, lp.tolerances.Scene):
        return (
            a.values(a.draw(5, 0, "random")).tobytes() == b.values(b.draw(5, 0, "random")).tobytes()
        )
    if isinstance(a, lp.Component):
        return repr(a) == repr(b)
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if dataclasses.is_dataclass(a):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a))
    if isinstance(a, dict):
        return list(map(str, a)) == list(map(str, b)) and same([*a.values()], [*b.values()])
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, ca.Function):
        return a.serialize() == b.serialize()
    if isinstance(a, types.FunctionType):
        return a.__qualname__ == b.__qualname__
    if type(a).__repr__ is object.__repr__ and hasattr(a, "__dict__"):
        return same(vars(a), vars(b))
    return repr(a) == repr(b)


def answers(system):
    """Names, parameters and rates of a system at a point without symmetry."""
    inputs = [0.1 + np.arange(float(x.numel())) for x in system.inputs]
    rates = np.asarray(system.rhs(*inputs)).tobytes()
    return system.state_names, system.parameters, system.names(), rates


def test_what_answers_to_names_lists_them():
    for name in ("Trajectory", "OperatingPoint", "PeriodicOrbit", "Motion", "Saved"):
        one = made()[name]
        names = [*one]
        assert names, name
        assert all(np.isfinite(one[n]).all() for n in names[:3])
        assert names[0] in one
        assert "time" in one
        assert "nothing.such" not in one


def test_notebooks_show_all_results_that_print_a_table():
    printed = {name: repr(one) for name, one in made().items() if name != "ExportedFMU"}
    tables = [name for name, text in printed.items() if re.search(r"^-+  -", text, re.MULTILINE)]
    assert len(tables) > 35
    assert [name for name in tables if "<table" not in made()[name]._repr_html_()] == []


def test_results_complete_their_keys_and_every_completion_is_an_answer():
    for name, one in made().items():
        if not hasattr(one, "_ipython_key_completions_"):
            continue
        keys = one._ipython_key_completions_()
        assert keys, name
        for key in [keys[0], keys[-1]]:
            assert key in one, name
            assert np.size(one[key]) > 0, name
        if name != "Ensemble":
            assert len(one) == len([*one]), name


@pytest.mark.parametrize("name", ["Trajectory", "PeriodicOrbit", "Motion", "Saved", "Ensemble"])
def test_a_list_of_names_gives_columns(name):
    one = made()[name]
    names = [*one][:2]
    expected = np.stack([one[names[0]], one[names[1]]], axis=1)
    np.testing.assert_array_equal(one[names], expected)
    with pytest.raises(LumpedError, match="nothing"):
        one[[names[0], "nothing.such"]]


WAYS = {"pickle": lambda x: pickle.loads(pickle.dumps(x)), "deepcopy": copy.deepcopy}


@pytest.mark.parametrize("way", WAYS)
def test_all_copies_hold_the_same(way):
    for name, one in made().items():
        assert same(WAYS[way](one), one), name


def test_a_copy_of_a_system_is_assembled_when_it_is_used():
    twin = pickle.loads(pickle.dumps(lp.assemble(Drive())))
    assert list(vars(twin)) == ["_recipe"]
    twin = copy.deepcopy(pickle.loads(pickle.dumps(twin)))
    assert list(vars(twin)) == ["_recipe"]
    assert twin.name == "Drive"
    with pytest.raises(AttributeError, match="System has no 'state_name'"):
        twin.state_name  # noqa: B018
