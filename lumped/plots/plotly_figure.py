"""Pictures drawn by plotly: zoomed, moved and read by the pointer."""

from __future__ import annotations

from functools import singledispatchmethod
from html import escape
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from lumped.plots.picture import (
    Axis,
    Band,
    Bars,
    Beside,
    Curve,
    HeatMap,
    Instants,
    Level,
    Panel,
    Picture,
    Tag,
    Words,
    choose_names,
    wrap_text,
)
from lumped.plots.style import GREY, INK, LETTER, LETTERS, MAP, SMALL, WIDTH, Look

_SYMBOLS = {
    "circle": "circle",
    "square": "square",
    "triangle": "triangle-up",
    "diamond": "diamond",
    "down": "triangle-down",
}
_DASHES = {"": "solid", "solid": "solid", "dashed": "dash", "dotted": "dot", "dashdot": "dashdot"}
_INCH = 96  # pixels
_POINT = 96 / 72
_BETWEEN = 0.3  # inch, between rows


class PlotlyFigure:
    """A figure of plotly while it is drawn; `panel` is the number of the panel in work."""

    def __init__(self, picture: Picture):
        self.picture = picture
        self.panel = 0
        self.told: set[str] = set()
        columns, panels = picture.columns, picture.panels
        heights = picture.measure_rows(0.2, 1.9 * SMALL / 72)
        gap = _BETWEEN + 0.15 * any(panel.caption for panel in panels)
        if not picture.shared:
            gap += 0.25 + picture.depth
        whole = sum(heights) + gap * (len(heights) - 1)
        self.figure = make_subplots(
            rows=picture.rows,
            cols=columns,
            shared_xaxes="all" if picture.shared else False,
            row_heights=heights,
            vertical_spacing=gap / whole,
            horizontal_spacing=0.12 / columns if columns > 1 else 0.0,
        )
        self._lay_out(whole)
        for k, panel in enumerate(panels):
            self.panel = k
            for item in panel.items:
                self._draw(item)
            self._scale(panel)

    def _lay_out(self, whole: float) -> None:
        """Size, letters, title and legends of the whole."""
        picture = self.picture
        items = [item for panel in picture.panels for item in panel.items]
        tags = {item.above for item in items if isinstance(item, Tag)}
        is_below = picture.below or any(isinstance(item, Instants) for item in items)
        names = [wrap_text(name) for panel in picture.panels for name in panel.y.names]
        longest = max((len(line) for name in names for line in name.split("\n")), default=0)
        captions = any(panel.caption for panel in picture.panels)
        margin = {
            "l": 70 + int(LETTER * SMALL * _POINT * longest),
            "r": 20 + 45 * (False in tags),
            "t": 50 + 18 * bool(picture.note) + 18 * captions + 50 * (True in tags),
            "b": 55 + int(picture.depth * _INCH),
        }
        self.figure.update_layout(
            template="plotly_white",
            font={"size": LETTERS * _POINT, "color": INK},
            width=int(WIDTH * _INCH),
            height=int(whole * _INCH + margin["t"] + margin["b"] + 30 * is_below),
            margin=margin,
            title={
                "text": _html(wrap_text(picture.title, 70)),
                "x": 0.02,
                "xanchor": "left",
                "y": 1.0,
                "yanchor": "top",
                "yref": "container",
                "pad": {"t": 12},
                "font": {"size": (LETTERS + 2) * _POINT},
                "subtitle": {"text": _html(wrap_text(picture.note, 90))},
            },
            legend={
                "orientation": "h",
                "yref": "container",
                "y": 0.0,
                "yanchor": "bottom",
                "x": 0.5,
                "xanchor": "center",
            },
            hovermode="closest",
        )
        for k in range(len(picture.panels)):
            top = self.figure.layout[f"yaxis{self._number(k)}"].domain[1]
            place = {"x": 1.01, "y": top, "yanchor": "top", "xanchor": "left"}
            look = {"font": {"size": SMALL * _POINT}, "tracegroupgap": 0}
            self.figure.update_layout({f"legend{k + 2}": place | look})

    @staticmethod
    def _number(k: int) -> str:
        return str(k + 1) if k else ""

    def _place(self) -> dict[str, int]:
        row, column = divmod(self.panel, self.picture.columns)
        return {"row": row + 1, "col": column + 1}

    def _legend(self, item: Any) -> dict[str, Any]:
        """What says in which legend a trace stands; each label once in the one below all."""
        if not item.label:
            return {"showlegend": False}
        own = isinstance(item, Beside) and not self.picture.below
        text = _html(wrap_text(item.label, 30 if own else 60))
        if own:
            return {"name": text, "legend": f"legend{self.panel + 2}"}
        first = item.label not in self.told
        self.told.add(item.label)
        return {"name": text, "legendgroup": item.label, "showlegend": first}

    def _trace(self, trace: Any) -> None:
        self.figure.add_trace(trace, **self._place())

    def _write(self, text: str, x: float, y: float, **options: Any) -> None:
        self.figure.add_annotation(text=_html(text), x=x, y=y, showarrow=False, **options)

    def _name(self, item: Level | Band, **look: Any) -> None:
        """Put in the legend what is no trace."""
        self._trace(go.Scatter(x=[None], y=[None], **look, **self._legend(item)))

    def _scale(self, panel: Panel) -> None:
        """Scales, labels and numbers of both axes, and the caption."""
        k, picture = self.panel, self.picture
        x, y = (f"{name}axis{self._number(k)}" for name in "xy")
        label, upright = picture.choose_labels(k)
        upright = wrap_text(upright, int(13 * panel.height))
        names = choose_names(panel.x.names, picture.columns) if panel.x.names else (1, 0)
        for name, axis, text, how in ((x, panel.x, label, names), (y, panel.y, upright, (1, 0))):
            look = {"title": {"text": _html(text), "standoff": 8}} | _scale(axis, *how)
            self.figure.update_layout({name: look})
        if not picture.is_numbered(k):
            self.figure.update_layout({x: {"showticklabels": False}})
        if panel.square:
            self.figure.update_layout({y: {"scaleanchor": f"x{self._number(k)}"}})
        if panel.caption:
            suffix = f"{self._number(k)} domain"
            refs = {"xref": f"x{suffix}", "yref": f"y{suffix}"}
            self._write(panel.caption, 0.5, 1.0, yanchor="bottom", **refs)

    @singledispatchmethod
    def _draw(self, item: Any) -> None:
        raise NotImplementedError(type(item).__name__)

    @_draw.register
    def _(self, item: Curve) -> None:
        look = item.look
        kinds = [kind for kind, there in (("lines", look.dash), ("markers", look.mark)) if there]
        self._trace(
            go.Scatter(
                x=item.x,
                y=item.y,
                mode="+".join(kinds),
                line=_line(look),
                marker={
                    "symbol": _SYMBOLS.get(look.mark, "circle") + ("-open" if look.hollow else ""),
                    "size": look.size * _POINT * 1.2,
                    "color": look.colour,
                },
                **self._legend(item),
            )
        )

    @_draw.register
    def _(self, item: Level) -> None:
        line = self.figure.add_vline if item.upright else self.figure.add_hline
        line(item.at, line=_line(item.look), exclude_empty_subplots=False, **self._place())
        if item.label:
            self._name(item, mode="lines", line=_line(item.look))

    @_draw.register
    def _(self, item: Band) -> None:
        self.figure.add_vrect(
            item.begin,
            item.end,
            fillcolor=item.colour,
            opacity=0.15,
            layer="below",
            line={"width": 1.0 if item.hatched else 0.0, "color": item.colour, "dash": "dot"},
            exclude_empty_subplots=False,
            **self._place(),
        )
        square = {"symbol": "square", "size": 12, "color": item.colour, "opacity": 0.3}
        self._name(item, mode="markers", marker=square)

    @_draw.register
    def _(self, item: Bars) -> None:
        x, y = (item.sizes, item.places) if item.lying else (item.places, item.sizes)
        self._trace(
            go.Bar(
                x=x,
                y=y,
                orientation="h" if item.lying else "v",
                width=item.width,
                marker={"color": item.colour, "line": {"width": 0}},
                **self._legend(item),
            )
        )
        self.figure.update_layout(barmode="overlay")

    @_draw.register
    def _(self, item: HeatMap) -> None:
        domain = self.figure.layout[f"yaxis{self._number(self.panel)}"].domain
        bar = {
            "title": {"text": _html(item.label), "side": "right"},
            "len": domain[1] - domain[0],
            "y": domain[0],
            "yanchor": "bottom",
            "exponentformat": "power",
        }
        self._trace(go.Heatmap(x=item.x, y=item.y, z=item.sizes.T, colorscale=MAP, colorbar=bar))

    @_draw.register
    def _(self, item: Words) -> None:
        x, y = (self.picture.panels[self.panel].x, self.picture.panels[self.panel].y)
        self._write(
            item.text,
            np.log10(item.x) if x.log else item.x,
            np.log10(item.y) if y.log else item.y,
            xanchor={-1: "right", 0: "center", 1: "left"}[item.aside],
            xshift=4 * item.aside,
            yanchor="middle" if item.aside else "bottom",
            font={"size": SMALL * _POINT},
            **self._place(),
        )

    @_draw.register
    def _(self, item: Tag) -> None:
        suffix = f"{self._number(self.panel)} domain"
        refs = {"xref": f"x{suffix}", "yref": f"y{suffix}"}
        x0, y0, x1, y1 = 1.0, item.place, 1.02, item.moved
        if item.above:
            x0, y0, x1, y1 = item.place, 1.0, item.moved, 1.03
        line = {"color": GREY, "width": 0.7}
        self.figure.add_shape(type="line", x0=x0, y0=y0, x1=x1, y1=y1, line=line, **refs)
        self._write(
            item.text,
            x1,
            y1,
            textangle=-90 if item.upright else 0,
            xanchor="center" if item.above else "left",
            yanchor="bottom" if item.above else "middle",
            borderpad=0,
            font={"size": item.share * SMALL * _POINT, "color": GREY},
            **refs,
        )

    @_draw.register
    def _(self, item: Instants) -> None:
        own = len(self.picture.panels) + self.panel + 1  # an axis y of the marks alone
        number = self._number(self.panel)
        lies_over = {"overlaying": f"y{number}", "range": [0.0, 1.0], "visible": False}
        self.figure.update_layout({f"yaxis{own}": lies_over | {"fixedrange": True}})
        self.figure.add_trace(
            go.Scatter(
                x=item.times,
                y=np.zeros(len(item.times)),
                xaxis=f"x{number}",
                yaxis=f"y{own}",
                mode="markers",
                marker={
                    "symbol": f"{_SYMBOLS[item.mark]}-open",
                    "size": item.size * _POINT,
                    "color": INK,
                },
                cliponaxis=False,
                text=[_html(text) for text in item.texts],
                hovertemplate="%{x:.6g}<br>%{text}<extra></extra>",
                **self._legend(item),
            )
        )


def _html(text: str) -> str:
    return escape(text, quote=False).replace("\n", "<br>")


def _line(look: Look) -> dict[str, Any]:
    return {"color": look.colour, "dash": _DASHES[look.dash], "width": look.width * _POINT}


def _scale(axis: Axis, each: int = 1, angle: int = 0) -> dict[str, Any]:
    """What an axis of plotly is told of ours; every which name is told, and turned how far."""
    ends = [axis.low, axis.high]
    if axis.log:
        ends = [None if end is None else float(np.log10(end)) for end in ends]
    found: dict[str, Any] = {
        "type": "log" if axis.log else "linear",
        "range": ends[::-1] if axis.down else ends,
        "zeroline": False,
        "showline": not axis.bare,
        "linecolor": INK,
        "ticks": "" if axis.bare else "outside",
        "showticklabels": not axis.bare,
        "showgrid": not axis.bare,
        "exponentformat": "power",
    }
    if axis.names:
        texts = [_html(wrap_text(name)) for name in axis.names]
        places = list(range(0, len(texts), each))
        found |= {"tickmode": "array", "tickvals": places, "tickangle": -angle}
        found["ticktext"] = [texts[k] for k in places]
    if axis.step is not None:
        found["dtick"] = axis.step
    if axis.log and axis.low and axis.high:
        found["dtick"] = "D2" if axis.high < 300 * axis.low else 1
    return found
