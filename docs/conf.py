"""Settings of the site: ``python -m sphinx -W --keep-going docs site``."""

import inspect
from typing import Any

import lumped as lp

project = "lumped"
author = "The lumped authors"
version = release = lp.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = f"lumped {release}"
myst_heading_anchors = 3
suppress_warnings = ["ref.python"]  # types in docstrings are words, not references

add_module_names = False
autodoc_typehints = "none"  # types stand in the docstrings
autodoc_member_order = "groupwise"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_custom_sections = [(name, "params_style") for name in ("Variables", "Outputs", "Ports")]

DECLARED = ("equations", "initial_equations", "connections")


def skip_declarations(app: Any, _: str, name: str, thing: Any, *__: Any) -> bool | None:
    """Leave out what component docstrings list, modules, and in themes what the core repeats."""
    place = app.env.temp_data.get("autodoc:module")
    if place != "lumped" and name in lp.__all__ and getattr(lp, name) is thing:
        return True
    part = isinstance(thing, lp.Port | lp.Param | lp.Var | lp.Input | lp.Output | lp.Component)
    return True if part or name in DECLARED or inspect.ismodule(thing) else None


def setup(app: Any) -> None:
    """Connect it to Sphinx."""
    app.connect("autodoc-skip-member", skip_declarations)
