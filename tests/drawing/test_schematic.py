"""Schematics show every component once, and wires that join what the model joins."""

import itertools
import xml.etree.ElementTree as ET
from collections import Counter
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from library_rigs import LIBRARY
from matplotlib.colors import to_rgba
from rows import in_a_row
from schematic_drives import DRIVES, long_chain

import lumped as lp
import lumped.components
from lumped.components import Fixed, Inertia, Spring
from lumped.drawing.netlist import netlist
from lumped.drawing.placing import place
from lumped.drawing.routing import Routed, route
from lumped.drawing.schematic import MARK
from lumped.drawing.symbols import SYMBOLS
from lumped.language.connection import label
from lumped.language.port import Port
from lumped.models import MACHINES, machine
from lumped.models.carrousel_coiler.turret import Turret
from lumped.models.reversing_mill.scenes import StripGap, TrimmedStand

SVG = "{http://www.w3.org/2000/svg}"
HALF = 0.2  # inch, within every symbol's cell


class Box(lp.Component):
    """Four shafts that come together."""

    a = lp.Flange(free=True)
    b = lp.Flange(free=True)
    c = lp.Flange(free=True)
    d = lp.Flange(free=True)


def random_net(seed: int) -> lp.Component:
    """Bodies joined at random by springs and boxes: loops, stars and separate parts."""
    rng = np.random.default_rng(seed)
    bodies, springs = int(rng.integers(3, 12)), int(rng.integers(3, 18))
    boxes = int(rng.integers(0, 8))
    ends = rng.integers(0, bodies + 1, (springs, 2))
    ends[0] = (bodies, 0)
    corners = rng.integers(0, bodies + 1, (boxes, 4))

    def connections(model):
        if boxes:
            flanges = [*(body.flange_b for body in model.bodies), model.ground.flange]
            for box, targets in zip(model.boxes, corners, strict=True):
                for own, target in zip((box.a, box.b, box.c, box.d), targets, strict=True):
                    yield lp.connect(own, flanges[target])
        flanges = [*(body.flange_b for body in model.bodies), model.ground.flange]
        for spring, (a, b) in zip(model.springs, ends, strict=True):
            yield lp.connect(spring.flange_a, flanges[a])
            yield lp.connect(spring.flange_b, flanges[b])

    return lp.compose(
        bodies=[Inertia(J=1.0) for _ in range(bodies)],
        springs=[Spring(c=1.0) for _ in range(springs)],
        ground=Fixed(),
        **({"boxes": [Box() for _ in range(boxes)]} if boxes else {}),
        connections=connections,
    )


MODELS = {
    **{name: machine(name).model() for name in MACHINES},
    "turret": Turret(),
    "trimmed mill": TrimmedStand(),
    **{f"random {seed}": random_net(seed) for seed in range(20)},
}


def every(model: lp.Component, path: str = ""):
    """Path and component of a model and of all its parts."""
    yield path, model
    for name, part in model._children():
        yield from every(part, f"{path}.{name}" if path else name)


def groups(pairs) -> list[frozenset]:
    """What is joined by pairs, directly or not."""
    home = {}
    for a, b in pairs:
        one, other = home.setdefault(a, {a}), home.setdefault(b, {b})
        if one is not other:
            one |= other
            home.update(dict.fromkeys(other, one))
    return [frozenset(g) for g in {id(g): g for g in home.values()}.values()]


def joined(model: lp.Component) -> set[frozenset[str]]:
    """Ports and signals of components without parts that meet, from the connections as written."""
    pairs, ends = [], {}
    for path, component in every(model):
        for name in component._ports:
            if component._parts:
                own = f"{path}.{name}" if path else name
                pairs.append(((own, True), (own, False)))
            else:
                ends[(f"{path}.{name}", False)] = f"{path}.{name}"
        for name in component._quantities:
            if not component._parts:
                ends[(f"{path}.{name}", False)] = f"{path}.{name}"
        for connection in component.connections():
            seen = [
                (label(end), isinstance(end, Port) and label(end).rpartition(".")[0] == path)
                for end in connection.ends
            ]
            pairs += itertools.pairwise(seen)
    found = ({ends[e] for e in group if e in ends} for group in groups(pairs))
    return {frozenset(g) for g in found if len(g) > 1}


def drawn(routed: Routed) -> set[frozenset[str]]:
    """Ports that are joined by lines on paper."""
    pairs = [pair for wire in routed.wires for pair in wire]
    names = {}
    for port, point in routed.ports:
        if port.net >= 0 and port.item.symbol != "port":
            names.setdefault(point, set()).add(f"{port.item.path}.{port.port}")
    found = (set().union(*(names.get(p, set()) for p in group)) for group in groups(pairs))
    return {frozenset(g) for g in found if len(g) > 1}


def routed_of(model: lp.Component, depth: int | None = None) -> Routed:
    plan = netlist(model, depth)
    return route(plan, place(plan), {})


@pytest.mark.parametrize("name", MODELS | DRIVES)
def test_lines_join_the_ports_that_the_model_joins(name: str):
    model = (MODELS | DRIVES)[name]
    assert drawn(routed_of(model)) == joined(model)


@pytest.mark.parametrize("name", MODELS)
def test_lines_of_different_nets_cross_but_never_lie_on_each_other(name: str):
    pieces = {0: {}, 1: {}}
    for net, wire in enumerate(routed_of(MODELS[name]).wires):
        for a, b in wire:
            axis = 0 if a[0] == b[0] else 1  # 0: vertical
            assert a[axis] == b[axis]
            low, high = sorted((a[1 - axis], b[1 - axis]))
            pieces[axis].setdefault(round(a[axis], 9), []).append((low, high, net))
    for at in (at for lines in pieces.values() for at in lines.values()):
        for (low, high, net), (lo, hi, other) in itertools.combinations(at, 2):
            assert net == other or high < lo or hi < low


@pytest.mark.parametrize("name", MODELS)
def test_no_line_runs_through_a_symbol(name: str):
    routed = routed_of(MODELS[name])
    for a, b in (piece for wire in routed.wires for piece in wire):
        for item, (x, y) in routed.centres.items():
            beside = max(a[0], b[0]) < x - HALF or min(a[0], b[0]) > x + HALF
            above = max(a[1], b[1]) < y - HALF or min(a[1], b[1]) > y + HALF
            assert beside or above, item.path


@pytest.mark.parametrize("name", MODELS)
def test_picture_names_every_component_once(name: str, tmp_path: Path):
    file = tmp_path / "model.svg"
    lp.schematic(MODELS[name], file)
    received = Counter(node.get("id") for node in ET.parse(file).iter() if node.get("id"))
    expected = [path for path, _ in every(MODELS[name]) if path]
    assert {path: received[path] for path in expected} == dict.fromkeys(expected, 1)


@pytest.mark.parametrize("name", [*MACHINES, "turret", "trimmed mill"])
def test_frames_hold_their_own_parts_only(name: str):
    routed = routed_of(MODELS[name])
    for frame, (x0, y0), (x1, y1) in routed.frames:
        within = {
            item.path for item, (x, y) in routed.centres.items() if x0 < x < x1 and y0 < y < y1
        }
        below = {item.path for item in routed.centres if item.path.startswith(f"{frame.path}.")}
        assert within == below


def test_collapsed_model_shows_its_parts_and_what_joins_them():
    plan = netlist(StripGap(), 1)
    assert {item.path for item in plan.top.all_items()} == {
        path for path, _ in every(StripGap()) if path and "." not in path
    }
    received = {frozenset(f"{item.path}.{port}" for item, port, _ in net.ends) for net in plan.nets}
    assert received == {
        frozenset({"lower.barrel", "ratio.flange_a", "lower_load.flange"}),
        frozenset({"ratio.flange_b", "gap.flange_a"}),
        frozenset({"gap.flange_b", "upper.barrel", "upper_load.flange"}),
    }


@pytest.mark.parametrize("seed", [10, 17, 19])
def test_wires_that_contradict_each_other_are_drawn_the_same_each_time(seed: int):
    first, *others = (routed_of(random_net(seed)).wires for _ in range(6))
    assert all(wires == first for wires in others)


def test_system_and_model_give_the_same_picture(tmp_path: Path):
    model = StripGap()
    for name, source in (("model", model), ("system", lp.assemble(model))):
        lp.schematic(source, tmp_path / f"{name}.svg")
    assert (tmp_path / "model.svg").read_bytes() == (tmp_path / "system.svg").read_bytes()


def test_every_component_of_the_library_has_a_symbol_or_the_box():
    assert [cls for cls in LIBRARY if cls.symbol not in SYMBOLS] == []


class Odd(Inertia):
    """An inertia with a slip."""

    symbol = "inertja"


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"model": lp.compose(body=Odd(J=1.0))}, r"body \(Odd\).*'inertja'.*inertia"),
        *(({"depth": depth}, "depth") for depth in (0, -1, 1.5)),
        ({"columns": 0}, "columns = 0"),
        ({"model": in_a_row(rotor=Inertia(J=1.0)), "mark": ["roter"]}, "mark = 'roter'.*rotor"),
        ({"path": "model.txt"}, "give an ending such as .svg or .png"),
    ],
)
def test_what_cannot_be_drawn_is_refused(options: dict, text: str):
    with pytest.raises(lp.errors.OptionError, match=text):
        lp.schematic(**({"model": Inertia(J=1.0)} | options))


@pytest.mark.parametrize(("count", "noted"), [(29, False), (31, True)])
def test_picture_of_more_than_sixty_symbols_says_so(count: int, noted: bool):
    figure = lp.schematic(long_chain(count + 1))
    texts = " ".join(text.get_text() for text in figure.axes[0].texts)
    assert (f"{2 * count + 1} symbols are more than" in texts) == noted


def test_values_stand_above_their_components_only():
    model = in_a_row(rotor=Inertia(J=3.0), other=Inertia(J=2.0))
    figure = lp.schematic(model, values={"rotor": "3 kg.m2 $x$", "nobody": "none"})
    shown = {t.get_text(): t.get_position() for axes in figure.axes for t in axes.texts}
    assert "none" not in shown
    value, name = shown[r"3 kg.m2 \$x\$"], shown["rotor"]
    assert value[0] == name[0]
    assert value[1] < name[1]  # the axis points down


def coloured(figure) -> list:
    return [p for p in figure.axes[0].patches if p.get_edgecolor() == to_rgba(MARK)]


def test_parts_and_joints_that_are_marked_stand_on_a_coloured_ground():
    model = in_a_row(rotor=Inertia(J=3.0), shaft=Spring(c=1.0), other=Inertia(J=2.0))
    way = nx.shortest_path(lp.assemble(model).graph(), "rotor", "shaft")
    figure = lp.schematic(model, mark=way)
    plain = lp.schematic(model)
    centres = {
        p.get_gid(): p.get_path().get_extents().get_points().mean(axis=0)
        for p in figure.axes[0].patches
        if p.get_gid() in {"rotor", "shaft", "other"}
    }
    grounds = [p.get_path().get_extents() for p in coloured(figure)]
    below = {n: sum(bool(g.contains(*c)) for g in grounds) for n, c in centres.items()}
    assert below == {"rotor": 1, "shaft": 1, "other": 0}
    assert len(grounds) == 3  # two parts and what joins them
    assert not coloured(plain)
    assert len(figure.axes[0].patches) == len(plain.axes[0].patches) + 3


@pytest.mark.parametrize("columns", [3, 5, 30])
def test_a_chain_turns_after_the_columns(columns: int):
    model = lp.compose(
        body=[Inertia(J=1.0) for _ in range(20)], connections=lambda m: lp.chain(*m.body)
    )
    cells = place(netlist(model), columns).cells.values()
    assert max(column for column, _ in cells) + 1 == min(columns, 20)
    rows = {row for _, row in cells}
    assert len(rows) == -(-20 // columns)
