"""Draw ``layers.svg``: the folders of lumped in the order in which they may import each other.

The order is that of the import contract in ``pyproject.toml``; the sentences are those that the
folders begin with; dots show what imports what.
"""

import ast
import re
import tomllib
from functools import cache
from html import escape
from pathlib import Path

DOCS = Path(__file__).resolve().parent
LUMPED = DOCS.parent / "lumped"
ROW, LEFT, TEXT, DOT = 26, 20, 150, 16
"""Heights and distances, pixels."""


@cache
def layers() -> list[str]:
    """Folders and modules from top to bottom."""
    given = tomllib.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = given["tool"]["importlinter"]["contracts"]
    order = next(c["layers"] for c in contracts if c["type"] == "layers")
    names = [name.strip("() ") for layer in order for name in layer.split("|")]
    return [name for name in names if name != "__main__"]


def files(layer: str) -> list[Path]:
    """Modules of a layer."""
    folder = LUMPED / layer
    return sorted(folder.rglob("*.py")) if folder.is_dir() else [folder.with_suffix(".py")]


def sentence(layer: str) -> str:
    """What it is for."""
    folder = LUMPED / layer
    module = folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")
    told = ast.get_docstring(ast.parse(module.read_text(encoding="utf-8"))) or ""
    return re.split(r"\.(?:\s|$)", told.replace("`", ""))[0].replace("\n", " ")


@cache
def imported(layer: str) -> set[str]:
    """Layers that it imports from, for annotations too."""
    found: set[str] = set()
    for file in files(layer):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("lumped"):
                path = [*(node.module or "").split(".")[1:], *(a.name for a in node.names)]
                found.add(path[0])
    return found & (set(layers()) - {layer})


def picture() -> str:
    """The picture as text."""
    names = layers()
    widest = max(len(sentence(name)) for name in names)
    grid = LEFT + TEXT + 7 * widest
    width, height = grid + DOT * (len(names) + 1), ROW * (len(names) + 1)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" height="{height}" font-family="sans-serif" font-size="13">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
        f'<text x="{width - LEFT}" y="{0.7 * ROW:g}" fill="#555" text-anchor="end">dots: imports '
        "from the layer whose square stands in that column</text>",
    ]
    for i, name in enumerate(names):
        y = ROW * (i + 1)
        if i % 2 == 0:
            lines.append(f'<rect y="{y}" width="{width}" height="{ROW}" fill="#f2f4f7"/>')
        lines.append(f'<text x="{LEFT}" y="{y + 18}" font-weight="bold">{name}</text>')
        told = escape(sentence(name))
        lines.append(f'<text x="{LEFT + TEXT}" y="{y + 18}">{told}</text>')
        uses = imported(name)
        for j, other in enumerate(names):
            x = grid + DOT * (j + 0.5)
            if j == i:
                lines.append(
                    f'<rect x="{x - 5:g}" y="{y + 8}" width="10" height="10" fill="#1f77b4"/>'
                )
            elif other in uses:
                lines.append(f'<circle cx="{x:g}" cy="{y + 13}" r="4" fill="#555"/>')
    return "\n".join([*lines, "</svg>\n"])


if __name__ == "__main__":
    (DOCS / "layers.svg").write_text(picture(), encoding="utf-8")
