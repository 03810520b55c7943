"""A page as its reader sees it: what it loads, and the cells of its tables."""

import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path

__all__ = ["Page"]

VOID = {"meta", "link", "br", "use", "img", "input", "wbr"}


class Page(HTMLParser):
    """Tags that open and close in order, texts, and what would be loaded."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.open, self.loads, self.ids, self.cells, self.cell = [], [], Counter(), [], ""
        self.text = file.read_text(encoding="utf-8")
        self.feed(self.text)
        assert not self.open

    def check_whole(self) -> None:
        """It loads nothing, each name stands once, and each link leads somewhere."""
        assert all(load.startswith(("#", "data:")) for load in self.loads)
        assert not re.search(r"https?:|url\((?!#)|@import|fetch\(|XMLHttp", self.text)
        assert max(self.ids.values()) == 1
        assert {load[1:] for load in self.loads if load.startswith("#")} <= set(self.ids)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.ids.update([found["id"]] if "id" in found else [])
        self.loads += [found[k] for k in ("src", "href", "xlink:href", "action") if k in found]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag
        if tag in ("td", "th") and self.cell:
            self.cells.append(self.cell)
            self.cell = ""

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            self.cell += data
