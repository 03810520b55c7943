"""Schematics as parts of a page, with letters of the size of its text."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from lumped.compiler.system import System
from lumped.drawing.inline import inline
from lumped.drawing.placing import WIDEST, place
from lumped.drawing.routing import Routed, route
from lumped.drawing.schematic import draw, find_parts
from lumped.language.component import Component

PAGE = (7.8, 10.0)  # inch; A4 prints it with letters of 7.3 points
_STYLE = """<style>
.schematic { overflow-x: auto; }
.schematic svg { width: var(--width); max-width: none; max-height: none; height: auto; }
@media print { .schematic svg { width: 100%; max-width: var(--width); max-height: 230mm; } }
</style>"""


def fit_schematic(model: Component | System, values: Mapping[str, str]) -> Figure:
    """The lowest schematic that fits on a page, else the one that exceeds it least.

    Parameters
    ----------
    model : Component or System
        Model to draw.
    values : mapping of str to str
        Texts above symbols, by the paths of their components.
    """
    plan = find_parts(model, None)
    tried = (route(plan, place(plan, columns), values) for columns in (WIDEST, *range(8, 2, -1)))

    def excess(routed: Routed) -> tuple[float, float]:
        shares = (size / page for size, page in zip(routed.size, PAGE, strict=True))
        return max(1.0, *shares), routed.size[1]

    return draw(plan, min(tried, key=excess), values)


def inline_schematic(
    model: Component | System, values: Mapping[str, str], title: str, key: str
) -> str:
    """A schematic as an HTML element; what is wider than the page scrolls there.

    Parameters are those of `fit_schematic` and `lumped.drawing.inline.inline`.
    """
    figure = fit_schematic(model, values)
    width = f"--width: {figure.get_figwidth():.3f}in"
    drawn = inline(figure, title, key)
    return f'{_STYLE}<div class="schematic" style="{width}">{drawn}</div>'
