"""Pictures of the page: made once by the library, then only their data change."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from textwrap import fill
from typing import Any

from bokeh.models import (
    ColumnDataSource,
    FactorRange,
    FixedTicker,
    LabelSet,
    Span,
    UIElement,
    VSpan,
)
from bokeh.plotting import figure
from bokeh.transform import dodge

from lumped.drawing.inline_schematic import inline_schematic
from lumped.explorer.live_text import LiveText, Post
from lumped.explorer.measured import Measured
from lumped.explorer.study import Study
from lumped.explorer.views import Shown

_COLOURS = (
    *("#1f77b4", "#d62728", "#2ca02c", "#ff7f0e", "#9467bd"),
    *("#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf"),
)
_TOOLS = "pan,box_zoom,wheel_zoom,reset,save"


class Picture:
    """One picture; its kinds are made of a study, the first tables, and the page's post.

    Attributes
    ----------
    models : list of UIElement
        What stands on the page.
    """

    models: list[UIElement]

    def show(self, shown: Shown) -> None:
        """Change its data."""
        raise NotImplementedError

    def overlay(self, measured: Measured) -> None:
        """Lay measured curves over it, if it has such quantities."""


def _colours(count: int) -> list[str]:
    return [_COLOURS[i % len(_COLOURS)] for i in range(count)]


def _axes(post: Post, height: int = 250, **options: Any) -> figure:
    """Empty axes in the look of the page."""
    plain = figure(
        height=height,
        sizing_mode="stretch_width",
        tools=_TOOLS,
        toolbar_location="right",
        **options,
    )
    plain.toolbar.logo = None
    plain.toolbar.autohide = True
    plain.axis.minor_tick_line_color = None
    for each in (plain.x_range, plain.y_range):
        each.syncable = False  # what the browser finds of them is not needed here
    post.figure(plain)
    return plain


def _legend(labels: Sequence[str], colours: Sequence[str]) -> str:
    """Names in the colours of their curves.

    Text beside the picture, because the library's own legends take a third of the time of painting.
    """
    mark = '<span style="white-space: nowrap"><b style="color: {}">\u2014</b> {}</span>'
    return " &ensp; ".join(
        mark.format(c, escape(each)) for each, c in zip(labels, colours, strict=True)
    )


class _Schematic(Picture):
    """The drive, whose texts change."""

    def __init__(self, study: Study, shown: Shown, post: Post) -> None:
        system, texts = study.system, shown["texts"]
        drawn = inline_schematic(system.model, texts, system.name, "schematic")
        self._text = LiveText(post, drawn)
        self.models = [self._text.model]

    def show(self, shown: Shown) -> None:
        told = {f"schematic-value of {part}": text for part, text in shown["texts"].items()}
        self._text.write_in_picture(told)


class _Modes(Picture):
    """Mode shapes along the drive; their frequencies name them."""

    def __init__(self, study: Study, shown: Shown, post: Post) -> None:
        axes = _axes(post, y_range=(-1.1, 1.1), y_axis_label="relative amplitude", height=320)
        self._post, self._shapes = post, ColumnDataSource(_colour(shown["shapes"]))
        axes.multi_line("x", "y", source=self._shapes, color="colour", line_width=2)
        axes.add_layout(Span(location=0, dimension="width", line_color="black", line_width=0.7))
        parts = shown["parts"]
        axes.xaxis.ticker = FixedTicker(ticks=parts["x"])
        axes.xaxis.major_label_overrides = dict(zip(parts["x"], parts["name"], strict=True))
        axes.xaxis.major_label_orientation = 0.7
        self._names = LiveText(post, _names_of(shown["shapes"]))
        self.models = [axes, self._names.model]

    def show(self, shown: Shown) -> None:
        self._post.table(self._shapes, _colour(shown["shapes"]))
        self._names.write(_names_of(shown["shapes"]))


def _colour(curves: dict[str, list[Any]]) -> dict[str, list[Any]]:
    return {**curves, "colour": _colours(len(curves["x"]))}


def _names_of(curves: dict[str, list[Any]]) -> str:
    return _legend(curves["label"], _colours(len(curves["label"])))


class _Effects(Picture):
    """Bars for each parameter: by what share a result changes with it."""

    def __init__(self, study: Study, shown: Shown, post: Post) -> None:
        names, kinds = _split(shown)
        self._post, self._range = post, FactorRange(factors=names[::-1])
        axes = _axes(
            post,
            y_range=self._range,
            x_axis_label="relative change for each relative change",
            height=90 + 26 * len(names),
        )
        self._bars = [ColumnDataSource({"name": names, "share": kinds[of]}) for of in kinds]
        width = 0.8 / len(kinds)
        for i, bars in enumerate(self._bars):
            place = 0.4 - width * (i + 0.5)
            axes.hbar(
                y=dodge("name", place, range=self._range),
                right="share",
                height=0.9 * width,
                source=bars,
                color=_COLOURS[i],
            )
        axes.add_layout(Span(location=0, dimension="height", line_color="black", line_width=0.7))
        self._axes = axes
        self.models = [axes, LiveText(post, _legend([*kinds], _colours(len(kinds)))).model]

    def show(self, shown: Shown) -> None:
        names, kinds = _split(shown)
        if self._range.factors != names[::-1]:
            self._range.factors = names[::-1]
            self._axes.height = 90 + 26 * len(names)
        for bars, shares in zip(self._bars, kinds.values(), strict=False):
            self._post.table(bars, {"name": names, "share": shares})
        for bars in self._bars[len(kinds) :]:
            self._post.table(bars, {"name": [], "share": []})


def _split(shown: Shown) -> tuple[list[str], dict[str, list[float]]]:
    """Names of parameters, and the shares of each result."""
    shares = dict(shown["effects"])
    return shares.pop("name"), shares


class _Run(Picture):
    """Quantities over time, one panel for each unit, with the instants of events."""

    def __init__(self, study: Study, shown: Shown, post: Post) -> None:
        self._post = post
        self._names = [name for name in shown["curves"] if name != "t"]
        units: dict[str, list[str]] = {}
        for name in self._names:
            units.setdefault(study.system.quantity(name).unit, []).append(name)
        self._curves = ColumnDataSource(shown["curves"])
        self._events = ColumnDataSource(shown["events"])
        self._measured = {name: ColumnDataSource({"t": [], "y": []}) for name in self._names}
        colours = dict(zip(self._names, _colours(len(self._names)), strict=True))
        panels: list[figure] = []
        for unit, names in units.items():
            shared = {"x_range": panels[0].x_range} if panels else {}
            axes = _axes(post, y_axis_label=unit, height=230, **shared)
            axes.add_glyph(self._events, VSpan(x="t", line_color="#999999", line_dash="dotted"))
            for name in names:
                colour = colours[name]
                axes.line("t", name, source=self._curves, color=colour)
                axes.scatter("t", "y", source=self._measured[name], color=colour, size=3, alpha=0.6)
            panels.append(axes)
        panels[-1].xaxis.axis_label = "time, s"
        every = []
        for axes in panels:  # events do not stretch the axes
            axes.y_range.renderers = [r for r in axes.renderers if not isinstance(r.glyph, VSpan)]
            every += axes.y_range.renderers
        panels[0].x_range.renderers = every
        self._told = LiveText(post, _list_events(shown))
        names = LiveText(post, _legend([*colours], [*colours.values()])).model
        self.models = [*panels, names, self._told.model]

    def show(self, shown: Shown) -> None:
        self._post.table(self._curves, shown["curves"])
        self._post.table(self._events, shown["events"])
        self._told.write(_list_events(shown))

    def overlay(self, measured: Measured) -> None:
        for name, source in self._measured.items():
            y = measured.curves.get(name)
            found = ([], []) if y is None else (measured.t.tolist(), y.tolist())
            self._post.table(source, dict(zip(("t", "y"), found, strict=True)))


def _list_events(shown: Shown) -> str:
    return "; ".join(map(escape, shown["told"]["text"]))


class _Curves(Picture):
    """Curves over the speed or the frequency, with rays of orders and points where they meet."""

    def __init__(self, study: Study, shown: Shown, post: Post) -> None:
        labels = {name: shown["axes"][name][0] for name in ("x", "y")}
        axes = _axes(
            post,
            x_axis_label=labels["x"],
            y_axis_label=fill(labels["y"], 32),
            y_axis_type=shown["axes"]["scale"][0],
        )
        self._post = post
        self._tables = {name: ColumnDataSource(_full(shown, name)) for name in _EMPTY}
        curves = self._tables["curves"]
        drawn = [axes.multi_line("x", "y", source=curves, color="colour")]
        rays = axes.multi_line("x", "y", source=self._tables["rays"], color="#999999")
        order = {"text_font_size": "10px", "text_color": "#555555"}
        axes.add_layout(
            LabelSet(x="end_x", y="end_y", text="label", source=self._tables["rays"], **order)
        )
        axes.scatter("x", "y", source=self._tables["critical"], color="#d62728", size=6)
        axes.x_range.renderers = axes.y_range.renderers = drawn + [rays] * ("rays" in shown)
        self._names = LiveText(post, _names_of(shown["curves"]))
        self.models = [axes, self._names.model]

    def show(self, shown: Shown) -> None:
        self._names.write(_names_of(shown["curves"]))
        for name, source in self._tables.items():
            self._post.table(source, _full(shown, name))


_EMPTY: dict[str, dict[str, list[Any]]] = {
    "curves": {"x": [], "y": [], "label": []},
    "rays": {"x": [], "y": [], "label": [], "end_x": [], "end_y": []},
    "critical": {"x": [], "y": []},
}


def _full(shown: Shown, name: str) -> dict[str, list[Any]]:
    columns = shown.get(name, _EMPTY[name])
    return _colour(columns) if name == "curves" else columns


class _Verdict(Picture):
    """A table of limits and how far they are used."""

    def __init__(self, study: Study, shown: Shown, post: Post) -> None:
        self._table = LiveText(post, _limits(shown))
        self.models = [self._table.model]

    def show(self, shown: Shown) -> None:
        self._table.write(_limits(shown))


def _limits(shown: Shown) -> str:
    heads = ("limit", "quantity", "value", "permitted", "used")
    rows = ["".join(f"<th>{name}</th>" for name in heads)]
    for *texts, used in zip(*shown["limits"].values(), strict=True):
        colour, failed = ("#b00020", ", not kept") if used > 1 else ("#1a7f37", "")
        cells = "".join(f"<td>{escape(text)}</td>" for text in texts)
        style = f"color: {colour}; font-weight: bold"
        rows.append(f'{cells}<td style="{style}">{used:.0%}{failed}</td>')
    return f"<table>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"


PICTURES: dict[str, Callable[[Study, Shown, Post], Picture]] = {
    "schematic": _Schematic,
    "modes": _Modes,
    "effects": _Effects,
    "run": _Run,
    "curves": _Curves,
    "verdict": _Verdict,
}
"""Pictures by the kinds of views."""
