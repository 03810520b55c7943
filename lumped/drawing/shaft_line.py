"""Places of joined parts: the longest chain is the line, branches stand above and below it."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from lumped.drawing.netlist import Frame, Item, Net

RIGID = ("inertia", "mass")  # symbols of parts whose two ends are one
MECHANICAL = ("rotational flange", "translational flange")

Cell = tuple[int, int]  # column, row


@dataclass
class Placed:
    """Cells of items, first and last cells of frames, and the row of the line.

    `facing` gives the side, "L" or "R", to which an item is joined to a net.
    """

    cells: dict[Item, Cell] = field(default_factory=dict)
    frames: list[tuple[Frame, Cell, Cell]] = field(default_factory=list)
    width: int = 0
    height: int = 0
    line: int = 0
    facing: dict[tuple[Item, Net], str] = field(default_factory=dict)

    def take(self, other: Placed, column: int, row: int) -> None:
        """Put another block here, its first cell at a place."""
        for item, (c, r) in other.cells.items():
            self.cells[item] = (column + c, row + r)
        for frame, (c, r), (d, s) in other.frames:
            self.frames.append((frame, (column + c, row + r), (column + d, row + s)))
        self.facing |= other.facing
        self.width = max(self.width, column + other.width)
        self.height = max(self.height, row + other.height)


def is_aside(net: Net, role: str) -> bool:
    """Supports do not make a line."""
    return net.kind in MECHANICAL and role == "support"


def _count(net: Net) -> int:
    return sum(not is_aside(net, role) for _, _, role in net.ends)


Nets = Sequence[tuple[Net, dict[Item | Frame, list[Item]]]]


def find_place(part: Item | Frame) -> int:
    """Place of a part, or of the first item of a frame, in the order of declaration."""
    if isinstance(part, Item):
        return part.place
    return min((item.place for item in part.all_items()), default=0)


class Group:
    """Parts that are joined by nets: a line, folded if it is long, and its branches."""

    def __init__(
        self,
        nets: Nets,
        blocks: dict[Item | Frame, Placed],
        parts: list[Item | Frame],
        signalled: set[Item | Frame],
        widest: int,
    ) -> None:
        self.widest, self.signalled = widest, signalled
        self.nets, self.blocks, self.parts = nets, blocks, parts
        self.leaves = [_count(net) > sum(map(len, members.values())) for net, members in nets]
        self.around: dict[Item | Frame, list[int]] = {part: [] for part in parts}
        self.ports: dict[Item | Frame, dict[str, int]] = {part: {} for part in parts}
        for n, (net, members) in enumerate(nets):
            for part in members:
                if part in self.around:
                    self.around[part].append(n)
            for item, port, role in net.ends:
                if item in self.ports and not is_aside(net, role):
                    self.ports[item][port] = n
        self.taken: list[set[Cell]] = []  # of each fold of the line
        self.lengths: list[int] = []  # columns of each fold
        self.at: dict[Item | Frame, tuple[int, int, int]] = {}  # fold, column, row
        self.home: dict[int, tuple[int, int, int]] = {}  # net: fold, boundary, row
        self.facing: dict[tuple[Item, Net], str] = {}
        self.tried: dict[tuple[int, tuple[bool, ...], int], int] = {}
        self.ways: list[tuple[int, int, bool]] = []  # fold, boundary, and whether it is the end

    def place(self) -> Placed:
        """Block of all parts, as wide as the line or a fold of it."""
        line = self._line()
        self._place_line(line)
        queue, hung = deque(line), set[int]()
        while queue:
            part = queue.popleft()
            for n in self.around[part]:
                if n in hung:
                    continue
                hung.add(n)
                self._settle(n, part)
                for other in self.nets[n][1]:
                    if other in self.around and other not in self.at:
                        self._hang(other, n)
                        queue.append(other)
        result = Placed()
        begin = 0
        for fold, cells in enumerate(self.taken):
            top = min(r for _, r in cells)
            result.line = result.line if fold else -top
            first = min(c for c, _ in cells)
            for part, (f, column, row) in self.at.items():
                if f == fold:
                    result.take(self.blocks[part], column - first, begin + row - top)
            begin = result.height
        result.facing = self.facing | result.facing
        return result

    def _line(self) -> list[Item | Frame]:
        """The longest of shortest chains, by two searches for the farthest part.

        Its direction is that of frames, else of most parts from their first port to their last;
        without them it begins with the end declared first.
        """
        first = min(self.parts, key=find_place)
        back, way = self._farthest([first], set(), -1)
        if way is not None:
            ends = [part for part in self.nets[way][1] if part in self.around]
            line, _ = self._farthest([p for p in ends if not self._against(p, way, 1)], {way}, 1)
        else:  # two parts with one port each may both be the first
            one = len(back) == 2 and not any(
                self._side(p, self._find_shared_net(*back)) for p in back
            )
            line, _ = self._farthest([first if one else back[-1]], set(), 1)
        if len(line) > 1 and any(isinstance(part, Frame) for part in line):
            return line
        ahead = sum(
            self._side(a, self._find_shared_net(a, b)) - self._side(b, self._find_shared_net(a, b))
            for a, b in itertools.pairwise(line)
        )
        ahead = ahead or find_place(line[-1]) - find_place(line[0])
        return line if ahead >= 0 else line[::-1]

    def _side(self, part: Item | Frame, n: int) -> int:
        """Side to which a part is joined to a net: -1 left, 1 right, 0 either."""
        if isinstance(part, Frame):
            columns = [column for column, _ in self._ends(part, n)]
            twice = 2 * sum(columns) - len(columns) * (self.blocks[part].width - 1)
            return (twice > 0) - (twice < 0)
        ports = self.ports[part]
        if len(ports) not in (2, 3):
            return 0
        first, *others = sorted(ports, key=part.ports.index)
        return any(ports[port] == n for port in others) - (ports[first] == n)

    def _against(self, part: Item | Frame, n: int, ahead: int) -> bool:
        """Whether a search to the right (1) or left (-1) that comes from a net is stopped here."""
        rigid = isinstance(part, Item) and part.symbol in RIGID
        return self._side(part, n) == ahead and not (rigid and ahead > 0)

    def _farthest(
        self, starts: list[Item | Frame], seen: set[int], ahead: int
    ) -> tuple[list[Item | Frame], int | None]:
        """Chain to the part farthest from some, and the net by which it leaves the frame there.

        Such a way counts as one part more. Frames are passed in the direction of the search, from
        left to right or back, other parts at least where the chain branches. No chain goes through
        the ground on which several parts stand.
        """
        before: dict[Item | Frame, Item | Frame | None] = dict.fromkeys(starts)
        steps = dict.fromkeys(starts, 0)
        queue, last = deque(starts), starts[0]
        found: int | None = None
        best = (-1, False, 0, 0)
        while queue:
            part = queue.popleft()
            way: int | None = None
            for n in self.around[part]:
                back = isinstance(part, Frame) or ahead < 0
                if n in seen or (back and self._against(part, n, -ahead)):
                    continue
                seen.add(n)
                way = n if self.leaves[n] else way
                others = [other for other in self.nets[n][1] if other in self.around]
                if len(others) > 2 and any(map(_is_ground, others)):
                    continue
                branches = len(others) > 2 or self.leaves[n]
                for other in others:
                    strict = branches or ahead < 0 or isinstance(other, Frame)
                    if other not in before and not (strict and self._against(other, n, ahead)):
                        before[other], steps[other] = part, steps[part] + 1
                        queue.append(other)
            width = self.blocks[part].width
            leaves = way is not None
            score = (steps[part] + leaves, leaves, width, -find_place(part))
            if score > best:
                best, last, found = score, part, way
        chain: list[Item | Frame] = []
        current: Item | Frame | None = last
        while current is not None:
            chain.append(current)
            current = before[current]
        return chain[::-1], found

    def _find_shared_net(self, one: Item | Frame, other: Item | Frame) -> int:
        return next(n for n in self.around[one] if other in self.nets[n][1])

    def _place_line(self, line: list[Item | Frame]) -> None:
        column = 0
        for i, part in enumerate(line):
            block = self.blocks[part]
            before = self._find_shared_net(part, line[i - 1]) if i else None
            after = self._find_shared_net(part, line[i + 1]) if i + 1 < len(line) else None
            wide = max(self.widest, 1.25 * block.width)  # a few parts before a wide one do not turn
            if not self.taken or column + block.width > wide:
                self.taken.append(set())
                self.lengths.append(0)
                column = 0
            row = self._row(part, before if before is not None else after)
            self._put(part, len(self.taken) - 1, column, -row)
            if before is not None:
                self._face(part, before, "L")
                if column:
                    self.home[before] = (len(self.taken) - 1, column, 0)
            if after is not None:
                self._face(part, after, "R")
            column += block.width
            self.lengths[-1] = column
        self._keep_way(line[0], line[1] if len(line) > 1 else None, 0, 0)
        self._keep_way(line[-1], line[-2] if len(line) > 1 else None, len(self.taken) - 1, column)

    def _keep_way(
        self, part: Item | Frame, beside: Item | Frame | None, fold: int, column: int
    ) -> None:
        """Keep the row of the line free where it leaves the frame at one of its ends."""
        for n in self.around[part]:
            if self.leaves[n] and n not in self.home and beside not in self.nets[n][1]:
                self.home[n] = (fold, column, 0)
                self.ways.append((fold, column, column > 0))
                self._face(part, n, "R" if column else "L")
                return

    def _ends(self, part: Item | Frame, n: int | None) -> list[Cell]:
        return [] if n is None else [self.blocks[part].cells[i] for i in self.nets[n][1][part]]

    def _face(self, part: Item | Frame, n: int, side: str) -> None:
        net, members = self.nets[n]
        if net.kind in MECHANICAL or len(self.ports[part]) == 2:
            self.facing.update(dict.fromkeys(((item, net) for item in members[part]), side))

    def _row(self, part: Item | Frame, n: int | None) -> int:
        """Row of the block that stands on the line: its own line if the net is there."""
        rows = [row for _, row in self._ends(part, n)]
        line = self.blocks[part].line
        return line if line in rows or not rows else rows[0]

    def _put(self, part: Item | Frame, fold: int, column: int, row: int) -> None:
        block = self.blocks[part]
        self.at[part] = (fold, column, row)
        self.taken[fold].update(
            (column + c, row + r) for c in range(block.width) for r in range(block.height)
        )

    def _settle(self, n: int, part: Item | Frame) -> None:
        """Set the trunk of a net that is not part of the line: on the far side of a branch."""
        if n in self.home:
            return
        fold, column, row = self.at[part]
        block = self.blocks[part]
        sides = {self.home[m][1] for m in self.around[part] if m in self.home}
        right = column + block.width not in sides
        if right and column not in sides:
            right = self._side(part, n) >= 0
        self.home[n] = (fold, column + block.width if right else column, row + self._row(part, n))
        if {column, column + block.width} - sides:
            self._face(part, n, "R" if right else "L")

    def _sides(self, part: Item | Frame, n: int) -> tuple[bool, ...]:
        """Sides of the trunk of a net on which a part may stand, best first; True is the right."""
        fold, boundary, _ = self.home[n]
        for m in self.around[part]:
            there, other, _ = self.home.get(m, self.home[n])
            if there == fold and other != boundary:
                return (other > boundary,)
        side = self._side(part, n)
        if side:
            return (side < 0,)
        at_end, width = (fold, boundary, True) in self.ways, self.blocks[part].width
        if at_end or (fold, boundary, False) in self.ways:
            return (not at_end, at_end)
        if boundary < width or boundary + width > self.lengths[fold]:  # not beyond the line
            return (boundary < width,)
        return (True, False)

    def _hang(self, part: Item | Frame, n: int) -> None:
        """Put a part at the nearest free place beside the trunk of a net."""
        fold, boundary, line = self.home[n]
        block = self.blocks[part]
        base = self._row(part, n)
        small = block.width == block.height == 1
        sides = self._sides(part, n)
        down = -1 if part in self.signalled else 1  # signals come from above
        step = self.tried.get((n, sides, down), 0) if small else 0
        while True:
            turn, side = divmod(step, len(sides))
            away = (turn + 1) // 2 * (down if turn % 2 else -down)
            column = boundary if sides[side] else boundary - block.width
            row = line + away - base
            cells = ((column + c, row + r) for c in range(block.width) for r in range(block.height))
            on_way = row <= 0 < row + block.height and any(
                f == fold and (column >= c if end else column < c) for f, c, end in self.ways
            )
            if not on_way and self.taken[fold].isdisjoint(cells):
                break
            step += 1
        if small:
            self.tried[n, sides, down] = step + 1
        self._put(part, fold, column, row)
        self._face(part, n, "L" if sides[side] else "R")


def _is_ground(part: Item | Frame) -> bool:
    return isinstance(part, Item) and part.symbol == "fixed"
