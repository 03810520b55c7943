"""The code of a page of the documentation: what it prints, and the pictures that it draws."""

import contextlib
import io
import re
from pathlib import Path

import matplotlib as mpl

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
BLOCK = re.compile(r"```python\n(.*?)```\n(?:\n!\[[^\n]*\n)?(?:\n```text\n(.*?)```)?", re.DOTALL)


def read_page(name):
    """Text of a page by its path in the folder of documents, without its ending."""
    return (DOCS / f"{name}.md").read_text(encoding="utf-8")


def run_blocks(name, folder):
    """Run the blocks of a page one after the other in a folder.

    Paths in `tests/data` become those of this checkout. Gives the names that the page defines, and
    for each block what it printed and the text below it, line by line.
    """
    mpl.use("Agg")
    names, printed = {}, []
    pairs = BLOCK.findall(read_page(name))
    assert sum(bool(shown) for _, shown in pairs) == read_page(name).count("```text\n")
    with contextlib.chdir(folder):
        for code, shown in pairs:
            output = io.StringIO()
            code = code.replace("tests/data", str(ROOT / "tests" / "data"))
            with contextlib.redirect_stdout(output):
                exec(compile(code, f"{name}.md", "exec"), names)
            lines = [line.rstrip() for line in output.getvalue().strip().splitlines()]
            printed.append((lines, shown.strip().splitlines()))
    _check_pictures(name, folder)
    return names, printed


def _check_pictures(name, folder):
    """Pictures that a page draws are not empty, and those that it shows are small files."""
    text = read_page(name)
    for picture in Path(folder).glob("*.png"):
        assert picture.stat().st_size > 5_000
        if f"]({picture.name})" in text:
            assert ((DOCS / name).parent / picture.name).stat().st_size < 45_000
