"""Places of the items of a schematic in cells of a grid, the shaft line from left to right.

In each frame, the longest chain of parts that share mechanical nets is the line. Branches stand
above and below the net they hang on, on that side of it to which their ports face: nothing is
mirrored unless it is joined against the line. Then come parts that are joined electrically, and
signal blocks above all. A frame is one block in the frame around it.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable, Iterator, Mapping

from lumped.drawing.netlist import SIGNAL, Frame, Item, Net, Netlist
from lumped.drawing.shaft_line import MECHANICAL, Group, Nets, Placed, find_place, is_aside

WIDEST = 14  # cells before a line is continued below, unless another number is asked for


def place(plan: Netlist, widest: int = WIDEST) -> Placed:
    """Cells of all items and frames of a netlist, in rows of so many cells."""
    chains = list(plan.top.chains())
    home = {item: chain for chain in chains for item in chain[-1].items}
    touching: dict[Frame, list[tuple[Net, dict[Item | Frame, list[Item]]]]] = {}
    for net in plan.nets:
        at: dict[Frame, dict[Item | Frame, list[Item]]] = {}
        for item, _, role in net.ends:
            if is_aside(net, role):
                continue
            chain: list[Item | Frame] = [*home[item], item]
            for frame, part in zip(home[item], chain[1:], strict=True):
                at.setdefault(frame, {}).setdefault(part, []).append(item)
        for frame, parts in at.items():
            touching.setdefault(frame, []).append((net, parts))
    blocks: dict[Item | Frame, Placed] = {}
    for *_, frame in reversed(chains):
        blocks[frame] = _arrange(frame, touching.get(frame, []), blocks, widest)
    return blocks[plan.top]


def _arrange(frame: Frame, nets: Nets, blocks: dict[Item | Frame, Placed], widest: int) -> Placed:
    for item in frame.items:
        blocks[item] = Placed({item: (0, 0)}, [], 1, 1)
    parts: list[Item | Frame] = sorted([*frame.items, *frame.frames], key=find_place)
    result = Placed()
    left = dict.fromkeys(parts)
    signals = [(n, p) for n, p in nets if n.kind == SIGNAL]
    signalled = {part for _, members in signals for part in members}
    levels: list[list[Placed]] = []
    for kinds in (MECHANICAL, ("electrical pin", "thermal port")):
        chosen = [(n, p) for n, p in nets if n.kind in kinds and len(p) > 1]
        groups = []
        for group in _find_connected(list(left), chosen):
            if len(group) > 1:
                for part in group:
                    del left[part]
                inside = set(group)
                found = [n for n in nets if n[0].kind in kinds and inside & n[1].keys()]
                groups.append(Group(found, blocks, group, signalled, widest).place())
        levels.append(groups)
    loose = {part for net, members in nets if net.kind != SIGNAL for part in members}
    steps = [part for part in left if part in signalled and part not in loose]
    for part in steps:
        del left[part]
    above = [_layer(group, signals, blocks, widest) for group in _find_connected(steps, signals)]
    single = _shelf([(0, blocks[part]) for part in left], widest)
    main, others = levels[0][:1], levels[0][1:]
    columns = {item: cell[0] for block in main for item, cell in block.cells.items()}
    beside = [_shelf([wish], widest)[0] for wish in _wishes(others, nets, columns)]
    columns |= {item: cell[0] for block in beside for item, cell in block.cells.items()}
    upper, lower = (_shelf(_wishes(some, nets, columns), widest) for some in (above, levels[1]))
    row = 0
    for block in (*upper, *main, *beside, *lower, *single):
        if main and block is main[0]:
            result.line = row + block.line
        result.take(block, 0, row)
        row += block.height
    if frame.path:
        end = (result.width - 1, result.height - 1)
        result.frames.append((frame, (0, 0), end))
    return result


def _wishes(blocks: list[Placed], nets: Nets, columns: dict[Item, int]) -> list[tuple[int, Placed]]:
    """First column of each block so that its parts stand at those of the line that they join.

    In the order of these columns.
    """
    home = {item: b for b, block in enumerate(blocks) for item in block.cells}
    found: list[list[float]] = [[] for _ in blocks]
    for net, _ in nets:
        there = [columns[item] for item, _, _ in net.ends if item in columns]
        for item, _, _ in net.ends:
            if item in home and there:
                own = blocks[home[item]].cells[item][0]
                found[home[item]].append(sum(there) / len(there) - own)
    wishes = [max(round(sum(seen) / len(seen)), 0) if seen else 0 for seen in found]
    return sorted(zip(wishes, blocks, strict=True), key=lambda wish: wish[0])


def _shelf(blocks: Iterable[tuple[int, Placed]], widest: int) -> list[Placed]:
    """Blocks side by side from the columns wished, in rows of limited width."""
    rows: list[Placed] = []
    for wish, block in blocks:
        if not rows or rows[-1].width + block.width > widest:
            rows.append(Placed())
        rows[-1].take(block, max(rows[-1].width, min(wish, max(widest - block.width, 0))), 0)
    return rows


def _layer(
    parts: list[Item | Frame], nets: Nets, blocks: dict[Item | Frame, Placed], widest: int
) -> Placed:
    """Signal blocks, each to the right of those from which its signals come.

    Where signals go in a circle, the block that is declared first comes first. A block without
    inputs stands just before the first one that listens to it.
    """
    import networkx as nx

    graph = nx.DiGraph()
    graph.add_nodes_from(parts)
    for net, members in nets:
        sources = {item for item, _, role in net.ends if role == "out"}
        here = [part for part in members if part in graph]
        graph.add_edges_from(
            (a, b) for a in here if not sources.isdisjoint(members[a]) for b in here if b is not a
        )
    layer: dict[Item | Frame, int] = {}
    for part in _order_blocks(graph.succ):
        layer[part] = max((layer[b] + 1 for b in graph.pred[part] if b in layer), default=0)
    for part in parts:
        if graph.succ[part] and not graph.pred[part]:
            layer[part] = max(min(layer[b] for b in graph.succ[part]) - 1, 0)
    result = Placed()
    rows: dict[Item | Frame, int] = {}
    column = top = 0
    for number in range(max(layer.values()) + 1):
        own = [part for part in layer if layer[part] == number]
        width = max((blocks[part].width for part in own), default=0)
        if column and column + width > widest:
            column, top = 0, result.height
        wishes = {}  # the row of the first block that each listens to
        for part in own:
            heard = min((rows[b] for b in graph.pred[part] if b in rows), default=top)
            wishes[part] = max(heard, top)
        end = top
        for part in sorted(own, key=wishes.__getitem__):
            rows[part] = max(end, wishes[part])
            result.take(blocks[part], column, rows[part])
            end = rows[part] + blocks[part].height
        column += width
    return result


def _order_blocks(
    listeners: Mapping[Item | Frame, Iterable[Item | Frame]],
) -> Iterator[Item | Frame]:
    """Each block after those that it listens to, as far as there is no circle."""
    waiting = Counter(block for each in listeners.values() for block in each)
    ready = deque(block for block in listeners if not waiting[block])
    done: set[Item | Frame] = set()
    for first in listeners:
        if not ready and first not in done:
            ready.append(first)
        while ready:
            block = ready.popleft()
            if block in done:
                continue
            done.add(block)
            yield block
            for other in listeners[block]:
                waiting[other] -= 1
                if not waiting[other]:
                    ready.append(other)


def _find_connected(parts: list[Item | Frame], nets: Nets) -> list[list[Item | Frame]]:
    """Groups of parts that share nets, directly or not."""
    import networkx as nx

    graph = nx.Graph()
    graph.add_nodes_from(parts)
    known = set(parts)
    for net, members in nets:
        graph.add_edges_from((net, part) for part in members if part in known)
    return [[part for part in parts if part in group] for group in nx.connected_components(graph)]
