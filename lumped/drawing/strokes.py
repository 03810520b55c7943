"""Strokes of which symbols are drawn, in a square from -1 to 1, y upwards."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

Points = Sequence[tuple[float, float]]


class Stroke(NamedTuple):
    """A polyline, closed and filled if it is an area."""

    points: Points
    fill: str = ""  # colour of an area


class Symbol(NamedTuple):
    """Strokes, a text in the middle, and how far the symbol reaches to each side and up.

    Leads are drawn from there to the edge of the cell, with the first letter of their port if that
    tells them apart.
    """

    strokes: tuple[Stroke, ...]
    reach: float
    height: float
    text: str
    has_letters: bool


GREY, WHITE, BLACK = "#cfd6dd", "white", "black"


def symbol(
    *strokes: Stroke,
    reach: float | None = None,
    height: float | None = None,
    text: str = "",
    has_letters: bool = False,
) -> Symbol:
    """A symbol of strokes; where it is not given, it reaches as far as they do."""
    far, high = np.abs(np.concatenate([stroke.points for stroke in strokes])).max(axis=0).tolist()
    reach, height = far if reach is None else reach, high if height is None else height
    return Symbol(strokes, reach, height, text, has_letters)


def line(*numbers: float) -> Stroke:
    """A polyline through points, x and y in turn."""
    return Stroke(list(zip(numbers[::2], numbers[1::2], strict=True)))


def box(x0: float, y0: float, x1: float, y1: float, fill: str = WHITE) -> Stroke:
    """A rectangle from corner to corner."""
    return Stroke([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)], fill)


def oval(x: float, y: float, a: float, b: float | None = None, fill: str = WHITE) -> Stroke:
    """An ellipse, a circle unless both half-axes are given."""
    b = a if b is None else b
    turn = np.linspace(0, 2 * np.pi, 37)
    ring = zip((x + a * np.cos(turn)).tolist(), (y + b * np.sin(turn)).tolist(), strict=True)
    return Stroke(list(ring), fill)


def arc(x: float, y: float, r: float, begin: float, end: float) -> Stroke:
    """Part of a circle, degrees."""
    turn = np.radians(np.linspace(begin, end, 25))
    ring = zip((x + r * np.cos(turn)).tolist(), (y + r * np.sin(turn)).tolist(), strict=True)
    return Stroke(list(ring))


def head(x: float, y: float, degrees: float, size: float = 0.22) -> Stroke:
    """Arrowhead with its tip at a point."""
    back = np.radians([degrees + 155, degrees - 155])
    a, b = ((x + size * float(np.cos(t)), y + size * float(np.sin(t))) for t in back)
    return Stroke([(x, y), a, b, (x, y)], BLACK)


def zigzag(x0: float, x1: float, y: float, size: float, count: int = 3) -> Stroke:
    """The turns of a spring."""
    x = np.linspace(x0, x1, 4 * count + 1)
    points = [(float(v), y + size * (0, 1, 0, -1)[i % 4]) for i, v in enumerate(x)]
    return Stroke([p for i, p in enumerate(points) if i % 2 or i in (0, 4 * count)])


def hatch(x0: float, x1: float, y: float, down: float = 0.16, count: int = 4) -> list[Stroke]:
    """Solid ground: a line with hatching below."""
    step = (x1 - x0) / count
    return [
        line(x0, y, x1, y),
        *(line(x0 + (i + 1) * step, y, x0 + i * step, y - down) for i in range(count)),
    ]


def wall(x: float, y0: float, y1: float, count: int = 5) -> list[Stroke]:
    """Solid wall: a vertical line with hatching to its left."""
    step = (y1 - y0) / count
    marks = (line(x, y0 + (i + 1) * step, x - 0.2, y0 + i * step) for i in range(count))
    return [line(x, y0, x, y1), *marks]


def pot(y: float) -> list[Stroke]:
    """Damper at a height, from -0.7 to 0.7."""
    return [
        line(-0.7, y, -0.05, y),
        line(-0.05, y - 0.18, -0.05, y + 0.18),
        line(0.2, y + 0.26, -0.3, y + 0.26, -0.3, y + 0.26),
        line(0.2, y - 0.26, -0.3, y - 0.26),
        line(0.2, y - 0.26, 0.2, y + 0.26),
        line(0.2, y, 0.7, y),
    ]


def round_symbol(letter: str) -> Symbol:
    """A circle with a letter in it."""
    return symbol(oval(0, 0, 0.6), text=letter)


def block(text: str) -> Symbol:
    """A block with a text in it."""
    return symbol(box(-0.75, -0.55, 0.75, 0.55), text=text)


def axes(*strokes: Stroke) -> Symbol:
    """A block with a curve in it."""
    return symbol(box(-0.65, -0.65, 0.65, 0.65), *strokes)
