"""Each notebook of the gallery runs without warnings, checks its numbers and shows a picture."""

import ast
import re
from pathlib import Path

import pytest
from matplotlib.figure import Figure

GALLERY = Path(__file__).parents[2] / "docs" / "gallery"
NOTEBOOKS = sorted(GALLERY.glob("[0-9]*.md"))
CELL = re.compile(r"^```\{code-cell\}\n(.*?)^```$", re.DOTALL | re.MULTILINE)
MAGIC = re.compile(r"^%.*$", re.MULTILINE)


def shown(cell, names):
    """What a notebook shows below a cell: the value of its last line."""
    tree = ast.parse(MAGIC.sub("", cell))
    value = None
    if isinstance(tree.body[-1], ast.Expr):
        value = ast.Expression(tree.body.pop().value)
    exec(compile(tree, "cell", "exec"), names)
    return eval(compile(value, "cell", "eval"), names) if value else None


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])
def test_a_notebook_runs_and_checks_itself(notebook, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cells = CELL.findall(notebook.read_text(encoding="utf-8"))
    nodes = [node for cell in cells for node in ast.walk(ast.parse(MAGIC.sub("", cell)))]
    assert any(isinstance(node, ast.Assert) for node in nodes)
    names: dict = {"__name__": "__main__"}
    values = [shown(cell, names) for cell in cells]
    assert any(isinstance(value, Figure) for value in values)


def test_the_list_names_each_notebook_once():
    links = re.findall(r"^\* \[.*?\]\((.*?)\)", (GALLERY / "README.md").read_text(), re.MULTILINE)
    assert links == [path.name for path in NOTEBOOKS]
