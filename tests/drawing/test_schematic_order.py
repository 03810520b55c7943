"""Schematics of many drives are in order: nothing mirrored, no loops, no text on another."""

import itertools
from collections import Counter
from functools import cache

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from rows import in_rows
from schematic_drives import BRANCHED, CHAINS, DRIVES
from test_schematic import routed_of

import lumped as lp
from lumped.components import Gain, IdealGear, Inertia, Sum
from lumped.drawing.netlist import Netlist, netlist
from lumped.drawing.part_values import part_texts
from lumped.drawing.placing import place
from lumped.drawing.routing import Routed, route
from lumped.drawing.schematic import draw
from lumped.drawing.shaft_line import MECHANICAL
from lumped.models import MACHINES, machine

VALUE = "1234.5 kN.m/rad, 67.8 N.m.s/rad"
RIGID = {"Inertia", "Mass", "MassWithStops"}  # parts that look the same from both sides
PLANAR = [name for name in BRANCHED if name != "linkage press"]


@cache
def routed(name: str) -> Routed:
    return routed_of(DRIVES[name])


def shaft_ports(picture: Routed) -> dict:
    """Sides of the shaft ports of each item with two of them, by their names."""
    found = {}
    for port, _ in picture.ports:
        if port.role == "line" and port.kind in MECHANICAL and port.side in "LR":
            found.setdefault(port.item, {})[port.port] = port.side
    return {item: sides for item, sides in found.items() if len(sides) == 2}


def reversed_parts(picture: Routed) -> list[str]:
    """Parts with their flange a on the right and their flange b on the left."""
    wrong = {"flange_a": "R", "flange_b": "L"}
    return [item.path for item, s in shaft_ports(picture).items() if s == wrong]


def corners(picture: Routed) -> int:
    """Points at which a wire turns without a branch."""
    count = 0
    for wires in picture.wires:
        at = {}
        for a, b in wires:
            if a != b:
                for point in (a, b):
                    at.setdefault(point, []).append(a[0] == b[0])
        count += sum(sorted(turns) == [False, True] for turns in at.values())
    return count


def crossings(picture: Routed) -> int:
    """Points at which a vertical piece of one net crosses a horizontal one of another."""
    upright, flat = [], []
    for n, wires in enumerate(picture.wires):
        for a, b in wires:
            axis = int(a[0] == b[0])
            low, high = sorted((a[axis], b[axis]))
            (upright if axis else flat).append((n, a[1 - axis], low, high))
    return sum(
        m != n and left < x < right and low < y < high
        for n, x, low, high in upright
        for m, y, left, right in flat
    )


@pytest.mark.parametrize("name", CHAINS)
def test_a_chain_is_one_straight_row_from_left_to_right(name: str):
    picture = routed(name)
    assert len({y for _, y in picture.centres.values()}) == 1
    assert corners(picture) == crossings(picture) == 0
    assert {tuple(sorted(s.items())) for s in shaft_ports(picture).values()} == {
        (("flange_a", "L"), ("flange_b", "R"))
    }


@pytest.mark.parametrize("name", DRIVES)
def test_no_part_is_mirrored(name: str):
    kinds = {item.path: item.kind for item in routed(name).centres}
    assert [path for path in reversed_parts(routed(name)) if kinds[path] not in RIGID] == []


@pytest.mark.parametrize("name", PLANAR)
def test_branches_do_not_cross(name: str):
    assert crossings(routed(name)) == 0


def test_a_folded_chain_turns_four_times_at_each_fold():
    assert corners(routed("folded chain")) == 4 * 2
    assert reversed_parts(routed("folded chain")) == []


@pytest.mark.parametrize("columns", [4, 6, 14])
@pytest.mark.parametrize("name", MACHINES)
def test_texts_of_machines_stand_clear(name: str, columns: int):
    system = lp.assemble(machine(name).model())
    values = part_texts(system, system.theta({}))
    plan = netlist(system)
    check_texts(plan, route(plan, place(plan, columns), values), values)


@pytest.mark.parametrize("name", DRIVES)
def test_texts_stand_clear_of_each_other_and_of_wires(name: str):
    plan = netlist(DRIVES[name])
    placed = place(plan)
    values = {item.path: VALUE for item in placed.cells if item.symbol != "port"}
    check_texts(plan, route(plan, placed, values), values)


def check_texts(plan: Netlist, picture: Routed, values: dict[str, str]) -> None:
    """Every text is there, 11 pixels high, within the picture, and nothing runs through it."""
    figure = draw(plan, picture, values)
    renderer = FigureCanvasAgg(figure).get_renderer()
    axes = figure.axes[0]
    boxes = []
    for text in axes.texts:
        box = text.get_window_extent(renderer).transformed(axes.transData.inverted())
        boxes.append((text.get_text(), box.x0, box.x1, box.y1, box.y0))  # y downwards
    shown = Counter(text for text, *_ in boxes)
    assert Counter(values.values()) <= shown
    assert min(text.get_fontsize() for text in axes.texts) >= 0.75 * 11
    left, right = axes.get_xlim()
    bottom, top = axes.get_ylim()
    for text, x0, x1, y0, y1 in boxes:
        assert left <= x0 < x1 <= right, text
        assert top <= y0 < y1 <= bottom, text
        for a, b in itertools.chain.from_iterable(picture.wires):
            beside = max(a[0], b[0]) <= x0 or min(a[0], b[0]) >= x1
            assert beside or max(a[1], b[1]) <= y0 or min(a[1], b[1]) >= y1, text
    for (one, a0, a1, b0, b1), (other, c0, c1, d0, d1) in itertools.combinations(boxes, 2):
        assert a1 <= c0 or c1 <= a0 or b1 <= d0 or d1 <= b0, (one, other)


def test_a_crankshaft_is_the_line_of_its_engine_and_not_the_oil_films_on_its_housing():
    heights = {item.path: y for item, (_, y) in routed("genset").centres.items()}
    throws = [f"engine.throw[{i}]" for i in range(6)] + [f"engine.shaft[{i}]" for i in range(5)]
    assert len({heights[path] for path in throws}) == 1


def test_signals_run_to_the_right_through_their_blocks():
    model = in_rows(
        "first.y second.u last.a",
        "second.y third.u",
        "third.y last.b",
        last=Sum(),
        second=Gain(k=2.0),
        third=Gain(k=3.0),
        first=Gain(k=1.0, u=1.0),
    )
    plan = netlist(model)
    columns = {item.path: column for item, (column, _) in place(plan).cells.items()}
    assert columns == {"first": 0, "second": 1, "third": 2, "last": 3}


def test_a_part_joined_against_its_chain_is_the_only_one_turned():
    model = in_rows(
        "motor gear",
        "gear.flange_b turned.flange_b",
        "turned.flange_a load.flange_a",
        motor=Inertia(),
        gear=IdealGear(),
        turned=IdealGear(),
        load=Inertia(),
    )
    plan = netlist(model)
    picture = route(plan, place(plan), {})
    assert reversed_parts(picture) == ["turned"]
    assert len({y for _, y in picture.centres.values()}) == 1
