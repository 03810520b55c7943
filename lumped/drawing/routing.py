"""Wires of a schematic: vertical and horizontal runs in the channels between cells.

Every net gets its own lanes, so wires of different nets cross but never lie on each other.
Coordinates are coarse at first: channel ``c`` (before column or row ``c``) is ``2 c``, the cell
itself ``2 c + 1``, with an offset of at most half; inches follow when the lanes are counted.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from graphlib import CycleError, TopologicalSorter

from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

from lumped.drawing.netlist import Frame, Item, Netlist
from lumped.drawing.shaft_line import Placed
from lumped.drawing.terminals import Terminal, terminals

Point = tuple[float, float]

CELL = (0.62, 0.56)  # inch, of a symbol with its leads and without its label
LETTERS = 8.25  # points, 11 pixels on a page
LABEL, VALUE = 0.18, 0.13  # inch below the symbol, and above one with a value
ASIDE = 0.05  # inch between a wire and the label to its right
PITCH, BORDER, TITLE, GAP = 0.1, 0.08, 0.22, 0.09  # inch


@dataclass(eq=False)
class Routed:
    """A schematic in inches, y downwards.

    Attributes
    ----------
    centres : dict of Item to Point
        Centres of the symbols.
    ports : list of (Terminal, Point)
        Ports at the edge of their cells.
    wires : list of list of (Point, Point)
        Straight pieces of each net; they meet only at their ends.
    frames : list of (Frame, Point, Point)
        Top left and bottom right corners.
    size : Point
        Width and height.
    """

    centres: dict[Item, Point]
    ports: list[tuple[Terminal, Point]]
    wires: list[list[tuple[Point, Point]]]
    frames: list[tuple[Frame, Point, Point]]
    size: Point


@dataclass(eq=False)
class _Run:
    """A straight run of a net in a channel."""

    net: int
    marks: set[float]  # coarse places at which other runs or ports join it
    zone: int = 0
    lane: int = 0
    before: list[_Run] = field(default_factory=list)  # runs whose lanes come first

    @property
    def ends(self) -> tuple[float, float]:
        return min(self.marks), max(self.marks)


@dataclass(eq=False)
class _Plan:
    """Runs by channel and net, nets that are one straight line, and passes through empty cells."""

    columns: dict[tuple[int, int], _Run] = field(default_factory=dict)
    rows: dict[tuple[int, int], _Run] = field(default_factory=dict)
    straight: set[int] = field(default_factory=set)
    passes: list[tuple[int, int, int, float]] = field(default_factory=list)
    """Net, channel on the left and on the right, and coarse height."""


_Runs = dict[tuple[int, int], _Run]


def route(plan: Netlist, placed: Placed, values: Mapping[str, str]) -> Routed:
    """Wires of all nets, and the places of all items with values beside some of them."""
    ports = terminals(plan.nets, placed)
    for shift in range(len(ports) + 1):
        runs = _runs(plan, placed, ports)
        stuck = _order_lanes(runs, ports, placed)
        if stuck is None:
            break
        for port in ports:
            if port.item is stuck and not port.axis:
                port.offset += 0.11 / (shift + 1)
    zones = _Zones(plan, placed)
    x = _Axis(placed.width, runs.columns, zones, 0, _widths(placed, ports, values))
    heights = [CELL[1] + LABEL] * placed.height
    for item, (_, row) in placed.cells.items():
        if values.get(item.path):
            heights[row] = CELL[1] + LABEL + VALUE
    y = _Axis(placed.height, runs.rows, zones, 1, heights)
    return _draw_wires(plan, placed, ports, runs, (x, y), zones)


@cache
def measure_text(text: str) -> float:
    """Width of a text in the picture, inch."""
    font = FontProperties(size=LETTERS)
    return float(text_to_path.get_text_width_height_descent(text, font, ismath=False)[0]) / 72


def text_place(ports: Iterable[Terminal], side: str) -> tuple[float, bool]:
    """Inches from the centre of a symbol to the text above ("T") or below it ("B").

    The text is centred there, or begins there, to the right of the wires on that side: True.
    """
    wires = [port.offset for port in ports if port.side == side and port.net >= 0]
    return (CELL[0] * max(wires) + ASIDE, True) if wires else (0.0, False)


def _widths(placed: Placed, ports: list[Terminal], values: Mapping[str, str]) -> list[float]:
    ends: dict[Item, list[Terminal]] = {item: [] for item in placed.cells}
    for port in ports:
        ends[port.item].append(port)
    widths = [CELL[0]] * placed.width
    for item, (column, _) in placed.cells.items():
        below, above = measure_text(item.label), measure_text(values.get(item.path, ""))
        for side, length in (("B", below), ("T", above)):
            at, aside = text_place(ends[item], side)
            wide = 2 * (at + length) if aside and length else length
            widths[column] = max(widths[column], wide)
    return widths


def _coarse(port: Terminal, placed: Placed) -> tuple[int, float]:
    """Channel that a port faces, and its place along it."""
    cell = placed.cells[port.item]
    return cell[port.axis] + (port.side in "RB"), 2 * cell[1 - port.axis] + 1 + port.offset


def _runs(plan: Netlist, placed: Placed, ports: list[Terminal]) -> _Plan:
    """Runs of each net in vertical and in horizontal channels."""
    found = _Plan()
    columns, rows = found.columns, found.rows
    taken = set(placed.cells.values())
    upright: list[dict[int, set[float]]] = [defaultdict(set) for _ in plan.nets]
    flat: list[dict[int, set[float]]] = [defaultdict(set) for _ in plan.nets]
    for port in ports:
        if port.net >= 0:
            channel, place = _coarse(port, placed)
            (flat if port.axis else upright)[port.net][channel].add(place)
    for n, (across, along) in enumerate(zip(upright, flat, strict=True)):
        if not along and len(across) == 1:
            ((channel, marks),) = across.items()
            if len(marks) > 1:
                columns[channel, n] = _Run(n, marks)
            else:
                found.straight.add(n)
            continue
        if not across and len(along) == 1:
            ((channel, marks),) = along.items()
            rows[channel, n] = _Run(n, marks)
            continue
        if not along and _passes(n, across, taken, found):
            continue
        spine = _spine(across, along)
        rows[spine, n] = _Run(n, along.pop(spine, set()))
        for channel, marks in along.items():
            # to the spine by the vertical channel that is nearest to the first port
            first = min(marks)
            by = min(across, key=lambda c: abs(2 * c - first), default=int(first) // 2)
            marks.add(2.0 * by)
            rows[channel, n] = _Run(n, marks)
            across[by].add(2.0 * channel)
        for channel, marks in across.items():
            marks.add(2.0 * spine)
            columns[channel, n] = _Run(n, marks)
            rows[spine, n].marks.add(2.0 * channel)
    return found


def _passes(
    n: int, across: dict[int, set[float]], taken: set[tuple[int, int]], found: _Plan
) -> bool:
    """Join the vertical runs of a net straight through empty cells, if there are some."""
    steps: list[tuple[int, int, int, float]] = []
    cells: set[tuple[int, int]] = set()
    channels = sorted(across)
    for left, right in itertools.pairwise(channels):
        for mark in sorted(across[left] | across[right]):
            way = {(column, int(mark) // 2) for column in range(left, right)}
            if way.isdisjoint(taken) and way.isdisjoint(cells):
                break
        else:
            return False
        cells |= way
        steps.append((n, left, right, mark))
    taken |= cells
    for step in steps:
        across[step[1]].add(step[3])
        across[step[2]].add(step[3])
    found.passes += steps
    found.columns.update({(channel, n): _Run(n, across[channel]) for channel in channels})
    return True


def _spine(across: dict[int, set[float]], along: dict[int, set[float]]) -> int:
    """Horizontal channel that joins all vertical ones."""
    if along:
        return max(along, key=lambda c: (len(along[c]), -c))
    marks = sorted(mark for found in across.values() for mark in found)
    row = int(marks[len(marks) // 2]) // 2
    lowest = row == int(marks[-1]) // 2 > int(marks[0]) // 2
    return row if lowest else row + 1


def _order_lanes(runs: _Plan, ports: list[Terminal], placed: Placed) -> Item | None:
    """Note which lane must be left of which; if that is contradictory, give an item to move.

    Where ports of two nets face each other, the net from the left must turn first.
    """
    facing: dict[tuple[int, float], dict[str, tuple[int, Item | None]]] = defaultdict(dict)
    for n, left, right, mark in runs.passes:
        facing[left, mark]["L"] = facing[right, mark]["R"] = (n, None)
    for port in ports:
        if port.net >= 0 and not port.axis:
            facing[_coarse(port, placed)][port.side] = (port.net, port.item)
    between: dict[tuple[_Run, _Run], Item | None] = {}
    for (channel, _), pair in facing.items():
        if len(pair) == 2 and pair["L"][0] != pair["R"][0]:
            first, second = (runs.columns[channel, pair[side][0]] for side in "RL")
            second.before.append(first)
            between[first, second] = pair["L"][1] or pair["R"][1]
    try:
        TopologicalSorter({run: run.before for run in runs.columns.values()}).prepare()
    except CycleError as fault:
        return next(filter(None, map(between.get, itertools.pairwise(fault.args[1]))))
    return None


class _Zones:
    """On which side of the borders of frames a run stands."""

    def __init__(self, plan: Netlist, placed: Placed) -> None:
        self.area = {frame: (first, last) for frame, first, last in placed.frames}
        chains = [(chain[-1], chain[1:]) for chain in plan.top.chains()]  # the whole has no border
        above = {item: around for frame, around in chains for item in frame.items}
        self.depth = {frame: len(around) for frame, around in chains}
        self.common: list[list[Frame]] = []
        for net in plan.nets:
            levels = zip(*(above[item] for item, _, _ in net.ends), strict=False)
            self.common.append([frames[0] for frames in levels if len(set(frames)) == 1])
        self.borders: tuple[dict[int, set[float]], ...] = (defaultdict(set), defaultdict(set))
        for frame, (first, last) in self.area.items():
            depth = self.depth[frame]
            for axis in (0, 1):
                self.borders[axis][first[axis]].add(depth - 0.5)
                self.borders[axis][last[axis] + 1].add(0.5 - depth)

    def zone(self, net: int, axis: int, channel: int) -> int:
        """Depth of the border that encloses the net at a channel; negative at its far side."""
        for frame in reversed(self.common[net]):
            first, last = self.area[frame]
            if last[axis] + 1 == channel:
                return -self.depth[frame]
            if first[axis] == channel:
                return self.depth[frame]
        return 0


class _Axis:
    """Inches of cells, lanes and borders along one direction."""

    def __init__(
        self, count: int, runs: _Runs, zones: _Zones, axis: int, sizes: list[float]
    ) -> None:
        here: dict[int, list[_Run]] = defaultdict(list)
        for (channel, net), run in runs.items():
            run.zone = zones.zone(net, axis, channel)
            here[channel].append(run)
        self.lanes: dict[tuple[int, int, int], float] = {}
        self.borders: dict[tuple[int, float], float] = {}
        self.centres: list[float] = []
        at = 0.0
        for channel in range(count + 1):
            _assign(here[channel])
            marks: set[tuple[float, int]] = {(run.zone, run.lane) for run in here[channel]}
            marks |= {(zone, -1) for zone in zones.borders[axis][channel]}
            at += GAP
            for zone, lane in sorted(marks):
                if lane >= 0:
                    at += PITCH
                    self.lanes[channel, int(zone), lane] = at
                else:
                    at += BORDER
                    self.borders[channel, zone] = at
                    at += TITLE - BORDER if axis and zone > 0 else 0.0
            at += GAP
            if channel < count:
                below = LABEL if axis else 0.0
                own = CELL[axis] if axis else sizes[channel]
                self.centres.append(at + sizes[channel] - below - own / 2)
                at += sizes[channel]
        self.size = at

    def lane(self, channel: int, run: _Run) -> float:
        return self.lanes[channel, run.zone, run.lane]


def _assign(runs: list[_Run]) -> None:
    """Lanes of the runs in a channel: none touches another in its lane, and the order is kept."""
    order: TopologicalSorter[_Run] = TopologicalSorter()
    for run in sorted(runs, key=lambda r: (r.zone, r.ends)):
        order.add(run)
    for run in runs:
        order.add(run, *run.before)
    used: dict[int, list[list[tuple[float, float]]]] = defaultdict(list)
    for run in order.static_order():
        lanes = used[run.zone]
        low, high = run.ends
        lane = max((b.lane + 1 for b in run.before if b.zone == run.zone), default=0)
        while lane < len(lanes) and any(lo <= high and low <= hi for lo, hi in lanes[lane]):
            lane += 1
        lanes.extend([] for _ in range(lane + 1 - len(lanes)))
        lanes[lane].append((low, high))
        run.lane = lane


def _draw_wires(
    plan: Netlist,
    placed: Placed,
    ports: list[Terminal],
    runs: _Plan,
    axes: tuple[_Axis, _Axis],
    zones: _Zones,
) -> Routed:
    columns, rows = along = runs.columns, runs.rows
    x, y = axes
    centres = {item: (x.centres[c], y.centres[r]) for item, (c, r) in placed.cells.items()}
    wires: list[list[tuple[Point, Point]]] = [[] for _ in plan.nets]
    on: dict[_Run, set[float]] = defaultdict(set)  # places at which others join it, in inches
    places, facing = [], defaultdict(list)
    for port in ports:
        channel, _ = _coarse(port, placed)
        here = [*centres[port.item]]
        here[port.axis] += (-1 if port.side in "LT" else 1) * CELL[port.axis] / 2
        here[1 - port.axis] += port.offset * CELL[1 - port.axis]
        point = (here[0], here[1])
        places.append((port, point))
        run = along[port.axis].get((channel, port.net))
        if run is not None:
            here[port.axis] = axes[port.axis].lane(channel, run)
            wires[port.net].append((point, (here[0], here[1])))
            on[run].add(here[1 - port.axis])
        elif port.net in runs.straight:
            facing[port.net].append(point)
    for net, (first, second) in facing.items():
        wires[net].append((first, second))
    for (channel, net), run in columns.items():
        for row in {int(m) // 2 for m in run.marks if m == int(m) and int(m) % 2 == 0}:
            other = rows.get((row, net))
            if other is not None:
                on[run].add(y.lane(row, other))
                on[other].add(x.lane(channel, run))
    for n, left, right, mark in runs.passes:
        row = int(mark) // 2
        height = y.centres[row] + (mark - 2 * row - 1) * CELL[1]
        ends = [(x.lane(channel, columns[channel, n]), height) for channel in (left, right)]
        wires[n].append((ends[0], ends[1]))
        for channel in (left, right):
            on[columns[channel, n]].add(height)
    for group, axis in ((columns, x), (rows, y)):
        for (channel, net), run in group.items():
            at = axis.lane(channel, run)
            for a, b in itertools.pairwise(sorted(on[run])):
                wires[net].append(((at, a), (at, b)) if axis is x else ((a, at), (b, at)))
    corners = []
    for frame, first, last in placed.frames:
        side = zones.depth[frame] - 0.5
        begin = x.borders[first[0], side], y.borders[first[1], side]
        end = x.borders[last[0] + 1, -side], y.borders[last[1] + 1, -side]
        corners.append((frame, begin, end))
    return Routed(centres, places, wires, corners, (x.size, y.size))
