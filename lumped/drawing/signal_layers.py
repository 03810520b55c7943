"""Places of signal blocks in layers: each stands to the right of those that it listens to."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from typing import TypeVar

_Block = TypeVar("_Block")


def layers(
    sizes: Mapping[_Block, tuple[int, int]], edges: Iterable[tuple[_Block, _Block]], widest: int
) -> dict[_Block, tuple[int, int]]:
    """Columns and rows of blocks.

    Where signals go in a circle, the block that is declared first comes first. A block without
    inputs stands just before the first one that listens to it.

    Parameters
    ----------
    sizes : mapping of block to (int, int)
        Columns and rows that each block takes, in the order of declaration.
    edges : iterable of (block, block)
        Where each signal comes from and goes to.
    widest : int
        Columns before the layers are continued below.
    """
    before: dict[_Block, list[_Block]] = {block: [] for block in sizes}
    after: dict[_Block, list[_Block]] = {block: [] for block in sizes}
    for a, b in edges:
        before[b].append(a)
        after[a].append(b)
    layer: dict[_Block, int] = {}
    for block in _order_blocks(before, after):
        layer[block] = max((layer[b] + 1 for b in before[block] if b in layer), default=0)
    for block in sizes:
        if not before[block] and after[block]:
            layer[block] = max(min(layer[b] for b in after[block]) - 1, 0)
    held: list[list[_Block]] = [[] for _ in range(max(layer.values()) + 1)]
    for block, number in layer.items():
        held[number].append(block)
    places: dict[_Block, tuple[int, int]] = {}
    column = top = bottom = 0
    for blocks in held:
        width = max((sizes[block][0] for block in blocks), default=0)
        if column and column + width > widest:
            column, top = 0, bottom
        end = top
        for block in sorted(blocks, key=lambda b: _wish(b, before, places, top)):
            row = max(end, _wish(block, before, places, top))
            places[block] = (column, row)
            end = row + sizes[block][1]
        bottom = max(bottom, end)
        column += width
    return places


def _order_blocks(
    before: dict[_Block, list[_Block]], after: dict[_Block, list[_Block]]
) -> Iterable[_Block]:
    """Each block after those that it listens to, as far as there is no circle."""
    waiting = {block: len(sources) for block, sources in before.items()}
    ready = deque(block for block, count in waiting.items() if not count)
    done: set[_Block] = set()
    for first in before:
        if not ready and first not in done:
            ready.append(first)
        while ready:
            block = ready.popleft()
            if block in done:
                continue
            done.add(block)
            yield block
            for other in after[block]:
                waiting[other] -= 1
                if not waiting[other]:
                    ready.append(other)


def _wish(
    block: _Block,
    before: dict[_Block, list[_Block]],
    places: dict[_Block, tuple[int, int]],
    top: int,
) -> int:
    """Row of the first block that it listens to."""
    return max(min((places[b][1] for b in before[block] if b in places), default=top), top)
