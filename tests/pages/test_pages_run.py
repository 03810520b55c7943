"""What the pages of the documentation show runs, and prints what stands below it."""

import pytest
from page_code import DOCS, run_blocks

NAMES = (
    *("index", "start", "cheat_sheet", "conventions", "own_component", "data", "coming_from"),
    *("compiler", "notebook", "pictures", "explorer", "live_page"),
    *("analyses/starts", "analyses/robust", "analyses/scatter", "analyses/torsional"),
)
ELEMENTS = sorted(
    f"elements/{page.stem}"
    for page in (DOCS / "elements").glob("*.md")
    if "```text" in page.read_text(encoding="utf-8")
)
MACHINES = sorted(f"machines/{page.stem}" for page in (DOCS / "machines").glob("*.md"))


@pytest.mark.parametrize("name", [*NAMES, *ELEMENTS, *MACHINES])
def test_a_page_prints_what_it_shows(name, tmp_path):
    _, printed = run_blocks(name, tmp_path)
    for lines, shown in printed:
        assert lines == shown
