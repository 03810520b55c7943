"""Symbols of drive engineering as polylines in a square from -1 to 1, y upwards.

A component class names its symbol (``symbol = "inertia"``); without one it is a box. The shaft
comes in from the left and goes out to the right at ``y = 0``.
"""

from __future__ import annotations

import numpy as np

from lumped.drawing.strokes import (
    BLACK,
    GREY,
    WHITE,
    Stroke,
    Symbol,
    arc,
    axes,
    block,
    box,
    hatch,
    head,
    line,
    oval,
    pot,
    round_symbol,
    symbol,
    wall,
    zigzag,
)

_SPRING = [line(-0.7, 0, -0.55, 0), zigzag(-0.55, 0.55, 0, 0.3), line(0.55, 0, 0.7, 0)]
_PLATES = (box(-0.3, -0.6, -0.12, 0.6, GREY), box(0.12, -0.6, 0.3, 0.6, GREY))
_LEADS = (line(-0.6, 0, -0.3, 0), line(0.3, 0, 0.6, 0))
_DIAGONALS = [(x, y) for x in (-0.7, 0.7) for y in (-0.7, 0.7)]

GROUND = (line(0, 0.2, 0, 0), *hatch(-0.4, 0.4, 0.0))
"""Fixed housing below a port."""

SYMBOLS: dict[str, Symbol] = {
    "box": symbol(box(-1.15, -0.55, 1.15, 0.55)),
    "port": symbol(oval(0, 0, 0.16)),
    "inertia": symbol(box(-0.2, -0.75, 0.2, 0.75, GREY)),
    "mass": symbol(box(-0.6, -0.45, 0.6, 0.45, GREY)),
    "strut": symbol(box(-0.75, -0.08, 0.75, 0.08, GREY), height=0.1),
    "spring": symbol(*_SPRING),
    "damper": symbol(*pot(0.0)),
    "spring_damper": symbol(
        line(-0.7, 0.4, -0.5, 0.4),
        zigzag(-0.5, 0.5, 0.4, 0.22),
        line(0.5, 0.4, 0.7, 0.4),
        *pot(-0.35),
        line(-0.7, -0.35, -0.7, 0.4),
        line(0.7, -0.35, 0.7, 0.4),
    ),
    "gear": symbol(
        line(-0.6, 0, -0.26, 0),
        line(0.26, 0, 0.6, 0),
        box(-0.26, -0.75, -0.02, 0.3, GREY),
        box(0.02, -0.3, 0.26, 0.75, GREY),
        line(-0.26, 0, 0.26, 0),
    ),
    "gearbox": symbol(
        box(-0.65, -0.7, 0.65, 0.7),
        line(-0.65, -0.15, -0.05, -0.15),
        line(0.05, 0.15, 0.65, 0.15),
        box(-0.42, -0.5, -0.24, 0.2, GREY),
        box(0.24, -0.2, 0.42, 0.5, GREY),
        line(-0.24, 0.1, 0.24, 0.1),
    ),
    "belt": symbol(
        line(-0.45, 0.3, 0.45, 0.42),
        line(-0.45, -0.3, 0.45, -0.42),
        oval(-0.45, 0, 0.3, fill=GREY),
        oval(0.45, 0, 0.42, fill=GREY),
        reach=0.75,
        height=0.5,
    ),
    "variator": symbol(
        Stroke([(-0.6, -0.7), (-0.6, 0.2), (-0.1, 0.7), (-0.1, -0.2), (-0.6, -0.7)], GREY),
        Stroke([(0.1, -0.7), (0.1, 0.2), (0.6, 0.7), (0.6, -0.2), (0.1, -0.7)], GREY),
        line(-0.1, 0.45, 0.35, 0.45),
        line(-0.35, -0.45, 0.1, -0.45),
    ),
    "bevel": symbol(
        Stroke([(-0.45, -0.3), (-0.15, -0.6), (-0.15, 0.6), (-0.45, 0.3), (-0.45, -0.3)], GREY),
        Stroke([(-0.05, 0.7), (0.55, 0.7), (0.25, 0.4), (0.05, 0.4), (-0.05, 0.7)], GREY),
        line(0.25, 0.4, 0.25, 0.0, 0.6, 0.0),
    ),
    "ellipses": symbol(
        oval(-0.38, 0, 0.38, 0.6, GREY), oval(0.32, 0, 0.32, 0.7, GREY), reach=0.7, height=0.6
    ),
    "planetary": symbol(
        oval(0, 0, 0.75),
        oval(0, 0, 0.25, fill=GREY),
        *(oval(0.5 * x, 0.5 * y, 0.22, fill=GREY) for x, y in ((0, 1), (0.87, -0.5))),
        oval(-0.435, -0.25, 0.22, fill=GREY),
        has_letters=True,  # sun, carrier and ring
    ),
    "harmonic_drive": symbol(
        oval(0, 0, 0.75), oval(0, 0, 0.72, 0.58), oval(0, 0, 0.6, 0.45, GREY), has_letters=True
    ),
    "rack": symbol(
        oval(0, 0.15, 0.5, fill=GREY), box(-0.8, -0.6, 0.8, -0.35, GREY), line(-0.8, 0, -0.45, 0)
    ),
    "screw": symbol(
        box(-0.75, -0.15, 0.75, 0.15),
        *(line(x, -0.15, x + 0.12, 0.15) for x in (-0.65, -0.45, 0.35, 0.55)),
        box(-0.25, -0.45, 0.25, 0.45, GREY),
        height=0.5,
    ),
    "worm": symbol(
        oval(0, -0.25, 0.5, fill=GREY),
        box(-0.6, 0.3, 0.6, 0.65),
        *(line(x, 0.3, x + 0.12, 0.65) for x in (-0.5, -0.25, 0.0, 0.25)),
        height=0.7,
    ),
    "cam": symbol(
        oval(-0.2, 0, 0.45, 0.4, GREY),
        oval(-0.35, 0, 0.08),
        line(0.25, -0.35, 0.25, 0.35),
        line(0.25, 0, 0.75, 0),
        reach=0.75,
        height=0.5,
    ),
    "geneva": symbol(
        oval(-0.45, 0, 0.3),
        line(-0.45, 0, -0.2, 0.2),
        oval(-0.2, 0.2, 0.07, fill=BLACK),
        oval(0.35, 0, 0.4, fill=GREY),
        *(line(0.35 + 0.4 * x, 0.4 * y, 0.35 + 0.12 * x, 0.12 * y) for x, y in _DIAGONALS),
        reach=0.75,
        height=0.5,
    ),
    "crank": symbol(
        box(-0.8, -0.6, 0.98, 0.68),
        oval(-0.5, -0.1, 0.13),
        line(-0.5, -0.1, -0.15, 0.5),
        oval(-0.15, 0.5, 0.06),
        line(-0.15, 0.5, 0.5, -0.1),
        box(0.3, -0.27, 0.75, 0.07, GREY),
        *hatch(0.1, 0.9, -0.32, 0.12),
        reach=0.8,
        height=0.6,
    ),
    "arm": symbol(
        box(-0.68, -0.72, 0.68, 0.72),
        line(-0.4, -0.4, 0.35, 0.4),
        oval(-0.4, -0.4, 0.14),
        oval(0.35, 0.4, 0.2, fill=GREY),
    ),
    "ring_damper": symbol(
        line(-0.7, 0.0, -0.1, 0.0),
        *(
            part
            for y in (-1, 1)
            for part in (
                line(-0.1, 0.0, -0.1, 0.15 * y, -0.4, 0.15 * y, -0.4, 0.75 * y, 0.4, 0.75 * y),
                line(0.4, 0.75 * y, 0.4, 0.15 * y, 0.1, 0.15 * y, 0.1, 0.0),
                box(-0.25, 0.28 * y, 0.25, 0.62 * y, GREY),
            )
        ),
        line(-0.1, 0.0, 0.1, 0.0),
    ),
    "pendulum": symbol(
        oval(0, -0.12, 0.55),
        oval(0, -0.12, 0.1, fill=WHITE),
        oval(0, 0.18, 0.06, fill=BLACK),
        line(0, 0.18, 0.25, 0.62),
        oval(0.25, 0.62, 0.14, fill=GREY),
    ),
    "cardan": symbol(
        line(-0.7, 0, -0.4, 0),
        line(0, 0.35, -0.4, 0.35, -0.4, -0.35, 0, -0.35),
        line(0, 0.35, 0, -0.35),
        oval(0, 0, 0.12, fill=BLACK),
        line(0, 0, 0.7, 0),
    ),
    "rod": symbol(
        box(-0.68, -0.72, 0.68, 0.72),
        line(-0.35, 0.5, 0.35, -0.5),
        oval(-0.35, 0.5, 0.12),
        oval(0.35, -0.5, 0.12),
    ),
    "shaft": symbol(box(-0.75, -0.16, 0.75, 0.16, GREY)),
    "stepped_shaft": symbol(
        box(-0.75, -0.16, -0.25, 0.16, GREY),
        box(-0.25, -0.32, 0.3, 0.32, GREY),
        box(0.3, -0.22, 0.75, 0.22, GREY),
    ),
    "taper": symbol(
        Stroke([(-0.75, -0.14), (0.75, -0.34), (0.75, 0.34), (-0.75, 0.14), (-0.75, -0.14)], GREY)
    ),
    "notch": symbol(
        Stroke(
            [
                *((-0.6, 0.3), (-0.12, 0.3), (0.0, 0.12), (0.12, 0.3), (0.6, 0.3)),
                *((0.6, -0.3), (0.12, -0.3), (0.0, -0.12), (-0.12, -0.3), (-0.6, -0.3)),
                (-0.6, 0.3),
            ],
            GREY,
        )
    ),
    "weight": symbol(
        box(-0.68, -0.72, 0.68, 0.72),
        line(-0.5, 0.3, 0.4, 0.3),
        oval(-0.5, 0.3, 0.1),
        line(0.4, 0.3, 0.4, -0.6),
        head(0.4, -0.6, -90),
    ),
    "clutch": symbol(*_LEADS, *_PLATES),
    "converter": symbol(
        oval(0, 0, 0.75),
        line(-0.75, 0, -0.15, 0),
        arc(-0.12, 0, 0.5, 100, 260),
        arc(0.12, 0, 0.5, -80, 80),
        line(0.15, 0, 0.75, 0),
    ),
    "dog": symbol(
        *_LEADS,
        line(-0.3, -0.5, -0.3, 0.5),
        line(0.3, -0.5, 0.3, 0.5),
        *(box(-0.3, y, 0.05, y + 0.2, GREY) for y in (-0.5, 0.05)),
        *(box(-0.05, y, 0.3, y + 0.2, GREY) for y in (-0.23, 0.32)),
        height=0.6,
    ),
    "freewheel": symbol(
        *_LEADS, *_PLATES, line(-0.5, 0.75, 0.4, 0.75), head(0.5, 0.75, 0), height=0.6
    ),
    "brake": symbol(
        box(-0.1, -0.5, 0.1, 0.5, GREY),
        line(-0.6, 0, -0.1, 0),
        line(0.1, 0, 0.6, 0),
        box(-0.35, 0.3, -0.14, 0.6, BLACK),
        box(0.14, 0.3, 0.35, 0.6, BLACK),
    ),
    "bearing": symbol(
        line(-0.6, 0, 0.6, 0),
        box(-0.35, 0.06, 0.35, 0.28, GREY),
        box(-0.35, -0.28, 0.35, -0.06, GREY),
        *hatch(-0.45, 0.45, -0.42),
        height=0.45,
    ),
    "friction": symbol(
        box(-0.55, 0, 0.55, 0.3, GREY),
        box(-0.55, -0.3, 0.55, 0, GREY),
        line(-0.35, -0.05, -0.15, 0.05),
        line(0.1, -0.05, 0.3, 0.05),
    ),
    "play": symbol(
        line(-0.7, 0, -0.15, 0),
        line(-0.15, -0.3, -0.15, 0.3),
        line(-0.35, 0.45, 0.2, 0.45, 0.2, -0.45, -0.35, -0.45),
        line(0.2, 0, 0.7, 0),
    ),
    "stop": symbol(
        line(-0.7, 0, -0.05, 0),
        line(-0.05, -0.25, -0.05, 0.25),
        *wall(0.35, -0.5, 0.5),
        line(0.35, 0, 0.7, 0),
    ),
    "mass_stops": symbol(
        box(-0.4, -0.35, 0.4, 0.35, GREY),
        line(-0.7, -0.55, -0.7, 0.55),
        line(0.7, -0.55, 0.7, 0.55),
        line(-0.7, 0, -0.4, 0),
        line(0.4, 0, 0.7, 0),
        height=0.6,
    ),
    "pick_up": symbol(
        box(-0.35, -0.1, 0.35, 0.5, GREY),
        line(-0.6, -0.1, 0.6, -0.1),
        *hatch(-0.5, 0.5, -0.4),
        height=0.6,
    ),
    "motor": round_symbol("M"),
    "torque": symbol(
        arc(0, 0, 0.5, -60, 200), head(0.25, -0.43, -150), oval(0, 0, 0.1), reach=0.55, height=0.6
    ),
    "force": symbol(line(-0.6, 0, 0.45, 0), head(0.6, 0, 0, 0.35), height=0.2),
    "motion": symbol(oval(0, 0, 0.55), line(-0.3, 0, 0.2, 0), head(0.35, 0, 0)),
    "fixed": symbol(line(0, 0.35, 0, 0), *hatch(-0.55, 0.55, 0.0, 0.25), reach=0.0),
    "load": symbol(
        arc(0, 0, 0.5, -60, 200),
        head(0.25, -0.43, -150),
        line(-0.25, -0.2, 0.3, 0.25),
        reach=0.55,
        height=0.6,
    ),
    "eddy": symbol(oval(0, 0, 0.12, 0.6, GREY), box(-0.4, 0.2, 0.4, 0.5)),
    "sensor": symbol(oval(0, 0, 0.45), line(0, 0, 0.25, 0.3)),
    "vehicle": symbol(
        box(-0.75, -0.15, 0.75, 0.45, GREY),
        oval(-0.42, -0.3, 0.22),
        oval(0.42, -0.3, 0.22),
        height=0.5,
    ),
    "wheel": symbol(
        oval(0, 0.1, 0.55, fill=GREY), oval(0, 0.1, 0.3), *hatch(-0.65, 0.65, -0.45), reach=0.7
    ),
    "synchroniser": symbol(
        *_LEADS,
        Stroke([(-0.3, -0.55), (0.05, -0.35), (0.05, 0.35), (-0.3, 0.55), (-0.3, -0.55)], GREY),
        Stroke([(-0.1, -0.62), (0.3, -0.4), (0.3, 0.4), (-0.1, 0.62)]),
        line(0.3, 0.0, 0.6, 0.0),
    ),
    "coil": symbol(oval(0, 0, 0.7, fill=GREY), oval(0, 0, 0.48), oval(0, 0, 0.24)),
    "strip": symbol(line(-0.75, 0.08, 0.75, 0.08), line(-0.75, -0.08, 0.75, -0.08), height=0.1),
    "rolls": symbol(
        oval(0, 0.36, 0.33, fill=GREY),
        oval(0, -0.36, 0.33, fill=GREY),
        line(-0.7, 0, 0.7, 0),
        height=0.7,
    ),
    "resistor": symbol(box(-0.5, -0.2, 0.5, 0.2)),
    "inductor": symbol(box(-0.5, -0.2, 0.5, 0.2, BLACK)),
    "capacitor": symbol(
        line(-0.1, -0.45, -0.1, 0.45),
        line(0.1, -0.45, 0.1, 0.45),
        line(-0.5, 0, -0.1, 0),
        line(0.1, 0, 0.5, 0),
    ),
    "battery": symbol(
        line(-0.1, -0.45, -0.1, 0.45),
        line(0.1, -0.22, 0.1, 0.22),
        line(-0.5, 0, -0.1, 0),
        line(0.1, 0, 0.5, 0),
    ),
    "voltage": symbol(oval(0, 0, 0.45), line(-0.45, 0, 0.45, 0)),
    "current": symbol(oval(0, 0, 0.45), line(0, -0.45, 0, 0.45)),
    "meter_v": symbol(oval(0, 0, 0.45), text="V"),
    "meter_a": symbol(oval(0, 0, 0.45), text="A"),
    "earth": symbol(
        line(0, 0.3, 0, 0),
        line(-0.4, 0, 0.4, 0),
        line(-0.25, -0.14, 0.25, -0.14),
        line(-0.1, -0.28, 0.1, -0.28),
        reach=0.0,
    ),
    "inverter": symbol(box(-0.65, -0.6, 0.65, 0.6), line(-0.65, -0.6, 0.65, 0.6)),
    "heat_capacity": block("C"),
    "heat_flow": block("Q"),
    "temperature": block("T"),
    "gain": symbol(
        Stroke([(-0.5, -0.55), (0.55, 0), (-0.5, 0.55), (-0.5, -0.55)], WHITE),
        reach=0.5,
        height=0.6,
    ),
    "sum": round_symbol("+"),
    "controller": block("PI"),
    "proportional": block("P"),
    "limiter": axes(line(-0.55, -0.4, -0.25, -0.4, 0.25, 0.4, 0.55, 0.4)),
    "ramp": axes(line(-0.5, -0.4, -0.2, -0.4, 0.4, 0.4)),
    "lag": axes(Stroke([(0.1 * i - 0.5, 0.85 * (1 - 0.72**i) - 0.4) for i in range(11)])),
    "stairs": axes(line(-0.5, -0.4, -0.2, -0.4, -0.2, 0.0, 0.15, 0.0, 0.15, 0.4, 0.5, 0.4)),
    "step": axes(line(-0.5, -0.35, 0, -0.35, 0, 0.35, 0.5, 0.35)),
    "constant": axes(line(-0.5, 0, 0.5, 0)),
    "sine": axes(
        Stroke([(0.05 * i - 0.5, 0.4 * float(np.sin(np.pi * i / 10))) for i in range(21)])
    ),
    "table": axes(line(-0.5, -0.4, -0.2, 0.1, 0.15, 0.0, 0.5, 0.4)),
    "switch": axes(
        line(-0.5, 0.25, -0.25, 0.25),
        line(-0.5, -0.25, -0.25, -0.25),
        line(-0.25, 0.25, 0.25, 0),
        line(0.25, 0, 0.5, 0),
    ),
    "root": block("\u221a"),
    "integral": block("\u222b"),
    "minimum": block("min"),
    "latch": block("latch"),
    "sequence": block("1 2 3"),
    "function": block("f(t)"),
}
