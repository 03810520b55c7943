"""Pictures drawn by matplotlib; a figure needs no display."""

from __future__ import annotations

import io
from functools import singledispatch
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MultipleLocator, NullFormatter

from lumped.errors import OptionError, shown
from lumped.plots.picture import (
    Band,
    Bars,
    Beside,
    Curve,
    HeatMap,
    Instants,
    Level,
    Picture,
    Tag,
    Words,
    choose_names,
    wrap_text,
)
from lumped.plots.style import GREY, INK, LETTER, MAP, RC, SMALL, WIDTH, Look

_MARKERS = {"": "", "circle": "o", "square": "s", "triangle": "^", "diamond": "D", "down": "v"}
_DASHES = {"": "none", "solid": "-", "dashed": "--", "dotted": ":", "dashdot": "-."}
_AWAY = 0.03  # of tags from the panel, as a share of its sides


class NotebookFigure(Figure):
    """A figure of matplotlib that a notebook shows without ``%matplotlib inline``."""

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        self.savefig(file, format="png", dpi=100)
        return file.getvalue()


def matplotlib_figure(picture: Picture, ax: Any = None) -> Figure:
    """Draw a picture into a new figure, or into axes that are given.

    Raises
    ------
    OptionError
        If the axes that are given are not as many as the panels.
    """
    with mpl.rc_context(RC):
        axes = _new_axes(picture) if ax is None else _check_axes(picture, ax)
        below: dict[str, Artist] = {}
        for i, (axis, panel) in enumerate(zip(axes, picture.panels, strict=True)):
            beside: dict[str, Artist] = {}
            for item in panel.items:
                handle = _draw_item(item, axis)
                if handle is not None and isinstance(item, Beside | Instants) and item.label:
                    own = isinstance(item, Beside) and not picture.below
                    text = plain_text(wrap_text(item.label, 30 if own else 60))
                    (beside if own else below).setdefault(text, handle)
            _scale_axes(axis, picture, i)
            if ax is not None and axis is axes[-1]:
                beside |= below
            if beside:
                axis.legend(
                    beside.values(),
                    beside.keys(),
                    loc="upper left",
                    bbox_to_anchor=(1.01, 1.0),
                    borderaxespad=0.0,
                )
        heading = plain_text(
            "\n".join(wrap_text(t, 90) for t in (picture.title, picture.note) if t)
        )
        if ax is not None:
            caption = picture.panels[0].caption
            axes[0].set_title("\n".join(filter(None, (heading, plain_text(caption)))))
            found = axes[0].get_figure(root=True)
            assert found is not None
            return found
        figure = axes[0].figure
        assert isinstance(figure, Figure)
        figure.suptitle(heading)
        if below:
            longest = max(map(len, below))
            columns = max(1, int(WIDTH * 72 / (LETTER * SMALL * longest + 40)))
            figure.legend(below.values(), below.keys(), loc="outside lower center", ncols=columns)
        return figure


def _new_axes(picture: Picture) -> list[Axes]:
    columns, panels = picture.columns, picture.panels
    heights = picture.measure_rows(0.1, 1.45 * SMALL / 72)
    captions = 0.25 * picture.rows * any(panel.caption for panel in panels)
    names = picture.depth * (1 if picture.shared else picture.rows)
    size = WIDTH, 0.9 + sum(heights) + captions + names
    figure = NotebookFigure(size, layout="constrained")
    grid = figure.add_gridspec(picture.rows, columns, height_ratios=heights)
    axes: list[Axes] = []
    for i in range(len(panels)):
        same = axes[0] if axes and picture.shared else None
        axes.append(figure.add_subplot(grid[divmod(i, columns)], sharex=same))
        if not picture.is_numbered(i):
            axes[-1].tick_params(labelbottom=False)
    return axes


def _check_axes(picture: Picture, ax: Any) -> list[Axes]:
    axes = list(np.atleast_1d(np.asarray(ax, dtype=object)).ravel())
    if len(axes) != len(picture.panels) or not all(isinstance(axis, Axes) for axis in axes):
        told = [panel.caption or panel.y.label or panel.x.label for panel in picture.panels]
        got = shown(ax) if len(axes) == 1 else f"{len(axes)} of them"
        needed = "one matplotlib Axes is" if len(told) == 1 else f"{len(told)} matplotlib Axes are"
        raise OptionError(
            f"{picture.title}: ax = {got}: {needed} needed, for {'; '.join(map(repr, told))}."
        )
    return axes


def plain_text(text: str) -> str:
    """A text that is no formula."""
    return text.replace("$", r"\$")


def _scale_axes(axis: Axes, picture: Picture, i: int) -> None:
    """Scales, labels and numbers of both axes."""
    panel = picture.panels[i]
    for way, wanted in ((axis.xaxis, panel.x), (axis.yaxis, panel.y)):
        name = way.axis_name
        if wanted.log:
            axis.set(**{f"{name}scale": "log"})
        if wanted.low is not None or wanted.high is not None:
            axis.set(**{f"{name}lim": (wanted.low, wanted.high)})
        if wanted.log:
            low, high = sorted(way.get_view_interval())
            each = (1.0, 2.0, 5.0) if high < 300 * low else (1.0,)
            way.set_major_locator(LogLocator(subs=each))
            way.set_major_formatter("{x:g}")
            way.set_minor_formatter(NullFormatter())
        if wanted.step is not None:
            way.set_major_locator(MultipleLocator(wanted.step))
        if wanted.down:
            way.set_inverted(True)
        if wanted.bare:
            way.set_ticks([])
    if panel.y.names:
        axis.set_yticks(
            range(len(panel.y.names)), [plain_text(wrap_text(n)) for n in panel.y.names]
        )
        axis.grid(False, axis="y")
    if panel.x.names:
        _name_places(axis, panel.x.names, picture.columns, picture.is_numbered(i))
    x, y = picture.choose_labels(i)
    axis.set_xlabel(plain_text(x))
    axis.set_ylabel(plain_text(wrap_text(y, int(15 * panel.height))))
    if panel.caption:
        axis.set_title(plain_text(panel.caption))
    if panel.square:
        axis.set_aspect("equal")
        axis.spines[:].set_visible(False)


def _name_places(axis: Axes, names: tuple[str, ...], columns: int, told: bool) -> None:
    """Names below places, turned if they need it, and only every n-th if they are too many."""
    each, angle = choose_names(names, columns)
    places = range(0, len(names), each)
    axis.set_xticks(places, [plain_text(names[k]) for k in places] if told else [""] * len(places))
    for label in axis.get_xticklabels():
        label.set(rotation=angle, ha="right" if angle == 30 else "center")
        label.set(rotation_mode="anchor" if angle == 30 else "default")


def _of(look: Look) -> dict[str, Any]:
    return {
        "color": look.colour,
        "linestyle": _DASHES[look.dash],
        "linewidth": look.width,
        "marker": _MARKERS[look.mark],
        "markersize": look.size,
        "fillstyle": "none" if look.hollow else "full",
    }


@singledispatch
def _draw_item(item: Any, axis: Axes) -> Artist | None:
    """What stands for the item in a legend."""
    raise NotImplementedError(type(item).__name__)


@_draw_item.register
def _(item: Curve, axis: Axes) -> Artist | None:
    (line,) = axis.plot(item.x, item.y, label=item.label or None, **_of(item.look))
    return line


@_draw_item.register
def _(item: Level, axis: Axes) -> Artist | None:
    line = axis.axvline if item.upright else axis.axhline
    return line(item.at, label=item.label or None, **_of(item.look))


@_draw_item.register
def _(item: Band, axis: Axes) -> Artist | None:
    look: dict[str, Any] = {"facecolor": item.colour, "alpha": 0.15, "linewidth": 0.0}
    if item.hatched:
        look = {"facecolor": "none", "edgecolor": item.colour, "hatch": "///", "alpha": 0.5}
    return axis.axvspan(item.begin, item.end, zorder=0, **look)


@_draw_item.register
def _(item: Bars, axis: Axes) -> Artist | None:
    if item.lying:
        bars = axis.barh(item.places, item.sizes, item.width, color=item.colour)
    else:
        bars = axis.bar(item.places, item.sizes, item.width, color=item.colour)
    return bars.patches[0] if bars.patches else None


@_draw_item.register
def _(item: HeatMap, axis: Axes) -> Artist | None:
    mesh = axis.pcolormesh(item.x, item.y, item.sizes.T, shading="nearest", cmap=MAP)
    axis.get_figure(root=True).colorbar(mesh, ax=axis, label=plain_text(item.label))  # type: ignore[union-attr]
    return None


@_draw_item.register
def _(item: Words, axis: Axes) -> Artist | None:
    axis.annotate(
        plain_text(item.text),
        (item.x, item.y),
        xytext=(3 * item.aside, 0 if item.aside else 2),
        textcoords="offset points",
        fontsize=SMALL,
        ha={-1: "right", 0: "center", 1: "left"}[item.aside],
        va="center" if item.aside else "bottom",
    )
    return None


@_draw_item.register
def _(item: Tag, axis: Axes) -> Artist | None:
    axis.annotate(
        plain_text(item.text),
        xy=(item.place, 1) if item.above else (1, item.place),
        xytext=(item.moved, 1 + 1.6 * _AWAY) if item.above else (1 + _AWAY, item.moved),
        xycoords="axes fraction",
        color=GREY,
        fontsize=item.share * SMALL,
        rotation=90 if item.upright else 0,
        ha="center" if item.above else "left",
        va="bottom" if item.above else "center",
        arrowprops={"arrowstyle": "-", "color": GREY, "lw": 0.5, "shrinkA": 0},
        annotation_clip=False,
    )
    return None


@_draw_item.register
def _(item: Instants, axis: Axes) -> Artist | None:
    return axis.scatter(
        item.times,
        np.zeros(len(item.times)),
        s=item.size**2,
        marker=_MARKERS[item.mark],
        facecolor="none",
        edgecolor=INK,
        linewidths=0.8,
        transform=axis.get_xaxis_transform(),
        clip_on=False,
        zorder=3,
    )
