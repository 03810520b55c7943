"""Scalar laws with kinks and jumps, for `lumped` and in pieces for SciPy.

A law is a tree. Each node that is not smooth has an argument, borders, and a formula for each
piece between borders. The reference keeps the pieces while it integrates, looks for the border
that an argument crosses first, and changes that piece only.
"""

import operator
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import DOP853
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from lumped import ops

RELATIONS = {">": operator.gt, ">=": operator.ge, "<": operator.lt, "<=": operator.le}
AHEAD = 1e-7
"""Time after which pieces are chosen at the start, s."""


class ChatterError(Exception):
    """The law changes its piece again and again at practically one instant."""


@dataclass
class Law:
    """Numbers of a law in its pieces.

    `formula(at)` evaluates it at a `Place`; `nodes` are (argument, borders) of all that is not
    smooth in it, inner ones first.
    """

    formula: Callable
    nodes: list = field(default_factory=list)


@dataclass
class Place:
    t: float
    phi: float
    w: float
    pieces: list


def numbers(tree: tuple) -> Law:
    """The law in pieces."""
    law = Law(lambda at: 0.0)
    law.formula = _formula(tree, law.nodes)
    return law


def _formula(tree: tuple, nodes: list) -> Callable:
    kind, *rest = tree
    if kind == "number":
        return lambda at: rest[0]
    if kind in ("t", "phi", "w"):
        return lambda at: getattr(at, kind)
    if kind == "table":
        ts, ys = rest
        return _piece(nodes, lambda at: at.t, ts, [ys[0], *_lines(ts, ys), ys[-1]])
    if kind == "spline":
        x, ys = _formula(rest[0], nodes), rest[1]
        curve = CubicSpline(np.linspace(0, 2 * np.pi, len(ys)), ys, bc_type="periodic")
        return lambda at: float(curve(x(at) % (2 * np.pi)))
    if kind == "interpolate":
        x, (xs, ys) = _formula(rest[0], nodes), rest[1:]
        return _piece(nodes, x, xs[1:-1], _lines(xs, ys))
    parts = [_formula(part, nodes) for part in rest if isinstance(part, tuple)]
    if kind == "scale":
        return lambda at: rest[0] * parts[0](at)
    if kind == "where":
        a, b, yes, no = parts
        above = [no, yes] if rest[0].startswith(">") else [yes, no]
        return _piece(nodes, lambda at: a(at) - b(at), [0.0], [(0.0, f) for f in above])
    a, b = parts[0], parts[-1]
    if kind == "+":
        return lambda at: a(at) + b(at)
    if kind == "*":
        return lambda at: a(at) * b(at)
    if kind in ("sin", "cos", "tanh"):
        return lambda at: float(getattr(np, kind)(a(at)))
    if kind == "abs":
        return _piece(nodes, a, [0.0], [(-1.0, 0.0), (1.0, 0.0)])
    if kind == "sign":
        return _piece(nodes, a, [0.0], [-1.0, 1.0])
    first, second = (a, b) if kind == "minimum" else (b, a)
    return _piece(nodes, lambda at: a(at) - b(at), [0.0], [(0.0, first), (0.0, second)])


def _lines(xs: list, ys: list) -> list:
    """Slope and value at zero of each line; of a jump nothing."""
    found = []
    for i in range(len(xs) - 1):
        slope = (ys[i + 1] - ys[i]) / (xs[i + 1] - xs[i])
        found.append((slope, ys[i] - slope * xs[i]))
    return found


def _piece(nodes: list, x: Callable, borders: list, rows: list) -> Callable:
    """A node: each row is a number, or a slope by the argument and a number or formula."""
    k = len(nodes)
    nodes.append((x, borders))

    def value(at):
        row = rows[at.pieces[k]]
        if not isinstance(row, tuple):
            return row
        slope, rest = row
        return slope * x(at) + (rest(at) if callable(rest) else rest)

    return value


def expression(tree: tuple, t, phi, w):
    """The law as an expression of `lumped`."""
    kind, *rest = tree
    if kind == "number":
        return rest[0]
    if kind in ("t", "phi", "w"):
        return {"t": t, "phi": phi, "w": w}[kind]
    if kind == "table":
        return ops.table(*rest)
    parts = [expression(part, t, phi, w) for part in rest if isinstance(part, tuple)]
    if kind == "spline":
        return ops.periodic_spline(parts[0], np.linspace(0, 2 * np.pi, len(rest[1])), rest[1])
    if kind == "interpolate":
        return ops.interpolate(parts[0], rest[1], rest[2])
    if kind == "scale":
        return rest[0] * parts[0]
    if kind == "where":
        return ops.where(RELATIONS[rest[0]](parts[0], parts[1]), *parts[2:])
    if kind == "+":
        return parts[0] + parts[1]
    if kind == "*":
        return parts[0] * parts[1]
    if kind == "abs":
        return abs(parts[0])
    return getattr(ops, kind)(*parts)


def settle(law: Law, at: Place, fixed: int | None = None) -> None:
    """The pieces in which all arguments lie, one of them given; inner nodes come first."""
    for k, (x, borders) in enumerate(law.nodes):
        if k != fixed:
            at.pieces[k] = int(np.searchsorted(borders, x(at)))


def motion(law: Law, J: float, d: float, start: tuple, grid: np.ndarray, rtol=1e-10):
    """Angle and speed of ``J der(w) == law - d w`` on the grid, and the instants of crossings."""
    y, t, end, events, out = np.array(start, float), 0.0, grid[-1], [], []

    def place(t, y, pieces):
        return Place(t, y[0], y[1], pieces)

    def rate(t, y):
        return np.array([y[1], (law.formula(place(t, y, pieces)) - d * y[1]) / J])

    def margins(t, y):
        at, found = place(t, y, pieces), []
        for k, (x, borders) in enumerate(law.nodes):
            value, piece = x(at), pieces[k]
            found.append(value - borders[piece - 1] if piece else np.inf)
            found.append(borders[piece] - value if piece < len(borders) else np.inf)
        return np.array(found)

    pieces = [0] * len(law.nodes)
    settle(law, place(t, y, pieces))
    settle(law, place(AHEAD, y + AHEAD * rate(t, y), pieces))
    while t < end:
        solver = DOP853(rate, t, y, end, 0.02, rtol, rtol * 1e-2, first_step=min(1e-6, end - t))
        before, crossed = margins(t, y), None
        while solver.status == "running" and crossed is None:
            solver.step()
            if solver.status == "failed":
                raise ChatterError
            curve, begin, last = solver.dense_output(), solver.t_old, solver.t
            for now in np.linspace(begin, last, 11)[1:]:
                values = margins(now, curve(now))
                passed = np.flatnonzero((before > 0) & (values < 0))
                if len(passed):
                    times = [_zero(margins, curve, k, begin, now) for k in passed]
                    last, crossed = min(times), int(passed[np.argmin(times)])
                    break
                begin, before = now, values
            out += [curve(at) for at in grid if solver.t_old <= at < last]
        if crossed is None:
            break
        t, y = last, curve(last)
        k, side = divmod(crossed, 2)
        pieces[k] += 1 if side else -1
        settle(law, place(t, y, pieces), k)
        # others may be at their border, too
        settle(law, place(t + AHEAD, y + AHEAD * rate(t, y), pieces), k)
        ahead = rate(t, y)
        x, borders = law.nodes[k]
        # must the argument go on across the border, or does the new piece send it back?
        later = x(place(t + AHEAD, y + AHEAD * ahead, pieces))
        if (later > borders[pieces[k] - side]) != bool(side):
            raise ChatterError
        events.append(t)
        if len(events) > 300 or (len(events) > 3 and events[-1] - events[-4] < 1e-5):
            raise ChatterError
    return np.array([*out, solver.y]), events


def _zero(margins, curve, k, begin, end):
    return brentq(lambda t: margins(t, curve(t))[k], begin, end, xtol=1e-15)
