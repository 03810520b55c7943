"""The frame of a report: head, list of sections, style and script in one page."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from importlib.resources import files

Section = tuple[str, str]
"""Heading, and content as HTML."""


def whole_page(name: str, sections: Sequence[Section], lead: str = "") -> str:
    """The page: its title, what leads, a list of the sections, and these."""
    anchors = [f"section-{i}" for i in range(len(sections))]
    links = "".join(
        f'<li><a href="#{a}">{escape(t)}</a></li>'
        for a, (t, _) in zip(anchors, sections, strict=True)
    )
    body = "".join(
        f'<section aria-labelledby="{a}">\n<h2 id="{a}">{escape(t)}</h2>\n{content}\n</section>\n'
        for a, (t, content) in zip(anchors, sections, strict=True)
    )
    parts = files("lumped.drawing")
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<link rel="icon" href="data:,">\n'
        f"<title>{escape(name)}</title>\n<style>\n{(parts / 'page.css').read_text()}</style>\n"
        f"</head>\n<body>\n<h1>{escape(name)}</h1>\n{lead}<nav><ul>{links}</ul></nav>\n{body}"
        f"<script>\n{(parts / 'page.js').read_text()}</script>\n</body>\n</html>\n"
    )


def prose(body: str | Sequence[str]) -> str:
    """A paragraph, or a list of items."""
    if isinstance(body, str):
        return f"<p>{escape(body)}</p>"
    return "<ul>" + "".join(f"<li>{escape(item)}</li>" for item in body) + "</ul>"
