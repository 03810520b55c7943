"""What changes on a page that is shown: tables of pictures and texts, in one message."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from bokeh.document import Document
from bokeh.models import ColumnDataSource, CustomJS, Div, Model

_FOLDER = files("lumped.explorer")
STYLE = (_FOLDER / "page.css").read_text()
"""Given to each part of the page, whose classes say which it is."""


class Post:
    """Sends what is put into it in one turn of the page's thread as one message.

    Bokeh sends each change by itself, and lays the whole page out anew when the text of a `Div`
    changes. A script that writes the text does not, and the browser finds the place it needs.

    Parameters
    ----------
    doc : Document
        Of the visitor.

    Attributes
    ----------
    model : Model
        What must belong to the page.
    """

    def __init__(self, doc: Document) -> None:
        self._doc = doc
        self._known: dict[tuple[str, Model], Any] = {}
        self._waiting: dict[tuple[str, Model], Any] = {}
        self._count = 0
        self.model = ColumnDataSource({"number": [0], "news": [[]]})
        self.model.js_on_change("data", CustomJS(code=(_FOLDER / "post.js").read_text()))

    def table(self, source: ColumnDataSource, columns: Mapping[str, Any]) -> None:
        """Change the data of a picture."""
        self._put("data", source, columns)

    def text(self, div: Div, html: str) -> None:
        """Change a text."""
        if self._known.get(("html", div)) != html:
            self._put("html", div, html)

    def texts(self, div: Div, found: Mapping[str, str]) -> None:
        """Change texts in the picture of a text, by the identifiers of what holds them."""
        value = {"id": [*found], "text": [*found.values()]}
        if self._known.get(("texts", div)) != value:
            self._put("texts", div, value)

    def figure(self, figure: Model) -> None:
        """Paint a picture only while it is in the window."""
        self._put("figure", figure, None)

    def link(self, query: str) -> None:
        """Change the address of the page."""
        self._put("link", self.model, query)

    def file(self, name: str, text: str) -> None:
        """Give a file to the visitor."""
        self._send([("file", self.model, {"name": name, "text": text})])

    def again(self) -> None:
        """Send all that the page shows, to a browser that knows only how it began."""
        self._send([(*key, value) for key, value in self._known.items()])

    def _put(self, kind: str, model: Model, value: Any) -> None:
        if not self._waiting:
            self._doc.add_next_tick_callback(self._flush)
        self._known[kind, model] = self._waiting[kind, model] = value

    def _flush(self) -> None:
        sent, self._waiting = self._waiting, {}
        self._send([(*key, value) for key, value in sent.items()])

    def _send(self, news: list[tuple[str, Model, Any]]) -> None:
        self._count += 1  # what says the same as before is news too
        told = [[kind, model.id, value] for kind, model, value in news]
        self.model.data = {"number": [self._count], "news": [told]}


class LiveText:
    """A text.

    Parameters
    ----------
    post : Post
        Of the page.
    html : str
        Text at first.
    **options
        Of the `Div`.

    Attributes
    ----------
    model : Div
        What stands on the page.
    """

    def __init__(self, post: Post, html: str = "", **options: Any) -> None:
        self._post = post
        self.model = Div(
            text=html,
            sizing_mode="stretch_width",
            disable_math=True,
            css_classes=["text"],
            stylesheets=[STYLE],
            **options,
        )

    def write(self, html: str) -> None:
        """Change it."""
        self._post.text(self.model, html)

    def write_in_picture(self, found: Mapping[str, str]) -> None:
        """Change texts in its picture, by the identifiers of what holds them."""
        self._post.texts(self.model, found)
