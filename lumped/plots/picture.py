"""A picture as data: panels with curves, bars, levels, bands and texts, before anything draws it.

Each analysis describes its picture once; `lumped.plots.draw` has it drawn.
"""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass

import numpy as np

from lumped.plots.style import LETTER, PLAIN, SMALL, WIDTH, Look, Mark

Real = np.ndarray

_LONGEST = 30  # letters of a line in a legend


@dataclass(frozen=True, eq=False)
class Curve:
    """A line through points, or the points alone.

    Attributes
    ----------
    x, y : ndarray, shape (k,)
        The points; nan interrupts the line.
    label : str
        In the legend, which leaves out what has none.
    look : Look
        How it is drawn.
    """

    x: Real
    y: Real
    label: str = ""
    look: Look = PLAIN


@dataclass(frozen=True, eq=False)
class Level:
    """A straight line across the whole panel at a value of y, or of x if it is upright."""

    at: float
    upright: bool = False
    label: str = ""
    look: Look = PLAIN


@dataclass(frozen=True, eq=False)
class Band:
    """A range of x that is shaded, or hatched, over the whole height."""

    begin: float
    end: float
    colour: str
    label: str = ""
    hatched: bool = False


@dataclass(frozen=True, eq=False)
class Bars:
    """Bars that rise from zero, or lie and reach to the right of it."""

    places: Real
    sizes: Real
    colour: str
    label: str = ""
    lying: bool = False
    width: float = 0.7


@dataclass(frozen=True, eq=False)
class HeatMap:
    """Sizes, shape (len(x), len(y)), as colours over a plane."""

    x: Real
    y: Real
    sizes: Real
    label: str


@dataclass(frozen=True, eq=False)
class Words:
    """A text beside a point: ``aside`` is -1 left of it, 0 centred above it, 1 right of it."""

    x: float
    y: float
    text: str
    aside: int = 0


@dataclass(frozen=True, eq=False)
class Tag:
    """A text outside the panel, joined with its place on the border; places are shares of its side.

    Attributes
    ----------
    text : str
        The text.
    above : bool
        Whether it stands above the panel, else on its right.
    place, moved : float
        Where it belongs, and where there is room for it.
    share : float
        Of the size of small letters.
    upright : bool
        Whether it is turned.
    """

    text: str
    above: bool
    place: float
    moved: float
    share: float = 1.0
    upright: bool = False


@dataclass(frozen=True, eq=False)
class Instants:
    """Small marks on the lower border.

    Attributes
    ----------
    times : ndarray, shape (k,)
        Where.
    texts : tuple of str, of length k
        What each is.
    label : str
        What all are, in the legend.
    mark : str
        Of `lumped.plots.style.MARKS`.
    size : float
        Of the mark, points.
    """

    times: Real
    texts: tuple[str, ...]
    label: str
    mark: Mark
    size: float


Beside = Curve | Level | Band | Bars
"""What stands in the legend beside its panel, unless there is one below all."""
Item = Beside | HeatMap | Words | Tag | Instants


@dataclass(frozen=True)
class Axis:
    """One axis of a panel.

    Attributes
    ----------
    label : str
        What it shows, with its unit.
    log : bool
        Whether it is logarithmic.
    low, high : float or None
        Its ends; None for those of the data.
    names : tuple of str
        Names that stand at 0, 1, 2, ... instead of numbers.
    step : float or None
        Distance of the numbers, where tens are not natural.
    down : bool
        Whether it counts from the top down.
    bare : bool
        Whether it has neither numbers nor names.
    """

    label: str = ""
    log: bool = False
    low: float | None = None
    high: float | None = None
    names: tuple[str, ...] = ()
    step: float | None = None
    down: bool = False
    bare: bool = False


@dataclass(frozen=True, eq=False)
class Panel:
    """A pair of axes and what stands in it; `height` in inches, `square` for equal scales."""

    items: tuple[Item, ...]
    x: Axis = Axis()
    y: Axis = Axis()
    caption: str = ""
    height: float = 2.0
    square: bool = False


@dataclass(frozen=True, eq=False)
class Picture:
    """Panels, row by row, with a title.

    Attributes
    ----------
    title : str
        What it shows.
    panels : tuple of Panel
        Row by row.
    columns : int
        Panels in a row.
    shared : bool
        Whether all have the same axis x.
    below : bool
        Whether one legend stands below all panels, else one beside each.
    note : str
        What is left out, and how to see it.
    """

    title: str
    panels: tuple[Panel, ...]
    columns: int = 1
    shared: bool = False
    below: bool = False
    note: str = ""

    @property
    def depth(self) -> float:
        """Inches below a row that its names along the axis x need, beyond those of numbers."""
        found = 0.0
        for panel in self.panels:
            if panel.x.names:
                angle = choose_names(panel.x.names, self.columns)[1]
                longest = max(map(len, panel.x.names)) * LETTER * SMALL / 72
                found = max(found, longest * math.sin(math.radians(angle)))
        return found

    @property
    def rows(self) -> int:
        """Rows of panels."""
        return -(-len(self.panels) // self.columns)

    def measure_rows(self, room: float, line: float) -> list[float]:
        """Heights of the rows, inch: as panels wish, or as lines in their legends and room need."""
        needed = []
        for panel in self.panels:
            own = [item for item in panel.items if isinstance(item, Beside) and item.label]
            lines = sum(1 + wrap_text(item.label).count("\n") for item in own if not self.below)
            needed.append(max(panel.height, room + line * lines))
        return [max(needed[k : k + self.columns]) for k in range(0, len(needed), self.columns)]

    def is_numbered(self, k: int) -> bool:
        """Whether the axis x of a panel has numbers, as no panel below has the same."""
        return k + self.columns >= len(self.panels) or not self.shared

    def choose_labels(self, k: int) -> tuple[str, str]:
        """Labels of both axes of a panel, but of those that it shares with one below or beside."""
        x, y = self.panels[k].x.label, self.panels[k].y.label
        again = k % self.columns and y == self.panels[k - 1].y.label
        return x if self.is_numbered(k) else "", "" if again else y


def choose_names(names: tuple[str, ...], columns: int) -> tuple[int, int]:
    """Every which of the names along an axis x is told, and how far they are turned, deg."""
    room = 72 * 0.8 * WIDTH / columns / len(names)
    each = max(1, math.ceil(1.1 * SMALL / room))
    if max(map(len, names)) * LETTER * SMALL <= room:
        return each, 0
    return each, 30 if room > 3 * SMALL else 90


def label_axis(text: str, unit: str) -> str:
    """Label of an axis: what it shows, and its unit unless it has none."""
    if unit in ("", "1"):
        return text or "dimensionless"
    return f"{text}, {unit}" if text else unit


def wrap_text(text: str, longest: int = _LONGEST) -> str:
    """A text in lines of so many letters; long names break behind a dot."""
    lines: list[str] = []
    for line in textwrap.wrap(text, longest, break_long_words=False, break_on_hyphens=False):
        while len(line) > longest and (cut := line.rfind(".", 0, longest)) > 0:
            lines.append(line[: cut + 1])
            line = line[cut + 1 :]
        lines.append(line)
    return "\n".join(lines)
