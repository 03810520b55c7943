"""What the reduction of a model did, stage by stage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lumped.compiler.idle_parts import find_idle_parameters
from lumped.compiler.structure import Structure
from lumped.reduction.pruning import LeftOut
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import list_lines, table


@dataclass(frozen=True)
class Report(RichHtml):
    """Counts, states and times of a reduction; ``report["states"]`` gives a count.

    Attributes
    ----------
    counts : dict of str to int
        Sizes before and after each stage.
    states : dict of str to str
        Each state, and why it is one.
    blocks : tuple of str
        Unknowns of each block that is solved together.
    implicit : tuple of str
        Unknowns that Newton's method finds.
    left_out : tuple of LeftOut
        What is not computed, and why.
    still : tuple of str
        Ports that are left open and stand still, such as the supports of gears.
    idle : tuple of str
        Parameters that occur in no equation and no start value. Losses, stored energies and ranges
        may use them.
    seconds : dict of str to float
        Time of each stage.
    """

    counts: dict[str, int]
    states: dict[str, str]
    blocks: tuple[str, ...]
    implicit: tuple[str, ...]
    left_out: tuple[LeftOut, ...]
    still: tuple[str, ...]
    idle: tuple[str, ...]
    seconds: dict[str, float]

    def __getitem__(self, name: str) -> int:
        return self.counts[name]

    def __repr__(self) -> str:
        parts = [
            table(("count", ""), [(name, str(n)) for name, n in self.counts.items()]),
            table(("stage", "ms"), [(n, f"{1e3 * s:.1f}") for n, s in self.seconds.items()]),
        ]
        lists = {
            "states": [f"{name}: {why}" for name, why in self.states.items()],
            "solved together": self.blocks,
            "found by Newton's method": self.implicit,
            "left open and held still": self.still,
            "parameters in no equation": self.idle,
            "left out": [repr(item) for item in self.left_out],
        }
        for title, items in lists.items():
            if items or title == "states":
                parts.append(f"{title}\n{list_lines(items, 20)}".rstrip())
        return "\n\n".join(parts)


def report_on(structure: Structure, names: Sequence[str], seconds: Mapping[str, float]) -> Report:
    """What the reduction did: counts, states and why they are, blocks, times.

    Parameters
    ----------
    structure : Structure
        What came of it.
    names : sequence of str
        Names of the states in use.
    seconds : mapping of str to float
        Time of each stage.
    """
    flat, reduced, name = structure.flat, structure.reduced, structure.node_name
    connection = len(flat.joints.equal) + len(flat.joints.sums) + len(flat.joints.grounded)
    coupled = [block for block in reduced.blocks if len(block.nodes) > 1]
    counts = {
        "components": len(structure.tree.instances),
        "unknowns": structure.tree.unknown_count,
        "equations": flat.equation_count + connection,
        "after alias elimination": reduced.incidence.count,
        "differentiated": int((reduced.differentiations > 0).sum()),
        "index": int(reduced.differentiations.max(initial=0)) + 1,
        "coupled blocks": len(coupled),
        "largest block": max((len(b.nodes) for b in reduced.blocks), default=0),
        "states": len(structure.states),
    }
    reasons = [_reason(structure, node) for node in structure.states]
    return Report(
        counts,
        dict(zip(names, reasons, strict=True)),
        tuple(shorten([name(n) for n in block.nodes]) for block in coupled),
        tuple(name(n) for n in structure.implicit),
        tuple(structure.left_out),
        tuple(name for _, name in flat.joints.grounded),
        tuple(find_idle_parameters(flat)),
        dict(seconds),
    )


def _reason(structure: Structure, node: int) -> str:
    """Why a node is a state."""
    if node not in structure.reduced.tied:
        return "its derivative occurs in the equations"
    unknown = structure.members.get(node)
    wish = "avoid" if unknown is None else structure.tree.quantity(unknown).wish
    if wish in ("prefer", "always"):
        return f"declared state='{wish}'; constraints determine others"
    return "leads what constraints tie to it; declared before them or wanted more"


def shorten(items: Sequence[str], separator: str = ", ", most: int = 12) -> str:
    """Some of many texts, and how many more there are."""
    more = f"{separator}... {len(items) - most} more" if len(items) > most else ""
    return separator.join(items[:most]) + more
