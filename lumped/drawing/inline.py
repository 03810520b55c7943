"""Figures as parts of a page: self-contained SVG, and the places of its curves."""

from __future__ import annotations

import io
import json
import re
from html import escape
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lumped.errors import OptionError, shown

_DROPPED = re.compile(r"<\?xml.*?\?>|<!DOCTYPE.*?>|<metadata>.*?</metadata>", re.DOTALL)
_NAMES = re.compile(r'\sxmlns(:\w+)?="[^"]*"')
_IDS = re.compile(r'(\sid="|url\(#|href="#)')
_SIZE = re.compile(r'(<svg\b[^>]*?)\s(?:width|height)="[^"]*"')


def inline(figure: Figure, title: str, key: str) -> str:
    """A figure as an HTML element that the page's script can zoom.

    Parameters
    ----------
    figure : Figure
        Figure to show.
    title : str
        Its name, also for those who cannot see it.
    key : str
        Text that makes the names inside the picture unique on the page.

    Raises
    ------
    OptionError
        If it is no figure of matplotlib.
    """
    if not isinstance(figure, Figure):
        raise OptionError(
            f"figures[{title!r}] = {shown(figure)}: a figure of matplotlib is needed; plot without "
            "backend=."
        )
    named = {}
    axes = []
    for a, axis in enumerate(figure.axes):
        lines = [line for line in axis.lines if len(np.atleast_1d(line.get_xdata())) > 2]
        for i, line in enumerate(lines):
            named[line] = line.get_gid()
            line.set_gid(f"curve-{a}-{i}")
    text = as_svg(figure, key)
    for axis in figure.axes:
        if axis.get_visible() and axis.lines:
            axes.append(_axis(figure, axis, key))
    for line, gid in named.items():
        line.set_gid(gid)
    text = _SIZE.sub(r"\1", _SIZE.sub(r"\1", text, count=1), count=1)
    label = escape(title, quote=True)
    text = text.replace("<svg", f'<svg role="img" aria-label="{label}"', 1).strip()
    data = escape(json.dumps(axes), quote=True)
    return (
        f'<figure data-axes="{data}">\n{text}\n<figcaption>{escape(title)}</figcaption>\n</figure>'
    )


def as_svg(figure: Figure, key: str) -> str:
    """A figure as an SVG element; `key` makes the names inside it unique on a page."""
    target = io.StringIO()
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": key}):
        figure.savefig(target, format="svg", metadata={"Date": None})
    text = _NAMES.sub("", _DROPPED.sub("", target.getvalue()))
    return _IDS.sub(rf"\g<1>{key}-", text).strip()


def _axis(figure: Figure, axis: Axes, key: str) -> dict[str, Any]:
    """Place of the axes in the picture, in points from its top left corner."""
    width, height = 72 * figure.get_size_inches()
    place = axis.get_position()
    below = [axis, *axis.get_shared_x_axes().get_siblings(axis)]
    box = width * place.x0, height * (1 - place.y1), width * place.x1, height * (1 - place.y0)
    return {
        "box": list(map(float, box)),
        "x": list(map(float, axis.get_xlim())),
        "y": list(map(float, axis.get_ylim())),
        "logx": axis.get_xscale() == "log",
        "logy": axis.get_yscale() == "log",
        "xlabel": next((text for other in below if (text := other.get_xlabel())), ""),
        "ylabel": axis.get_ylabel(),
        "lines": [
            {"id": f"{key}-{gid}", "label": str(line.get_label()).lstrip("_")}
            for line in axis.lines
            if (gid := str(line.get_gid())).startswith("curve-")
        ],
    }
