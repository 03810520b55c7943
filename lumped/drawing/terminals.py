"""The side of its symbol at which each port of a schematic stands, and its place on that side."""

from __future__ import annotations

from dataclasses import dataclass
from operator import itemgetter

from lumped.drawing.netlist import Item, Net
from lumped.drawing.shaft_line import MECHANICAL, Placed

SPREAD = 0.62  # share of a side over which its ports are spread
FAR = 1e9  # columns


@dataclass(eq=False)
class Terminal:
    """A port at its symbol.

    Attributes
    ----------
    side : str
        "L", "R", "T" (top) or "B" (bottom).
    offset : float
        Place on that side, from -0.5 to 0.5, downwards or to the right.
    net : int
        Number of its net; -1 for an open, grounded port.
    role : str
        "line", "support", "in" or "out".
    kind : str
        Kind of the port.
    """

    item: Item
    port: str
    role: str
    net: int
    kind: str
    side: str = "B"
    offset: float = 0.0

    @property
    def axis(self) -> int:
        """Axis along which its wire leaves: 0 to the left or right, 1 upwards or downwards."""
        return int(self.side in "TB")


def terminals(nets: list[Net], placed: Placed) -> list[Terminal]:
    """Sides and places of all ports."""
    cells = placed.cells
    found: dict[Item, list[_End]] = {item: [] for item in cells}
    for n, net in enumerate(nets):
        columns = sum(cells[item][0] for item, _, _ in net.ends)
        rows = sum(cells[item][1] for item, _, _ in net.ends)
        others = len(net.ends) - 1
        for item, port, role in net.ends:
            column, row = cells[item]
            ahead = (columns - column) / others - column
            below = (rows - row) / others - row
            side = placed.facing.get((item, net))
            if side:  # the place of the trunk counts before that of the partners
                ahead = FAR if side == "R" else -FAR
            found[item].append((ahead, below, Terminal(item, port, role, n, net.kind)))
    result = []
    for item, ends in found.items():
        for port, kind in item.grounded.items():
            ends.append((0.0, 0.0, Terminal(item, port, "support", -1, kind)))
        _choose_sides(ends)
        for side in "LRTB":
            here = [end for end in ends if end[2].side == side]
            # along a vertical side from top to bottom, along a horizontal one from left to right
            here.sort(key=_rank if side in "TB" else itemgetter(1))
            for i, (_, _, terminal) in enumerate(here):
                terminal.offset = SPREAD * ((2 * i + 1) / (2 * len(here)) - 0.5)
                # a port that faces one at the bottom from below never has the same place
                terminal.offset += 0.013 * (side == "B")
        result += [terminal for _, _, terminal in ends]
    return result


_End = tuple[float, float, Terminal]  # how far its partners are to the right and below


def _rank(end: _End) -> tuple[bool, float]:
    return end[2].role == "out", end[0]


def _across(end: _End) -> tuple[float, int]:
    return end[0], end[2].item.ports.index(end[2].port) if end[2].item.ports else 0


def _choose_sides(ends: list[_End]) -> None:
    lines = sorted((end for end in ends if end[2].role == "line"), key=_across)
    shafts = [end for end in lines if end[2].kind in MECHANICAL]
    lines = shafts or lines  # wires of a motor come from below
    if len(lines) == 3 and shafts:
        for (_, below, terminal), side in zip(lines, "LTR", strict=True):
            terminal.side = "B" if side == "T" and below > 0 else side
    elif len(lines) in (1, 3):
        for ahead, _, terminal in lines:
            terminal.side = "L" if ahead < 0 else "R"
    else:
        for i, (_, _, terminal) in enumerate(lines):
            terminal.side = "L" if 2 * i < len(lines) else "R"
    fixed = lines or any(end[2].role == "support" for end in ends)
    sides = {"in": "T", "out": "T"} if fixed else {"in": "L", "out": "R"}
    for _, _, terminal in ends:
        terminal.side = sides.get(terminal.role, terminal.side)
