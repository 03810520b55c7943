"""Draw the pictures of the pages here and in ``machines``: run each, keep what it saves.

The report on the first page is photographed by Chromium (``chromium`` on the PATH).
"""

import contextlib
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

DOCS = Path(__file__).resolve().parent
PAGES = [
    DOCS / "index.md",
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
        for report in Path().glob(f"{page.stem}_*.html"):
            photograph(report.resolve())
        for picture in Path().glob("*.png"):
            shutil.copy(picture, page.parent)


def photograph(report: Path) -> None:
    """Save the top of a report page as a picture beside it."""
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    picture = f"--screenshot={report.with_suffix('.png')}"
    subprocess.run(
        [*command, "--window-size=880,780", picture, report.as_uri()],
        check=True,
        stderr=subprocess.DEVNULL,
    )


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "agg")
    for page in PAGES:
        draw(page)
        print(f"{page.relative_to(DOCS)} drawn")
