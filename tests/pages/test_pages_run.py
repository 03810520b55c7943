"""What the pages of the documentation show runs, and prints what stands below it."""

import pytest
from page_code import DOCS, run_blocks

NAMES = (
    *("index", "start", "cheat_sheet", "conventions", "own_component", "data", "coming_from"),
    *("compiler", "notebook", "pictures", "explorer", "live_page"),
    *("analyses/starts", "analyses/robust", "analyses/scatter", "analyses/torsional"),
    *(
        f"elements/{name}"
        for name in ("clutch", "engine", "elastic_coupling", "shafts", "synchronous_machine")
    ),
)
MACHINES = sorted(f"machines/{page.stem}" for page in (DOCS / "machines").glob("*.md"))


@pytest.mark.parametrize("name", [*NAMES, *MACHINES])
def test_a_page_prints_what_it_shows(name, tmp_path):
    _, printed = run_blocks(name, tmp_path)
    for lines, shown in printed:
        assert lines == shown
