"""Texts of the page that change without a new layout."""

from __future__ import annotations

from typing import Any

from bokeh.models import ColumnDataSource, CustomJS, Div

__all__ = ["LiveText", "live"]

_STYLE = (
    ":host{font-size:12px;color:#57606a;margin:0 5px}.bk-clearfix{width:100%}"
    "h2{font-size:14px;color:#1f2328;margin:2px 0}h3{font-size:12px;color:#1f2328;margin:6px 0 0}"
    ".fault{color:#b00020;white-space:pre-wrap}pre{overflow:auto;margin:2px 0}"
    "td,th{text-align:left;padding:2px 10px 2px 0}figure{margin:0}figcaption{display:none}"
    "svg{width:100%;height:auto;max-height:420px}"
)
_WRITE = """
const html = cb_obj.data.html[0]
const place = Bokeh.index.find_one(div)?.shadow_el.querySelector(".bk-clearfix")
if (place != null) place.innerHTML = html
else div.setv({text: html}, {sync: false})  // it is still being built
"""


def live(div: Div, columns: dict[str, list[Any]], code: str) -> ColumnDataSource:
    """A table that belongs to a text; a script runs in the browser when it changes.

    Bokeh lays the whole page out anew when the text of a `Div` changes. A script that writes into
    it does not, and the browser finds the place that the new text needs.
    """
    source = ColumnDataSource(columns)
    source.js_on_change("data", CustomJS(args={"div": div}, code=code))
    div.tags = [*div.tags, source]
    return source


class LiveText:
    """A text.

    Attributes
    ----------
    model : Div
        What stands on the page.
    """

    def __init__(self, html: str = "", **options: Any) -> None:
        self.model = Div(
            text=html,
            sizing_mode="stretch_width",
            disable_math=True,
            stylesheets=[_STYLE],
            **options,
        )
        self._html = html
        self._source = live(self.model, {"html": [html]}, _WRITE)

    def write(self, html: str) -> None:
        """Change it."""
        if html != self._html:
            self._html = html
            self._source.data = {"html": [html]}
