"""Symbols of drive engineering as polylines in a square from -1 to 1, y upwards.

A component class names its symbol (``symbol = "inertia"``); without one it is a box. The shaft
comes in from the left and goes out to the right at ``y = 0``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

__all__ = ["GROUND", "SYMBOLS", "Stroke", "Symbol"]

Points = Sequence[tuple[float, float]]


class Stroke(NamedTuple):
    """A polyline, closed and filled if it is an area."""

    points: Points
    fill: str = ""  # colour of an area


class Symbol(NamedTuple):
    """Strokes, a text in the middle, and how far the symbol reaches to each side and up.

    Leads are drawn from there to the edge of the cell.
    """

    strokes: tuple[Stroke, ...]
    reach: float = 0.6
    height: float = 0.6
    text: str = ""


GREY, WHITE, BLACK = "#cfd6dd", "white", "black"


def _symbol(*strokes: Stroke, reach: float = 0.6, height: float = 0.6, text: str = "") -> Symbol:
    return Symbol(strokes, reach, height, text)


def _line(*numbers: float) -> Stroke:
    return Stroke(list(zip(numbers[::2], numbers[1::2], strict=True)))


def _box(x0: float, y0: float, x1: float, y1: float, fill: str = WHITE) -> Stroke:
    return Stroke([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)], fill)


def _oval(x: float, y: float, a: float, b: float | None = None, fill: str = WHITE) -> Stroke:
    b = a if b is None else b
    turn = np.linspace(0, 2 * np.pi, 37)
    ring = zip((x + a * np.cos(turn)).tolist(), (y + b * np.sin(turn)).tolist(), strict=True)
    return Stroke(list(ring), fill)


def _arc(x: float, y: float, r: float, begin: float, end: float) -> Stroke:
    """Part of a circle, degrees."""
    turn = np.radians(np.linspace(begin, end, 25))
    ring = zip((x + r * np.cos(turn)).tolist(), (y + r * np.sin(turn)).tolist(), strict=True)
    return Stroke(list(ring))


def _head(x: float, y: float, degrees: float, size: float = 0.22) -> Stroke:
    """Arrowhead with its tip at a point."""
    back = np.radians([degrees + 155, degrees - 155])
    a, b = ((x + size * float(np.cos(t)), y + size * float(np.sin(t))) for t in back)
    return Stroke([(x, y), a, b, (x, y)], BLACK)


def _zigzag(x0: float, x1: float, y: float, size: float, count: int = 3) -> Stroke:
    x = np.linspace(x0, x1, 4 * count + 1)
    points = [(float(v), y + size * (0, 1, 0, -1)[i % 4]) for i, v in enumerate(x)]
    return Stroke([p for i, p in enumerate(points) if i % 2 or i in (0, 4 * count)])


def _hatch(x0: float, x1: float, y: float, down: float = 0.16, count: int = 4) -> list[Stroke]:
    """Solid ground: a line with hatching below."""
    step = (x1 - x0) / count
    return [
        _line(x0, y, x1, y),
        *(_line(x0 + (i + 1) * step, y, x0 + i * step, y - down) for i in range(count)),
    ]


def _wall(x: float, y0: float, y1: float, count: int = 5) -> list[Stroke]:
    """Solid wall: a vertical line with hatching to its left."""
    step = (y1 - y0) / count
    marks = (_line(x, y0 + (i + 1) * step, x - 0.2, y0 + i * step) for i in range(count))
    return [_line(x, y0, x, y1), *marks]


def _pot(y: float) -> list[Stroke]:
    """Damper at a height, from -0.7 to 0.7."""
    return [
        _line(-0.7, y, -0.05, y),
        _line(-0.05, y - 0.18, -0.05, y + 0.18),
        _line(0.2, y + 0.26, -0.3, y + 0.26, -0.3, y + 0.26),
        _line(0.2, y - 0.26, -0.3, y - 0.26),
        _line(0.2, y - 0.26, 0.2, y + 0.26),
        _line(0.2, y, 0.7, y),
    ]


def _round(letter: str) -> Symbol:
    return _symbol(_oval(0, 0, 0.6), text=letter)


def _block(text: str) -> Symbol:
    return _symbol(_box(-0.75, -0.55, 0.75, 0.55), reach=0.75, height=0.55, text=text)


def _axes(*strokes: Stroke) -> Symbol:
    """A block with a curve in it."""
    return Symbol((_box(-0.65, -0.65, 0.65, 0.65), *strokes), 0.65, 0.65)


_SPRING = [_line(-0.7, 0, -0.55, 0), _zigzag(-0.55, 0.55, 0, 0.3), _line(0.55, 0, 0.7, 0)]
_BARS = [_line(-0.7, -0.35, -0.7, 0.35), _line(0.7, -0.35, 0.7, 0.35)]
_PLATES = (_box(-0.3, -0.6, -0.12, 0.6, GREY), _box(0.12, -0.6, 0.3, 0.6, GREY))
_LEADS = (_line(-0.6, 0, -0.3, 0), _line(0.3, 0, 0.6, 0))

GROUND = Symbol((_line(0, 0.2, 0, 0), *_hatch(-0.4, 0.4, 0.0)), 0, 0.2)
"""Fixed housing below a port."""

SYMBOLS: dict[str, Symbol] = {
    "box": _symbol(_box(-0.75, -0.55, 0.75, 0.55), reach=0.75, height=0.55),
    "port": _symbol(_oval(0, 0, 0.16), reach=0.16, height=0.16),
    "inertia": _symbol(_box(-0.2, -0.75, 0.2, 0.75, GREY), reach=0.2, height=0.75),
    "mass": _symbol(_box(-0.6, -0.45, 0.6, 0.45, GREY), reach=0.6, height=0.45),
    "strut": _symbol(_box(-0.75, -0.08, 0.75, 0.08, GREY), reach=0.75, height=0.1),
    "spring": _symbol(*_SPRING, reach=0.7, height=0.3),
    "damper": _symbol(*_pot(0.0), reach=0.7, height=0.26),
    "spring_damper": _symbol(
        _line(-0.7, 0.4, -0.5, 0.4),
        _zigzag(-0.5, 0.5, 0.4, 0.22),
        _line(0.5, 0.4, 0.7, 0.4),
        *_pot(-0.35),
        _line(-0.7, -0.35, -0.7, 0.4),
        _line(0.7, -0.35, 0.7, 0.4),
        reach=0.7,
        height=0.62,
    ),
    "gear": _symbol(
        _line(-0.6, 0, -0.26, 0),
        _line(0.26, 0, 0.6, 0),
        _box(-0.26, -0.75, -0.02, 0.3, GREY),
        _box(0.02, -0.3, 0.26, 0.75, GREY),
        _line(-0.26, 0, 0.26, 0),
        reach=0.6,
        height=0.75,
    ),
    "gearbox": _symbol(
        _box(-0.65, -0.7, 0.65, 0.7),
        _line(-0.65, -0.15, -0.05, -0.15),
        _line(0.05, 0.15, 0.65, 0.15),
        _box(-0.42, -0.5, -0.24, 0.2, GREY),
        _box(0.24, -0.2, 0.42, 0.5, GREY),
        _line(-0.24, 0.1, 0.24, 0.1),
        reach=0.65,
        height=0.7,
    ),
    "belt": _symbol(
        _line(-0.45, 0.3, 0.45, 0.42),
        _line(-0.45, -0.3, 0.45, -0.42),
        _oval(-0.45, 0, 0.3, fill=GREY),
        _oval(0.45, 0, 0.42, fill=GREY),
        reach=0.75,
        height=0.5,
    ),
    "bevel": _symbol(
        Stroke([(-0.45, -0.3), (-0.15, -0.6), (-0.15, 0.6), (-0.45, 0.3), (-0.45, -0.3)], GREY),
        Stroke([(-0.05, 0.7), (0.55, 0.7), (0.25, 0.4), (0.05, 0.4), (-0.05, 0.7)], GREY),
        _line(0.25, 0.4, 0.25, 0.0, 0.6, 0.0),
        reach=0.6,
        height=0.7,
    ),
    "ellipses": _symbol(
        _oval(-0.38, 0, 0.38, 0.6, GREY), _oval(0.32, 0, 0.32, 0.7, GREY), reach=0.7
    ),
    "planetary": _symbol(
        _oval(0, 0, 0.75),
        _oval(0, 0, 0.25, fill=GREY),
        *(_oval(0.5 * x, 0.5 * y, 0.22, fill=GREY) for x, y in ((0, 1), (0.87, -0.5))),
        _oval(-0.435, -0.25, 0.22, fill=GREY),
        reach=0.75,
        height=0.75,
    ),
    "rack": _symbol(
        _oval(0, 0.15, 0.5, fill=GREY),
        _box(-0.8, -0.6, 0.8, -0.35, GREY),
        _line(-0.8, 0, -0.45, 0),
        reach=0.8,
        height=0.65,
    ),
    "crank": _symbol(
        _box(-0.8, -0.6, 0.98, 0.68),
        _oval(-0.5, -0.1, 0.13),
        _line(-0.5, -0.1, -0.15, 0.5),
        _oval(-0.15, 0.5, 0.06),
        _line(-0.15, 0.5, 0.5, -0.1),
        _box(0.3, -0.27, 0.75, 0.07, GREY),
        *_hatch(0.1, 0.9, -0.32, 0.12),
        reach=0.8,
        height=0.6,
    ),
    "arm": _symbol(
        _box(-0.68, -0.72, 0.68, 0.72),
        _line(-0.4, -0.4, 0.35, 0.4),
        _oval(-0.4, -0.4, 0.14),
        _oval(0.35, 0.4, 0.2, fill=GREY),
        reach=0.68,
        height=0.72,
    ),
    "ring_damper": _symbol(
        _line(-0.7, 0.0, -0.1, 0.0),
        *(
            part
            for y in (-1, 1)
            for part in (
                _line(-0.1, 0.0, -0.1, 0.15 * y, -0.4, 0.15 * y, -0.4, 0.75 * y, 0.4, 0.75 * y),
                _line(0.4, 0.75 * y, 0.4, 0.15 * y, 0.1, 0.15 * y, 0.1, 0.0),
                _box(-0.25, 0.28 * y, 0.25, 0.62 * y, GREY),
            )
        ),
        _line(-0.1, 0.0, 0.1, 0.0),
        reach=0.7,
        height=0.75,
    ),
    "pendulum": _symbol(
        _oval(0, -0.12, 0.55),
        _oval(0, -0.12, 0.1, fill=WHITE),
        _oval(0, 0.18, 0.06, fill=BLACK),
        _line(0, 0.18, 0.25, 0.62),
        _oval(0.25, 0.62, 0.14, fill=GREY),
        reach=0.55,
        height=0.76,
    ),
    "rod": _symbol(
        _box(-0.68, -0.72, 0.68, 0.72),
        _line(-0.35, 0.5, 0.35, -0.5),
        _oval(-0.35, 0.5, 0.12),
        _oval(0.35, -0.5, 0.12),
        reach=0.68,
        height=0.72,
    ),
    "shaft": _symbol(_box(-0.75, -0.16, 0.75, 0.16, GREY), reach=0.75, height=0.16),
    "stepped_shaft": _symbol(
        _box(-0.75, -0.16, -0.25, 0.16, GREY),
        _box(-0.25, -0.32, 0.3, 0.32, GREY),
        _box(0.3, -0.22, 0.75, 0.22, GREY),
        reach=0.75,
        height=0.32,
    ),
    "taper": _symbol(
        Stroke([(-0.75, -0.14), (0.75, -0.34), (0.75, 0.34), (-0.75, 0.14), (-0.75, -0.14)], GREY),
        reach=0.75,
        height=0.34,
    ),
    "notch": _symbol(
        Stroke(
            [
                *((-0.6, 0.3), (-0.12, 0.3), (0.0, 0.12), (0.12, 0.3), (0.6, 0.3)),
                *((0.6, -0.3), (0.12, -0.3), (0.0, -0.12), (-0.12, -0.3), (-0.6, -0.3)),
                (-0.6, 0.3),
            ],
            GREY,
        ),
        reach=0.6,
        height=0.3,
    ),
    "weight": _symbol(
        _box(-0.68, -0.72, 0.68, 0.72),
        _line(-0.5, 0.3, 0.4, 0.3),
        _oval(-0.5, 0.3, 0.1),
        _line(0.4, 0.3, 0.4, -0.6),
        _head(0.4, -0.6, -90),
        reach=0.68,
        height=0.72,
    ),
    "clutch": _symbol(*_LEADS, *_PLATES, reach=0.6),
    "dog": _symbol(
        *_LEADS,
        _line(-0.3, -0.5, -0.3, 0.5),
        _line(0.3, -0.5, 0.3, 0.5),
        *(_box(-0.3, y, 0.05, y + 0.2, GREY) for y in (-0.5, 0.05)),
        *(_box(-0.05, y, 0.3, y + 0.2, GREY) for y in (-0.23, 0.32)),
        reach=0.6,
    ),
    "freewheel": _symbol(
        *_LEADS, *_PLATES, _line(-0.5, 0.75, 0.4, 0.75), _head(0.5, 0.75, 0), reach=0.6
    ),
    "brake": _symbol(
        _box(-0.1, -0.5, 0.1, 0.5, GREY),
        _line(-0.6, 0, -0.1, 0),
        _line(0.1, 0, 0.6, 0),
        _box(-0.35, 0.3, -0.14, 0.6, BLACK),
        _box(0.14, 0.3, 0.35, 0.6, BLACK),
        reach=0.6,
        height=0.6,
    ),
    "bearing": _symbol(
        _line(-0.6, 0, 0.6, 0),
        _box(-0.35, 0.06, 0.35, 0.28, GREY),
        _box(-0.35, -0.28, 0.35, -0.06, GREY),
        *_hatch(-0.45, 0.45, -0.42),
        reach=0.6,
        height=0.45,
    ),
    "friction": _symbol(
        _box(-0.55, 0, 0.55, 0.3, GREY),
        _box(-0.55, -0.3, 0.55, 0, GREY),
        _line(-0.35, -0.05, -0.15, 0.05),
        _line(0.1, -0.05, 0.3, 0.05),
        reach=0.55,
        height=0.3,
    ),
    "play": _symbol(
        _line(-0.7, 0, -0.15, 0),
        _line(-0.15, -0.3, -0.15, 0.3),
        _line(-0.35, 0.45, 0.2, 0.45, 0.2, -0.45, -0.35, -0.45),
        _line(0.2, 0, 0.7, 0),
        reach=0.7,
        height=0.45,
    ),
    "stop": _symbol(
        _line(-0.7, 0, -0.05, 0),
        _line(-0.05, -0.25, -0.05, 0.25),
        *_wall(0.35, -0.5, 0.5),
        _line(0.35, 0, 0.7, 0),
        reach=0.7,
        height=0.5,
    ),
    "mass_stops": _symbol(
        _box(-0.4, -0.35, 0.4, 0.35, GREY),
        _line(-0.7, -0.55, -0.7, 0.55),
        _line(0.7, -0.55, 0.7, 0.55),
        _line(-0.7, 0, -0.4, 0),
        _line(0.4, 0, 0.7, 0),
        reach=0.7,
    ),
    "pick_up": _symbol(
        _box(-0.35, -0.1, 0.35, 0.5, GREY),
        _line(-0.6, -0.1, 0.6, -0.1),
        *_hatch(-0.5, 0.5, -0.4),
        reach=0.6,
    ),
    "motor": _round("M"),
    "torque": _symbol(
        _arc(0, 0, 0.5, -60, 200), _head(0.25, -0.43, -150), _oval(0, 0, 0.1), reach=0.55
    ),
    "force": _symbol(_line(-0.6, 0, 0.45, 0), _head(0.6, 0, 0, 0.35), reach=0.6, height=0.2),
    "motion": _symbol(
        _oval(0, 0, 0.55), _line(-0.3, 0, 0.2, 0), _head(0.35, 0, 0), reach=0.55, height=0.55
    ),
    "fixed": _symbol(_line(0, 0.35, 0, 0), *_hatch(-0.55, 0.55, 0.0, 0.25), reach=0.0, height=0.35),
    "load": _symbol(
        _arc(0, 0, 0.5, -60, 200),
        _head(0.25, -0.43, -150),
        _line(-0.25, -0.2, 0.3, 0.25),
        reach=0.55,
    ),
    "eddy": _symbol(_oval(0, 0, 0.12, 0.6, GREY), _box(-0.4, 0.2, 0.4, 0.5), reach=0.4),
    "sensor": _symbol(_oval(0, 0, 0.45), _line(0, 0, 0.25, 0.3), reach=0.45, height=0.45),
    "vehicle": _symbol(
        _box(-0.75, -0.15, 0.75, 0.45, GREY),
        _oval(-0.42, -0.3, 0.22),
        _oval(0.42, -0.3, 0.22),
        reach=0.75,
        height=0.5,
    ),
    "wheel": _symbol(
        _oval(0, 0.1, 0.55, fill=GREY),
        _oval(0, 0.1, 0.3),
        *_hatch(-0.65, 0.65, -0.45),
        reach=0.7,
        height=0.65,
    ),
    "synchroniser": _symbol(
        *_LEADS,
        Stroke([(-0.3, -0.55), (0.05, -0.35), (0.05, 0.35), (-0.3, 0.55), (-0.3, -0.55)], GREY),
        Stroke([(-0.1, -0.62), (0.3, -0.4), (0.3, 0.4), (-0.1, 0.62)]),
        _line(0.3, 0.0, 0.6, 0.0),
        reach=0.6,
        height=0.62,
    ),
    "coil": _symbol(
        _oval(0, 0, 0.7, fill=GREY), _oval(0, 0, 0.48), _oval(0, 0, 0.24), reach=0.7, height=0.7
    ),
    "strip": _symbol(
        _line(-0.75, 0.08, 0.75, 0.08), _line(-0.75, -0.08, 0.75, -0.08), reach=0.75, height=0.1
    ),
    "rolls": _symbol(
        _oval(0, 0.36, 0.33, fill=GREY),
        _oval(0, -0.36, 0.33, fill=GREY),
        _line(-0.7, 0, 0.7, 0),
        reach=0.7,
        height=0.7,
    ),
    "resistor": _symbol(_box(-0.5, -0.2, 0.5, 0.2), reach=0.5, height=0.2),
    "inductor": _symbol(_box(-0.5, -0.2, 0.5, 0.2, BLACK), reach=0.5, height=0.2),
    "capacitor": _symbol(
        _line(-0.1, -0.45, -0.1, 0.45),
        _line(0.1, -0.45, 0.1, 0.45),
        _line(-0.5, 0, -0.1, 0),
        _line(0.1, 0, 0.5, 0),
        reach=0.5,
        height=0.45,
    ),
    "voltage": _symbol(_oval(0, 0, 0.45), _line(-0.45, 0, 0.45, 0), reach=0.45, height=0.45),
    "current": _symbol(_oval(0, 0, 0.45), _line(0, -0.45, 0, 0.45), reach=0.45, height=0.45),
    "meter_v": _symbol(_oval(0, 0, 0.45), reach=0.45, height=0.45, text="V"),
    "meter_a": _symbol(_oval(0, 0, 0.45), reach=0.45, height=0.45, text="A"),
    "earth": _symbol(
        _line(0, 0.3, 0, 0),
        _line(-0.4, 0, 0.4, 0),
        _line(-0.25, -0.14, 0.25, -0.14),
        _line(-0.1, -0.28, 0.1, -0.28),
        reach=0.0,
        height=0.3,
    ),
    "inverter": _symbol(_box(-0.65, -0.6, 0.65, 0.6), _line(-0.65, -0.6, 0.65, 0.6), reach=0.65),
    "heat_capacity": _block("C"),
    "heat_flow": _block("Q"),
    "temperature": _block("T"),
    "gain": _symbol(
        Stroke([(-0.5, -0.55), (0.55, 0), (-0.5, 0.55), (-0.5, -0.55)], WHITE), reach=0.5
    ),
    "sum": _round("+"),
    "controller": _block("PI"),
    "proportional": _block("P"),
    "limiter": _axes(_line(-0.55, -0.4, -0.25, -0.4, 0.25, 0.4, 0.55, 0.4)),
    "ramp": _axes(_line(-0.5, -0.4, -0.2, -0.4, 0.4, 0.4)),
    "lag": _axes(Stroke([(0.1 * i - 0.5, 0.85 * (1 - 0.72**i) - 0.4) for i in range(11)])),
    "stairs": _axes(_line(-0.5, -0.4, -0.2, -0.4, -0.2, 0.0, 0.15, 0.0, 0.15, 0.4, 0.5, 0.4)),
    "step": _axes(_line(-0.5, -0.35, 0, -0.35, 0, 0.35, 0.5, 0.35)),
    "constant": _axes(_line(-0.5, 0, 0.5, 0)),
    "sine": _axes(
        Stroke([(0.05 * i - 0.5, 0.4 * float(np.sin(np.pi * i / 10))) for i in range(21)])
    ),
    "table": _axes(_line(-0.5, -0.4, -0.2, 0.1, 0.15, 0.0, 0.5, 0.4)),
    "switch": _axes(
        _line(-0.5, 0.25, -0.25, 0.25),
        _line(-0.5, -0.25, -0.25, -0.25),
        _line(-0.25, 0.25, 0.25, 0),
        _line(0.25, 0, 0.5, 0),
    ),
    "root": _block("\u221a"),
    "integral": _block("\u222b"),
    "minimum": _block("min"),
    "latch": _block("latch"),
    "sequence": _block("1 2 3"),
    "function": _block("f(t)"),
}
