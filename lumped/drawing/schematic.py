"""A model as a drive-train schematic."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Set
from pathlib import Path
from typing import Literal

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from matplotlib.text import Text

from lumped.compiler.system import System
from lumped.drawing.netlist import SIGNAL, Item, Netlist, netlist
from lumped.drawing.placing import WIDEST, place
from lumped.drawing.routing import CELL, LETTERS, Point, Routed, measure_text, route, text_place
from lumped.drawing.strokes import Symbol
from lumped.drawing.symbols import GROUND, SYMBOLS
from lumped.drawing.terminals import Terminal
from lumped.errors import OptionError, nearest
from lumped.language.component import Component
from lumped.plots.matplotlib_figure import NotebookFigure, plain_text
from lumped.support.arguments import checked

READABLE = 60  # symbols
SCALE = 0.25  # inch, half of a symbol
MARGIN = 0.12  # inch
HEAD, FOOT = 0.34, 0.26  # inch
STYLES = {  # colour, width in points, name in the legend
    "rotational flange": ("black", 1.5, "shaft"),
    "translational flange": ("#8a4b08", 1.5, "straight motion"),
    "electrical pin": ("#1f4fd8", 0.8, "electrical"),
    "thermal port": ("#c4261d", 0.8, "heat"),
    SIGNAL: ("#2b7a3d", 0.7, "signal"),
}
OTHER = ("#5b2a86", 1.0, "other")
MARK = "#ffd166"
Ends = list[tuple[Terminal, Point]]
"""Ports of a symbol, and where they are."""


@checked
def schematic(
    model: Component | System,
    path: str | Path | None = None,
    *,
    depth: int | None = None,
    columns: int = WIDEST,
    values: Mapping[str, str] | None = None,
    mark: Iterable[str] = (),
) -> Figure:
    """Drive-train schematic: symbols along the shaft line, frames around composites.

    The longest chain of parts runs from left to right, and continues below if it is long. Branches
    stand above and below it. Signals are thin lines with arrows, electrical wires thin lines.

    Parameters
    ----------
    model : Component or System
        Model to draw.
    path : str or Path, optional
        File to write: .svg, .png, .pdf.
    depth : int, optional
        Composites at this depth are drawn as one symbol; 1 shows the parts of the model only.
    columns : int
        Parts side by side before a chain is continued below.
    values : mapping of str to str, optional
        Texts above symbols, by the paths of their components, such as ``{"rotor": "3 kg.m2"}``.
    mark : iterable of str, optional
        Parts and ports to stand out, the latter with all that is joined there; a path in
        ``system.graph()``, for example.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    OptionError
        If the depth or the number of columns is less than 1, a component names a symbol that does
        not exist, what is to be marked is not in the picture, or the ending of the path is no
        format of pictures.
    ConnectError
        If connections are faulty.
    """
    if depth is not None and not (isinstance(depth, int) and depth >= 1):
        raise OptionError(
            f"schematic: depth = {depth!r}; 1 shows the parts of the model, 2 theirs too."
        )
    if columns < 1:
        raise OptionError(f"schematic: columns = {columns}; at least one part stands in a row.")
    plan = find_parts(model, depth)
    values = values or {}
    figure = draw(plan, route(plan, place(plan, columns), values), values, _find(plan, mark))
    if path is not None:
        ending = Path(path).suffix.removeprefix(".")
        if ending not in figure.canvas.get_supported_filetypes():
            raise OptionError(
                f"schematic: path = {str(path)!r}: give an ending such as .svg or .png."
            )
        undated = {"Date": None} if ending.lower() == "svg" else None
        with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": plan.name}):
            figure.savefig(path, dpi=100, metadata=undated)
    return figure


def find_parts(model: Component | System, depth: int | None) -> Netlist:
    """What is to be drawn.

    Raises
    ------
    OptionError
        If there is no symbol for something.
    """
    plan = netlist(model, depth)
    for item in plan.top.all_items():
        if item.symbol not in SYMBOLS:
            raise OptionError(
                f"{item.path or item.label} ({item.kind}): there is no symbol '{item.symbol}'. "
                f"Known: {', '.join(SYMBOLS)}."
            )
    return plan


def _find(plan: Netlist, mark: Iterable[str]) -> set[str]:
    """Names that are marked, all of them in the picture."""
    items, marked = list(plan.top.all_items()), set(mark)
    known = {item.path for item in items} | {_name(i, port) for i in items for port in i.ports}
    known |= {_name(item, port) for net in plan.nets for item, port, _ in net.ends}
    for name in sorted(marked - known):
        raise OptionError(f"schematic: mark = '{name}' is not shown. {nearest(name, known)}")
    return marked


def draw(
    plan: Netlist, routed: Routed, values: Mapping[str, str], marked: Set[str] = frozenset()
) -> Figure:
    """Draw the items with their values, and the wires; what is marked on a coloured ground."""
    width = max(routed.size[0] + 2 * MARGIN, 3.2)
    height = routed.size[1] + HEAD + FOOT
    figure = NotebookFigure((width, height))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-MARGIN, width - MARGIN), ylim=(routed.size[1] + FOOT, -HEAD))
    axes.axis("off")
    for frame, (x0, y0), (x1, y1) in routed.frames:
        _path(axes, [[(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]], "#8a94a0", 0.7, 1)
        axes.patches[-1].set_gid(frame.path)
        axes.text(x0 + 0.04, y0 + 0.03, frame.label, size=LETTERS, va="top", color="#4a5560")
    for net, wires in zip(plan.nets, routed.wires, strict=True):
        colour, thick, _ = STYLES.get(net.kind, OTHER)
        _path(axes, [list(wire) for wire in wires], colour, thick, 3)
        names = [_name(item, port) for item, port, _ in net.ends]
        axes.patches[-1].set_gid(" = ".join(names))
        if not marked.isdisjoint(names):
            _path(axes, [list(wire) for wire in wires], MARK, thick + 5, 1.5)
        dots = _dots(wires)
        if dots:
            axes.plot(*zip(*dots, strict=True), ".", color=colour, ms=3 + 2 * thick, zorder=3)
    ends: dict[Item, Ends] = {item: [] for item in routed.centres}
    for port, point in routed.ports:
        ends[port.item].append((port, point))
    for item, centre in routed.centres.items():
        _symbol(axes, item, centre, ends[item])
        if item.path in marked:
            (x, y), (half, up) = centre, (CELL[0] / 2, CELL[1] / 2)
            edges = [(x - half, y - up), (x + half, y - up), (x + half, y + up), (x - half, y + up)]
            _path(axes, [[*edges, edges[0]]], MARK, 0.0, 1.5, MARK)
        if item.path in values:
            text = _write(axes, plain_text(values[item.path]), centre, ends[item], "T")
            text.set_gid(f"value of {item.path}")
    _texts(axes, plan, routed)
    return figure


def _name(item: Item, port: str) -> str:
    if item.symbol == "port":
        return item.path
    return f"{item.path}.{port}" if item.path else port


def _texts(axes: Axes, plan: Netlist, routed: Routed) -> None:
    axes.text(0, -HEAD + 0.08, plan.name, size=10, weight="bold", va="top")
    count = len(routed.centres)
    if count > READABLE:
        note = f"{count} symbols are more than can be read well: draw parts, or with depth=1"
        at = 1.6 * measure_text(plan.name)
        axes.text(at, -HEAD + 0.1, note, size=LETTERS, va="top", color="#c4261d")
    at = 0.0
    for kind in dict.fromkeys(net.kind for net in plan.nets):
        colour, thick, text = STYLES.get(kind, OTHER)
        y = routed.size[1] + FOOT / 2
        axes.plot([at, at + 0.2], [y, y], color=colour, linewidth=thick)
        axes.text(at + 0.25, y, text, size=LETTERS, va="center")
        at += 0.45 + measure_text(text)


def _path(
    axes: Axes,
    lines: Iterable[list[Point]],
    colour: str,
    thick: float,
    order: float,
    fill: str = "none",
) -> None:
    axes.add_patch(
        PathPatch(
            Outline.make_compound_path(*map(Outline, lines)),
            facecolor=fill,
            edgecolor=colour,
            linewidth=thick,
            zorder=order,
            capstyle="projecting" if fill == "none" else "butt",
        )
    )


def _dots(wires: list[tuple[Point, Point]]) -> list[Point]:
    """Points where three or more pieces meet."""
    count = Counter(point for wire in wires if wire[0] != wire[1] for point in wire)
    return [point for point, pieces in count.items() if pieces > 2]


def _symbol(axes: Axes, item: Item, centre: Point, ends: Ends) -> None:
    symbol = SYMBOLS[item.symbol]
    x, y = centre
    across = {port.port: port.side for port, _ in ends if port.side in "LR"}
    turn = -1 if [across[port] for port in item.ports if port in across] == ["R", "L"] else 1
    for port, point in ends:
        _lead(axes, symbol, centre, port, point)
    for i, stroke in enumerate(symbol.strokes):
        line = [(x + turn * SCALE * a, y - SCALE * b) for a, b in stroke.points]
        _path(axes, [line], "black", 0.9, 4, stroke.fill or "none")
        if not i:
            axes.patches[-1].set_gid(item.path)
    text = symbol.text
    if item.symbol == "box":
        text = item.kind if len(item.kind) < 8 else item.kind[:6] + "."
    if text:
        axes.text(x, y, text, size=LETTERS, ha="center", va="center", zorder=5)
    _write(axes, item.label, centre, ends, "B")


def _write(axes: Axes, text: str, centre: Point, ends: Ends, side: Literal["T", "B"]) -> Text:
    """Write above or below a symbol, beside the wires that come from there."""
    at, aside = text_place((port for port, _ in ends), side)
    sign, edge = (-1, "bottom") if side == "T" else (1, "top")
    return axes.text(
        centre[0] + at,
        centre[1] + sign * CELL[1] / 2 + 0.01,
        text,
        size=LETTERS,
        ha="left" if aside else "center",
        va=edge,
        zorder=6,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.2, "alpha": 0.75},
    )


def _lead(axes: Axes, symbol: Symbol, centre: Point, port: Terminal, point: Point) -> None:
    """Line from the edge of the cell to the symbol, or to ground at an open, grounded port."""
    if port.net < 0:
        point = (point[0], centre[1] + SCALE * symbol.height + 0.05)
    along, across = port.axis, 1 - port.axis
    size = SCALE * symbol.reach, SCALE * symbol.height
    end = [*point]
    end[along] = centre[along] + (-1 if port.side in "LT" else 1) * size[along]
    near = (end[0], end[1])
    low, high = centre[across] - size[across], centre[across] + size[across]
    end[across] = min(max(point[across], low), high)
    line = [point, near, (end[0], end[1])]
    if symbol.strokes[0].fill:
        end[along] = centre[along]
        line.append((end[0], end[1]))
    colour, thick, _ = STYLES.get(port.kind, OTHER)
    _path(axes, [line], colour, thick, 3.5)
    if symbol.has_letters:
        x, y = (point[0] + near[0]) / 2 - 0.03 * along, (point[1] + near[1]) / 2
        ha, va = ("right", "center") if along else ("center", "bottom")
        axes.text(x, y, port.port[0], size=LETTERS, zorder=6, ha=ha, va=va)
    if port.net < 0:
        half = 0.55 * SCALE
        for stroke in GROUND:
            line = [(point[0] + half * a, point[1] - half * b) for a, b in stroke.points]
            _path(axes, [line], "black", 0.8, 4)
    if port.role == "in":
        dx, dy = near[0] - point[0], near[1] - point[1]
        scale = 0.06 / max(abs(dx), abs(dy), 1e-9)
        ux, uy = dx * scale, dy * scale
        x, y = near
        left, right = (x - ux - uy / 2, y - uy - ux / 2), (x - ux + uy / 2, y - uy + ux / 2)
        _path(axes, [[left, near, right, left]], colour, 0.5, 4.5, colour)
