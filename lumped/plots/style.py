"""The one style of all pictures: colours, lines, marks, letters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Dash = Literal["", "solid", "dashed", "dotted", "dashdot"]
Mark = Literal["", "circle", "square", "triangle", "diamond", "down"]

COLOURS = {
    "blue": "#0072B2",
    "vermilion": "#D55E00",
    "green": "#009E73",
    "purple": "#CC79A7",
    "orange": "#E69F00",
    "sky": "#56B4E9",
}
"""Of Okabe and Ito, Color universal design (2008), told apart by the colour-blind too; its yellow
is too light for lines, its black is for what all else refers to."""
INK, GREY = "#000000", "#767676"
LINES: tuple[Dash, ...] = ("solid", "dashed", "dotted", "dashdot")
"""Of the curves after one round of the colours each."""
MARKS: tuple[Mark, ...] = ("triangle", "diamond", "square", "circle", "down")
MAP = "viridis"
CURVES = 8
"""As many in one panel can be told apart."""
WIDTH = 8.0  # inch
LETTERS, SMALL = 9.0, 8.0  # points
LETTER = 0.62  # width of a letter over its size


@dataclass(frozen=True)
class Look:
    """How a line is drawn; without `dash` its points alone."""

    colour: str = COLOURS["blue"]
    dash: Dash = "solid"
    width: float = 1.3  # points
    mark: Mark = ""
    size: float = 4.5  # points
    hollow: bool = False


PLAIN = Look()
ZERO = Look(INK, width=0.8)


def look(i: int, **changes: Any) -> Look:
    """Look of the i-th curve of a panel."""
    colours = list(COLOURS.values())
    dash = LINES[i // len(colours) % len(LINES)]
    return Look(**{"colour": colours[i % len(colours)], "dash": dash, **changes})


RC: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.formatter.limits": (-4, 5),
    "axes.formatter.use_mathtext": True,
    "axes.grid": True,
    "axes.labelsize": LETTERS,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": LETTERS,
    "figure.titlesize": LETTERS + 2,
    "font.size": LETTERS,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.6,
    "legend.fontsize": SMALL,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
}
"""Settings of matplotlib within a picture; nothing is changed outside."""
