"""Results and models as HTML, which notebooks show instead of their text."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class RichHtml:
    """Shown by notebooks with tables and small pictures.

    What draws them comes before all results, and is loaded when a notebook asks.
    """

    def _repr_html_(self) -> str:
        drawing: Any = import_module("lumped.drawing.rich_output")
        found: str = drawing.html(self)
        return found
