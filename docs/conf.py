"""Settings of the site: ``python -m sphinx -W --keep-going docs site``."""

import inspect
from pathlib import PurePosixPath
from typing import Any

from docutils import nodes

import lumped as lp

project = "lumped"
author = "The lumped authors"
version = release = lp.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = f"lumped {release}"
html_static_path = ["_static"]
html_css_files = ["gallery.css"]
myst_heading_anchors = 3
suppress_warnings = ["ref.python"]  # types in docstrings are words, not references

# The notebooks of the gallery
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_output_stderr = "error"  # a warning is a fault
nb_merge_streams = True

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


def add_thumbnails(app: Any, doctree: nodes.document, page: str) -> None:
    """Add to each line of the gallery's list the second picture of its notebook, or its only."""
    if page != "gallery/README":
        return
    (cards,) = doctree.findall(nodes.bullet_list)
    cards["classes"].append("cards")
    for item in cards:
        link = next(item.findall(nodes.reference))
        name = f"gallery/{PurePosixPath(link['refuri']).stem}"
        pictures = list(app.env.get_doctree(name).findall(nodes.image))
        if pictures:  # none if notebooks are not executed
            picture, card = pictures[:2][-1].deepcopy(), link.deepcopy()
            picture["alt"] = link.astext()
            card.clear()
            card += picture
            item.insert(0, nodes.paragraph("", "", card))


def setup(app: Any) -> None:
    """Connect these to Sphinx."""
    app.connect("doctree-resolved", add_thumbnails)
    app.connect("autodoc-skip-member", skip_declarations)
