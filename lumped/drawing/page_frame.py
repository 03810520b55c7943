"""Parts of pages: the frame with head and style, sections, paragraphs, lists and tables."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from string import Template

Section = tuple[str, str]
"""Heading, and content as HTML."""

_FOLDER = files("lumped.drawing")
_LONG = 12
"""Characters of a word that may stand in a narrow column."""


def fill_frame(title: str, style: str, body: str) -> str:
    """A whole page of a title, a style sheet and its content as HTML."""
    frame = Template((_FOLDER / "frame.html").read_text())
    return frame.substitute(title=escape(title), style=style, body=body)


def report_page(title: str, sections: Iterable[Section], lead: str = "") -> str:
    """A report: its title, what leads, a list of the sections that are not empty, and these."""
    links, parts = [], []
    for i, (head, content) in enumerate(section for section in sections if section[1]):
        key, text = f"section-{i}", escape(head)
        links.append(f'<li><a href="#{key}">{text}</a></li>')
        heading = f'<h2 id="{key}">{text}</h2>'
        parts.append(f'<section aria-labelledby="{key}">\n{heading}\n{content}\n</section>\n')
    body = Template((_FOLDER / "report.html").read_text()).substitute(
        title=escape(title),
        lead=lead,
        links="".join(links),
        sections="".join(parts),
        script=(_FOLDER / "page.js").read_text(),
    )
    return fill_frame(title, (_FOLDER / "page.css").read_text(), body)


def prose(body: str | Sequence[str]) -> str:
    """A paragraph, or a list of items."""
    if isinstance(body, str):
        return f"<p>{escape(body)}</p>"
    return "<ul>" + "".join(f"<li>{escape(item)}</li>" for item in body) + "</ul>"


def table(head: Sequence[str], rows: Iterable[Sequence[str]], numbers: Sequence[int] = ()) -> str:
    """A table; columns in `numbers` are aligned to the right."""

    def line(cells: Sequence[str], tag: str) -> str:
        texts = (
            f'<{tag} class="number">{escape(c)}</{tag}>'
            if i in numbers
            else f"<{tag}>{_breaking(c)}</{tag}>"
            for i, c in enumerate(cells)
        )
        return f"<tr>{''.join(texts)}</tr>"

    body = "\n".join(line(row, "td") for row in rows)
    return (
        f'<div class="wide"><table>\n<thead>{line(head, "th")}</thead>\n'
        f"<tbody>\n{body}\n</tbody>\n</table></div>"
    )


def _breaking(text: str) -> str:
    """A text whose long names may break after their dots, underscores and brackets."""
    words = re.split(r"(\s+)", text)
    return "".join(
        re.sub(r"(?<=[._\]])(?=\w)|(?=\[)", "<wbr>", escape(word))
        if len(word) > _LONG
        else escape(word)
        for word in words
    )
