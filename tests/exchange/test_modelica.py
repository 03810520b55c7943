"""Modelica text: read by an evaluator written here, and compiled and run by rumoca."""

import re

import numpy as np
import pytest
import specification_gear  # noqa: F401 - loads
from specification import build, read

import lumped as lp
from lumped.components import (
    BearingFriction,
    IdealGear,
    Inertia,
    QuadraticTorque,
    SpringDamper,
    Torque,
)
from lumped.errors import ExportError
from lumped.ops import where
from lumped.timeloop.instants import clocks, modes_at

TOKEN = re.compile(
    r"\s*('(?:[^'\\]|\\.)*'|\d+\.?\d*(?:e[+-]?\d+)?|[A-Za-z_]\w*|<=|>=|[-+*/^(),<>=;])"
)
FUNCTIONS = {
    "abs": abs,
    "atan2": np.arctan2,
    "cos": np.cos,
    "exp": np.exp,
    "max": max,
    "min": min,
    "sign": np.sign,
    "sin": np.sin,
    "sqrt": np.sqrt,
    "tanh": np.tanh,
}


class Reader:
    """Values of expressions by the grammar of the Modelica specification, section B.2.7."""

    def __init__(self, text, values):
        self.tokens, self.values = TOKEN.findall(text), values

    def take(self, *wanted):
        if self.tokens and self.tokens[0] in wanted:
            return self.tokens.pop(0)
        return None

    def whole(self):
        value = self.expression()
        assert not self.tokens, self.tokens
        return value

    def expression(self):
        if not self.take("if"):
            return self.disjunction()
        condition = self.expression()
        assert self.take("then")
        yes = self.expression()
        assert self.take("else")
        no = self.expression()
        assert isinstance(condition, bool | np.bool_)
        return yes if condition else no

    def disjunction(self):
        value = self.conjunction()
        while self.take("or"):
            other = self.conjunction()
            value = value or other
        return value

    def conjunction(self):
        value = self.negation()
        while self.take("and"):
            other = self.negation()
            value = value and other
        return value

    def negation(self):
        return not self.relation() if self.take("not") else self.relation()

    def relation(self):
        left = self.sum()
        sign = self.take("<", "<=", ">", ">=")
        if not sign:
            return left
        right = self.sum()
        return {"<": left < right, "<=": left <= right, ">": left > right, ">=": left >= right}[
            sign
        ]

    def sum(self):
        value = -self.product() if self.take("-") else self.product()
        while sign := self.take("+", "-"):
            other = self.product()
            value = value + other if sign == "+" else value - other
        return value

    def product(self):
        value = self.power()
        while sign := self.take("*", "/"):
            other = self.power()
            value = value * other if sign == "*" else value / other
        return value

    def power(self):
        base = self.atom()
        return base ** self.atom() if self.take("^") else base

    def atom(self):
        if self.take("("):
            value = self.expression()
            assert self.take(")")
            return value
        token = self.tokens.pop(0)
        if token in FUNCTIONS:
            assert self.take("(")
            given = [self.expression()]
            while self.take(","):
                given.append(self.expression())
            assert self.take(")")
            return FUNCTIONS[token](*given)
        return self.values[token] if token in self.values else float(token)


def sections(text):
    """Parameters with values, states with start texts, equations by their left sides."""
    head, body = text.split("\nequation\n")
    parameters = dict(re.findall(r"parameter Real ('.*?')\(.*?\) = (\S+) ", head))
    starts = dict(re.findall(r"\n  Real ('.*?')\(.*?start=(.*?), fixed=true", head))
    rows = body.split("\nend ")[0].split("\n  when ")[0].rstrip(";\n").split(";\n")
    equations = [tuple(row.strip().split(" = ", 1)) for row in rows]
    return parameters, starts, equations


def evaluated(text, states, time):
    """All quantities of a model at given states."""
    parameters, _, equations = sections(text)
    values = {"time": time, **{k: float(v) for k, v in parameters.items()}}
    values |= {f"'{k}'": v for k, v in states.items()}
    waiting = equations
    while waiting:
        late = []
        for left, right in waiting:
            try:
                values[left] = Reader(right, values).whole()
            except ValueError:  # a name that is not known yet
                late.append((left, right))
        assert len(late) < len(waiting), late
        waiting = late
    return values


class Drive(lp.Component):
    """Motor that is switched, two shafts, a gear and a fan."""

    w_0: lp.Param = lp.param("rad/s", "speed at the start", 2.0)
    motor: Torque = Torque(tau=where(lp.time >= 0.4, -5.0, where(lp.time >= 0.1, 40.0, 1.0)))
    rotor: Inertia = Inertia(J=0.5, w=3.0 * w_0)
    shaft: SpringDamper = SpringDamper(c=4000.0, d=2.0)
    pinion: Inertia = Inertia(J=0.3)
    gear: IdealGear = IdealGear(ratio=-3.0)
    wheel: SpringDamper = SpringDamper(c=9000.0, d=5.0)
    fan: Inertia = Inertia(J=2.0)
    air: QuadraticTorque = QuadraticTorque(tau_nominal=-30.0, w_nominal=10.0)
    load: Torque = Torque(tau=lp.ops.table([0.1, 0.3, 0.3, 0.5], [0.0, 2.0, 1.0, 4.0]))

    def connections(self):
        yield lp.connect(self.load.flange, self.fan.flange_b)
        parts = (self.rotor, self.shaft, self.pinion, self.gear, self.wheel, self.fan, self.air)
        yield from lp.chain(self.motor.flange, *parts)


def backlash():
    return lp.assemble(build(read("rot_backlash")))


@pytest.mark.parametrize("system", [lp.assemble(Drive()), backlash()], ids=["drive", "backlash"])
def test_equations_say_what_the_right_hand_side_computes(tmp_path, system):
    text = lp.export_modelica(system, tmp_path / "model.mo").read_text()
    rng = np.random.default_rng(1)
    theta = system.theta(None)
    for time in (0.05, 0.2, 0.7):
        for _ in range(20):
            x = rng.uniform(-1.5, 1.5, len(system.state_names))
            found = evaluated(text, dict(zip(system.state_names, x, strict=True)), time)
            point = lp.start_point(system, start=dict(zip(system.state_names, x, strict=True)))
            modes = point.settings.copy()
            timed = [mode for clock in clocks(system) for mode in clock.condition.modes]
            modes[timed] = modes_at(system, theta, time)[timed]
            expected = np.asarray(system.rhs(x, theta, time, modes)).ravel()
            got = [found[f"der('{name}')"] for name in system.state_names]
            assert np.allclose(got, expected, rtol=1e-12, atol=1e-12)


def test_start_values_follow_from_parameters(tmp_path):
    system = lp.assemble(Drive())
    text = lp.export_modelica(system, tmp_path / "model.mo").read_text()
    parameters, starts, _ = sections(text)
    assert starts["'rotor.w'"] == "3 * 'w_0'"
    assert parameters["'w_0'"] == "2.0"


def test_a_jump_becomes_a_reinit(tmp_path):
    class Clock(lp.Component):
        T: lp.Param = lp.param("s", "period", 0.3, above=0)
        n: lp.Var = lp.var("1", "count", state="always")
        t_next: lp.Var = lp.var("s", "next instant", state="always")

        def equations(self):
            yield lp.der(self.n) == 0
            yield lp.der(self.t_next) == 0
            changes = {self.n: self.n + 1, self.t_next: self.t_next + self.T}
            yield lp.when(lp.time > self.t_next, changes)

    system = lp.assemble(lp.compose(clock=Clock()))
    text = lp.export_modelica(system, tmp_path / "clock.mo").read_text()
    assert "  c1 = time > 'clock.t_next';" in text
    assert "  when c1 then\n" in text
    assert "    reinit('clock.n', ('clock.n' + 1));" in text


def test_what_holds_and_slides_is_refused_by_name(tmp_path):
    model = lp.compose(
        body=Inertia(J=1.0),
        bearing=BearingFriction(characteristic=((0, 1), (10, 2))),
        connections=lambda m: lp.chain(m.body, m.bearing),
    )
    with pytest.raises(ExportError, match=r"bearing can hold and slide.*export_fmu"):
        lp.export_modelica(lp.assemble(model), tmp_path / "model.mo")


@pytest.mark.parametrize("name", ["drive", "backlash"])
def test_another_tool_computes_the_same(tmp_path, name):
    rumoca = pytest.importorskip("rumoca")
    case = read("rot_backlash")
    system, start = (lp.assemble(Drive()), None) if name == "drive" else (backlash(), case.start)
    text = lp.export_modelica(system, tmp_path / "model.mo", start=start).read_text()
    model = rumoca.Session().loads(text, model=text.split()[1])
    config = rumoca.SimConfig(rtol=1e-10, atol=1e-13, solver="bdf")
    found = model.simulate((0.0, 0.9), config=config).to_dict()
    t, first = np.unique(found["time"], return_index=True)
    run = lp.simulate(system, until=0.9, start=start, grid=t, rtol=1e-11)
    instants = np.array([-1.0, *(event.time for event in run.events)])
    smooth = np.abs(t[:, None] - instants).min(axis=1) > 1e-6
    for state in system.state_names:
        received = np.array(found["data"][f"'{state}'"])[first]
        error = np.abs(received - run[state])[smooth].max() / np.abs(run[state]).max()
        print(f"{state}: {error:.1e}")
        assert error < 1e-6
