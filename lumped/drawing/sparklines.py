"""Small pictures in lines of tables: curves, bars, spread, as inline SVG."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from lumped.support.arrays import Integer, Real

BLUE, RED = "#3d8fd1", "#d9603b"
"""Both read on white and on black."""
_WIDTH, _HEIGHT = 160, 28
_BINS, _POINTS, _CURVES = 24, 200, 8


def curve(t: Real, y: Real, marks: Sequence[float] = ()) -> str:
    """A curve over its whole range, with thin lines at some instants."""
    return curves(t, [y], "", marks=marks)


def curves(
    t: Real,
    ys: Sequence[Real],
    title: str,
    size: tuple[int, int] = (_WIDTH, _HEIGHT),
    marks: Sequence[float] = (),
) -> str:
    """Curves in one range; those beyond eight are left out."""
    width, height = size
    shown = [np.asarray(y, dtype=float) for y in ys[:_CURVES]]
    good = np.concatenate([y[np.isfinite(y)] for y in shown] or [np.zeros(0)])
    if not len(t) or not len(good):
        return ""
    low, high = float(good.min()), float(good.max())
    span, length = high - low or 1.0, float(t[-1] - t[0]) or 1.0
    level = 0.5 * (height - 4) if high == low else 0.0
    parts = []
    for mark in marks[:_POINTS]:
        x = (mark - t[0]) / length * (width - 4) + 2
        parts.append(f'<path d="M{x:.1f} 0V{height}" stroke="currentColor" opacity=".3"/>')
    for k, y in enumerate(shown):
        rows = _thin(y)
        xs = (t[rows] - t[0]) / length * (width - 4) + 2
        heights = height - 2 - level - (y[rows] - low) / span * (height - 4)
        there = np.isfinite(heights)
        points = " ".join(
            f"{a:.1f},{b:.1f}" for a, b in zip(xs[there], heights[there], strict=True)
        )
        shade = 1 - 0.8 * k / _CURVES
        parts.append(
            f'<polyline points="{points}" fill="none" stroke="{BLUE}" stroke-width="1.3" '
            f'opacity="{shade:.2f}"/>'
        )
    return _svg(width, height, title, parts)


def _thin(y: Real) -> Integer:
    """Places of the least and greatest value of each of some hundred stretches."""
    if len(y) <= 2 * _POINTS:
        return np.arange(len(y))
    places = [0, len(y) - 1]
    for part in np.array_split(np.arange(len(y)), _POINTS):
        own = np.where(np.isfinite(y[part]), y[part], 0.0)
        places += [int(part[own.argmin()]), int(part[own.argmax()])]
    return np.unique(places)


def stems(values: Sequence[float]) -> str:
    """Signed bars side by side, such as the amplitudes of a shape."""
    largest = max(map(abs, values), default=0.0) or 1.0
    step, middle, parts = _WIDTH / max(len(values), 1), _HEIGHT / 2, []
    for i, value in enumerate(values):
        size = abs(value) / largest * (middle - 1)
        top = middle - size if value > 0 else middle
        colour = BLUE if value > 0 else RED
        parts.append(_bar(i * step + 0.15 * step, top, 0.7 * step, max(size, 0.3), colour))
    parts.append(f'<path d="M0 {middle}H{_WIDTH}" stroke="currentColor" opacity=".4"/>')
    return _svg(_WIDTH, _HEIGHT, "", parts)


def share(value: float, most: float, limit: float | None = None) -> str:
    """A bar from the middle for a signed share, or from the left against a limit."""
    if not np.isfinite(value) or not most:
        return ""
    if limit is None:
        half = _WIDTH / 2
        size = min(abs(value) / most, 1.0) * half
        left, colour = (half, BLUE) if value > 0 else (half - size, RED)
        line = half
    else:
        size, left = min(value / most, 1.0) * _WIDTH, 0.0
        line, colour = limit / most * _WIDTH, BLUE if value <= limit else RED
    mark = f'<path d="M{line:.1f} 0V14" stroke="currentColor" opacity=".6"/>'
    return _svg(_WIDTH, 14, "", [_bar(left, 2, size, 10, colour), mark])


def spread(values: Real) -> str:
    """A histogram."""
    good = values[np.isfinite(values)]
    if not len(good):
        return ""
    counts = np.histogram(good, _BINS)[0]
    step = _WIDTH / _BINS
    heights = counts / counts.max() * (_HEIGHT - 1)
    parts = [
        _bar(i * step, _HEIGHT - h, step - 0.6, h, BLUE)
        for i, h in enumerate(heights.tolist())
        if h
    ]
    return _svg(_WIDTH, _HEIGHT, "", parts)


def _bar(x: float, y: float, width: float, height: float, colour: str) -> str:
    size = f'width="{width:.1f}" height="{height:.1f}"'
    return f'<rect x="{x:.1f}" y="{y:.1f}" {size} fill="{colour}"/>'


def _svg(width: int, height: int, title: str, parts: Sequence[str]) -> str:
    told = f' aria-label="{escape(title, quote=True)}"' if title else ""
    return (
        f'<svg role="img"{told} width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        f'style="vertical-align:middle">{"".join(parts)}</svg>'
    )
