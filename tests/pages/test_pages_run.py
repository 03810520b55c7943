"""What the pages of the documentation show runs, and prints what stands below it."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
NAMES = (
    *("index", "start", "cheat_sheet", "conventions", "own_component", "data", "coming_from"),
    *("compiler", "notebook", "pictures", "explorer", "live_page"),
    *("analyses/starts", "analyses/robust", "analyses/scatter", "analyses/torsional"),
    *(
        f"elements/{name}"
        for name in ("clutch", "engine", "elastic_coupling", "shafts", "synchronous_machine")
    ),
)
PAGES = [*(DOCS / f"{name}.md" for name in NAMES), *sorted((DOCS / "machines").glob("*.md"))]
BLOCK = re.compile(r"```python\n(.*?)```\n(?:\n```text\n(.*?)```)?", re.DOTALL)


@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_a_page_prints_what_it_shows(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for code, shown in BLOCK.findall(page.read_text(encoding="utf-8")):
        exec(compile(code, page.name, "exec"), names)
        printed = [line.rstrip() for line in capsys.readouterr().out.strip().splitlines()]
        assert printed == shown.strip().splitlines()
    for picture in tmp_path.glob("*.png"):
        assert picture.stat().st_size > 5_000
        assert (page.parent / picture.name).stat().st_size < 40_000
