"""The graph of a system: parts, what joins them, and what the reduction made of it."""

import itertools

import networkx as nx
import numpy as np
import pytest
from rows import in_a_row, in_rows

import lumped as lp
from lumped.components import (
    AngleSensor,
    DCMotor,
    Fixed,
    FixedTemperature,
    Gain,
    Ground,
    HeatCapacitor,
    IdealGear,
    Inertia,
    Resistor,
    Spring,
    SpringDamper,
    ThermalConductor,
    Torque,
    VoltageSource,
)
from lumped.components.electric.thermal import Heated
from lumped.models import MACHINES, machine

SHAFT = "rotational flange"
UNITS = {"phi": "rad", "tau": "N.m"}


def edges(graph: nx.Graph) -> set[tuple[str, str, tuple[str, ...]]]:
    """Each part with a joint and the names of its ports there."""
    found = set()
    for a, b, ports in graph.edges(data="ports"):
        part, joint = (a, b) if graph.nodes[a]["bipartite"] == 0 else (b, a)
        found.add((part, joint, tuple(ports)))
    return found


def nodes(graph: nx.Graph, **wanted: object) -> set[str]:
    """Nodes with these attributes."""
    return {n for n, d in graph.nodes(data=True) if wanted.items() <= d.items()}


def drive() -> lp.System:
    """Motor, rotor, gear and wheel, a spring to the foundation."""
    return lp.assemble(
        in_a_row(
            motor=Torque(tau=2.0),
            rotor=Inertia(J=0.5),
            gear=IdealGear(ratio=-3.0),
            wheel=Inertia(J=4.0),
            spring=Spring(c=9.0),
            foundation=Fixed(),
        )
    )


def test_a_drive_has_a_part_for_each_component_and_a_joint_for_each_connection():
    graph = drive().graph()
    assert edges(graph) == {
        ("motor", "motor.flange", ("flange",)),
        ("rotor", "motor.flange", ("flange_a",)),
        ("rotor", "rotor.flange_b", ("flange_b",)),
        ("gear", "rotor.flange_b", ("flange_a",)),
        ("gear", "gear.flange_b", ("flange_b",)),
        ("wheel", "gear.flange_b", ("flange_a",)),
        ("wheel", "wheel.flange_b", ("flange_b",)),
        ("spring", "wheel.flange_b", ("flange_a",)),
        ("spring", "spring.flange_b", ("flange_b",)),
        ("foundation", "spring.flange_b", ("flange",)),
        ("motor", "motor.support", ("support",)),
        ("gear", "gear.support", ("support",)),
    }
    assert nodes(graph, still=True) == {"motor.support", "gear.support", "spring.flange_b"}
    assert graph.nodes["motor.flange"]["ports"] == ["motor.flange", "rotor.flange_a"]
    assert all(graph.nodes[n]["quantities"] == UNITS for n in nodes(graph, kind=SHAFT))
    assert graph.edges["gear", "gear.support"]["ports"] == {"support": "support"}
    rotor, motor = graph.nodes["rotor"], graph.nodes["motor"]
    assert (rotor["kind"], rotor["parameters"]) == ("Inertia", {"J": (0.5, "kg.m2")})
    assert rotor["quantities"] == {"phi": "rad", "w": "rad/s", "a": "rad/s2"}
    assert motor["parameters"] == {"tau": (2.0, "N.m")}


def test_after_the_reduction_what_moves_as_one_is_one_joint():
    system = drive()
    graph = system.graph(reduced=True)
    assert edges(graph) == {
        ("motor", "rotor.phi", ("flange",)),
        ("rotor", "rotor.phi", ("flange_a", "flange_b")),
        ("gear", "rotor.phi", ("flange_a",)),
        ("gear", "wheel.phi", ("flange_b",)),
        ("wheel", "wheel.phi", ("flange_a", "flange_b")),
        ("spring", "wheel.phi", ("flange_a",)),
        ("motor", f"ground ({SHAFT})", ("support",)),
        ("gear", f"ground ({SHAFT})", ("support",)),
        ("spring", f"ground ({SHAFT})", ("flange_b",)),
        ("foundation", f"ground ({SHAFT})", ("flange",)),
    }
    stated = [n for name in ("rotor.phi", "wheel.phi") for n in graph.nodes[name]["states"]]
    own = [name for _, found in graph.nodes(data="states") for name in found]
    assert set(own) == {*system.state_names} >= {*stated}
    assert graph.nodes[f"ground ({SHAFT})"]["states"] == ()


def test_what_was_left_out_stands_at_its_part_with_the_reason():
    model = in_a_row(rotor=Inertia(J=1.0), shaft=SpringDamper(c=2.0, d=0.1), tool=Inertia(J=3.0))
    free = lp.assemble(model).graph()
    (lost,) = (d["left_out"] for n, d in free.nodes(data=True) if d.get("left_out"))
    assert [*lost.values()] == ["cyclic coordinate: nothing depends on it"]
    asked = lp.assemble(model, of=["shaft.phi_rel"])
    received = {**asked.graph().nodes["rotor"]["left_out"]}
    received |= asked.graph().nodes["tool"]["left_out"]
    expected = {item.what: item.why for item in asked.left_out if "." in item.what}
    assert received == expected
    assert asked.graph().graph["left_out"] == tuple(asked.left_out)


class Stage(lp.Component):
    """Two bodies and a spring; the second body is reached from outside."""

    a = lp.Flange()
    body: tuple[lp.Component, ...] = (Inertia(J=1.0), Inertia(J=2.0))
    spring: Spring = Spring(c=5.0)

    def connections(self):
        yield lp.connect(self.a, self.body[0].flange_a)
        yield from lp.chain(self.body[0], self.spring, self.body[1])


class Nested(lp.Component):
    """A stage in a stage, with flanges at both ends."""

    a = lp.Flange()
    b = lp.Flange(free=True)
    stage: Stage = Stage()
    end: Inertia = Inertia(J=3.0)

    def connections(self):
        yield lp.connect(self.a, self.stage.a)
        yield lp.connect(self.end.flange_b, self.b)


class Wheel(lp.Component):
    """An inertia of its own and one inside, which only a formula knows."""

    a = lp.Flange()
    J: lp.Param = lp.param("kg.m2", "inertia")
    free: Inertia = Inertia(J=1.0)

    def equations(self):
        yield self.a.tau == self.J * lp.der(lp.der(self.a.phi))


def test_composites_are_seen_through_unless_they_act_themselves():
    model = in_rows(
        "motor nested.a wheel.a", motor=Torque(tau=1.0), nested=Nested(), wheel=Wheel(J=2.0)
    )
    graph = lp.assemble(model).graph()
    assert nodes(graph, bipartite=0) == {
        *("motor", "nested.stage.body[0]", "nested.stage.body[1]", "nested.stage.spring"),
        *("nested.end", "wheel", "wheel.free"),
    }
    assert set(graph["motor.flange"]) == {"motor", "nested.stage.body[0]", "wheel"}
    ports = ["motor.flange", "nested.stage.body[0].flange_a", "wheel.a"]
    assert sorted(graph.nodes["motor.flange"]["ports"]) == ports
    assert set(graph.nodes["nested.end.flange_b"]["ports"]) == {"nested.end.flange_b", "nested.b"}
    assert set(graph["wheel"]) == {"motor.flange"}
    assert nx.node_connected_component(graph, "wheel.free") == {
        "wheel.free",
        "wheel.free.flange_a",
        "wheel.free.flange_b",
    }
    shallow = lp.assemble(model).graph(depth=1)
    assert edges(shallow) == {
        ("motor", "motor.flange", ("flange",)),
        ("motor", "motor.support", ("support",)),
        ("nested", "motor.flange", ("a",)),
        ("nested", "nested.b", ("b",)),
        ("wheel", "motor.flange", ("a",)),
    }
    middle = lp.assemble(model).graph(depth=2)
    assert set(middle["motor.flange"]) == {"motor", "nested.stage", "wheel"}


class Filtered(lp.Component):
    """A rotor whose speed the model itself filters."""

    rotor: Inertia = Inertia(J=1.0)
    w: lp.Var = lp.var("rad/s", "filtered speed")

    def equations(self):
        yield lp.der(self.w) == 5.0 * (self.rotor.w - self.w)


def test_a_model_with_states_of_its_own_is_a_part_without_joints():
    graph = lp.assemble(Filtered()).graph()
    assert graph.nodes[""]["states"] == ("w",)
    assert graph.nodes[""]["kind"] == "Filtered"
    assert not graph[""]


class HotResistor(Heated, Resistor):
    """Resistor that warms what is joined to it."""

    def loss(self):
        return self.v * self.i


def test_circuits_heat_and_signals_are_joined_beside_shafts():
    model = in_rows(
        "battery.p wire.p",
        "wire.n motor.p",
        "motor.n battery.n earth.pin",
        "motor.flange rotor",
        "wire.heat body.port path.port_a",
        "path.port_b air.port",
        battery=VoltageSource(v=24.0),
        wire=HotResistor(R=0.5),
        motor=DCMotor(k=0.1, R=1.0, L=1e-3, J=1e-4),
        earth=Ground(),
        rotor=Inertia(J=0.01),
        body=HeatCapacitor(C=50.0),
        path=ThermalConductor(G=0.2),
        air=FixedTemperature(),
    )
    graph = lp.assemble(model).graph()
    expected = {
        "electrical pin": [{"battery", "wire"}, {"wire", "motor"}, {"motor", "battery", "earth"}],
        "thermal port": [{"wire", "body", "path"}, {"path", "air"}],
    }
    for kind, sets in expected.items():
        received = [set(graph[n]) for n in nodes(graph, kind=kind)]
        assert sorted(map(sorted, received)) == sorted(map(sorted, sets))
    assert nodes(graph, kind="electrical pin", still=True) == {"battery.n"}
    assert not nodes(graph, kind="thermal port", still=True)  # heat flows into the air
    assert graph.nodes["battery.p"]["quantities"] == {"v": "V", "i": "A"}
    assert graph.nodes["path.port_b"]["quantities"] == {"T": "K", "Q": "W"}
    assert nx.has_path(graph, "battery", "rotor")


def test_signals_say_who_gives_and_who_takes():
    model = in_rows(
        "rotor sensor.flange",
        "sensor.phi gain.u",
        rotor=Inertia(J=1.0),
        sensor=AngleSensor(),
        gain=Gain(k=2.0),
    )
    graph = lp.assemble(model).graph()
    (joint,) = nodes(graph, kind="signal")
    received = {part: graph.edges[part, joint]["ports"] for part in graph[joint]}
    assert received == {"sensor": {"phi": "out"}, "gain": {"u": "in"}}
    assert graph.nodes[joint]["still"] is False
    assert nodes(lp.assemble(model).graph(reduced=True), kind="signal") == {joint}


@pytest.mark.parametrize("seed", range(12))
def test_joints_and_loops_are_those_of_the_incidence_matrix(seed: int):
    rng = np.random.default_rng(seed)
    bodies, springs = int(rng.integers(3, 12)), int(rng.integers(3, 20))
    ends = rng.integers(0, bodies, (springs, 2))
    ends = ends[ends[:, 0] != ends[:, 1]]

    def connections(m):
        for spring, (a, b) in zip(m.spring, ends, strict=True):
            yield lp.connect(spring.flange_a, m.body[a].flange_b)
            yield lp.connect(spring.flange_b, m.body[b].flange_b)

    graph = lp.assemble(
        lp.compose(
            body=[Inertia(J=1.0) for _ in range(bodies)],
            spring=[Spring(c=1.0) for _ in ends],
            connections=connections,
        )
    ).graph()
    B = np.zeros((len(ends), bodies))
    B[np.arange(len(ends)), ends[:, 0]], B[np.arange(len(ends)), ends[:, 1]] = 1.0, -1.0
    rank = int(np.linalg.matrix_rank(B))
    assert len(nx.cycle_basis(graph)) == len(ends) - rank
    assert nx.number_connected_components(graph) == bodies - rank
    for number in range(bodies):
        (joint,) = set(graph[f"body[{number}]"]) - {f"body[{number}].flange_a"}
        expected = {f"spring[{s}]" for s in np.flatnonzero((ends == number).any(axis=1))}
        assert set(graph[joint]) == expected | {f"body[{number}]"}


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("reduced", [False, True])
def test_graphs_of_machines_are_bipartite_and_have_every_part_and_state(name: str, reduced: bool):
    system = lp.assemble(machine(name).model())
    graph = system.graph(reduced=reduced)
    parts = nodes(graph, bipartite=0)
    assert nx.bipartite.is_bipartite_node_set(graph, parts)
    joints = set(graph) - parts
    assert all((a in parts) != (b in parts) for a, b in graph.edges)
    leaves = {node.path for node in system.structure.tree.instances if not node.children}
    assert leaves <= parts
    owned = itertools.chain(*(graph.nodes[n]["states"] for n in parts))
    assert sorted(owned) == sorted(system.state_names)
    ports = [p for n in joints for p in graph.nodes[n]["ports"]]
    assert len(ports) == len(set(ports))
    loops = graph.number_of_edges() - len(graph) + nx.number_connected_components(graph)
    assert len(nx.cycle_basis(graph)) == loops
