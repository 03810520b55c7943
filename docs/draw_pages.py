"""Draw the pictures of the pages here and in ``machines``: run each, keep what it saves."""

import contextlib
import os
import re
import shutil
import tempfile
from pathlib import Path

DOCS = Path(__file__).resolve().parent
PAGES = [
    DOCS / "start.md",
    DOCS / "pictures.md",
    DOCS / "analyses" / "torsional.md",
    *sorted((DOCS / "machines").glob("*.md")),
]


def draw(page: Path) -> None:
    """Execute the Python blocks of a page and keep the pictures it saves."""
    names: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for block in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.S):
            exec(compile(block, page.name, "exec"), names)
        for picture in Path().glob("*.png"):
            shutil.copy(picture, page.parent)


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "agg")
    for page in PAGES:
        draw(page)
        print(f"{page.relative_to(DOCS)} drawn")
