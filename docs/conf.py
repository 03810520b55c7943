"""Settings of the site: ``python -m sphinx -W --keep-going docs site``."""

import inspect
from pathlib import PurePosixPath
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

import lumped as lp

project = "lumped"
author = "The lumped authors"
version = release = lp.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_design",
]
html_theme = "furo"
html_title = f"lumped {release}"
html_show_copyright = False
html_static_path = ["_static"]
html_css_files = ["gallery.css", "site.css"]
html_math_renderer = "mathml"  # browsers set it themselves, without a script
myst_fence_as_directive = ["math"]
myst_heading_anchors = 3
suppress_warnings = ["ref.python"]  # types in docstrings are words, not references

# The notebooks of the gallery
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_output_stderr = "error"  # a warning is a fault
nb_merge_streams = True

add_module_names = False
default_role = "py:obj"  # names in docstrings lead to their place
autosummary_generate = False  # the tables that add_contents writes
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


def add_contents(_: Any, what: str, place: str, module: Any, __: Any, lines: list[str]) -> None:
    """Begin a module's section with a table of its names; those in the core lead there."""
    if what != "module":
        return
    described = [name for name in module.__all__ if callable(getattr(module, name))]
    lines += ["", ".. autosummary::", "   :nosignatures:", ""]
    for name in described:
        core = name in lp.__all__ and getattr(lp, name) is getattr(module, name)
        lines.append(f"   ~lumped.{name}" if core and place != "lumped" else f"   {name}")
    lines.append("")


def write_mathml(writer: Any, node: nodes.math | nodes.math_block) -> None:
    """Set a formula as MathML."""
    writer.body.append(tex2mathml(node.astext(), as_block=isinstance(node, nodes.math_block)))
    raise nodes.SkipNode


def setup(app: Any) -> None:
    """Connect these to Sphinx."""
    app.connect("doctree-resolved", add_thumbnails)
    app.connect("autodoc-skip-member", skip_declarations)
    app.connect("autodoc-process-docstring", add_contents)
    app.add_html_math_renderer("mathml", (write_mathml, None), (write_mathml, None))
