"""The guides are short, name files that exist, and show what the code does."""

import ast
import inspect
import re
import runpy
from operator import attrgetter
from pathlib import Path

import pytest

import lumped as lp

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
GUIDES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    DOCS / "design.md",
    DOCS / "decisions.md",
    DOCS / "limitations.md",
]


def named(guide):
    """Paths in backticks: what has a slash, or the ending of a file of the project."""
    prose = re.sub(r"```.*?```", "", guide.read_text(encoding="utf-8"), flags=re.DOTALL)
    quoted = re.findall(r"`([^`\s]+)`", prose)
    path = re.compile(r"\.?[\w\-]+(/[\w\-.]+)*/?(\.(py|pyi|md|toml|csv|svg|cff|yml|yaml|in))?")
    ending = re.compile(r"\.(py|pyi|md|toml|csv|svg|cff|yml|yaml|in)$")
    return [q for q in quoted if path.fullmatch(q) and ("/" in q or ending.search(q))]


def exists(path):
    """From the root of the repository, or from the folder of the package."""
    return any((place / path).exists() for place in (ROOT, ROOT / "lumped", DOCS))


@pytest.mark.parametrize("guide", GUIDES, ids=lambda guide: guide.name)
def test_every_file_that_a_guide_names_exists(guide):
    assert [path for path in named(guide) if not exists(path)] == []


def test_paths_are_recognised(tmp_path):
    guide = tmp_path / "guide.md"
    guide.write_text("`numerics/one_step.py` `pyproject.toml` `.ci/run` `M/s` `lp.modes` `a + b/c`")
    assert named(guide) == ["numerics/one_step.py", "pyproject.toml", ".ci/run", "M/s"]
    assert not exists("numerics/one_step.py")


def test_the_map_of_the_code_has_each_folder_and_is_no_book():
    page = (DOCS / "design.md").read_text(encoding="utf-8")
    titles = ", ".join(re.findall(r"^## (.*)$", page, re.MULTILINE)).split(", ")
    folders = {file.parent.name for file in (ROOT / "lumped").glob("*/__init__.py")}
    assert folders <= set(titles)
    assert len(page.split()) <= 3_500


@pytest.mark.parametrize("page", ["analyses/README.md", "cheat_sheet.md"])
def test_a_call_in_a_table_has_the_arguments_of_its_function(page):
    calls = re.findall(r"`(lp\.[\w.]+\([^`]*\))`", (DOCS / page).read_text(encoding="utf-8"))
    nodes = [node for call in calls for node in ast.walk(ast.parse(call))]
    assert nodes
    for call in nodes:
        if isinstance(call, ast.Call):
            function = attrgetter(ast.unparse(call.func).removeprefix("lp."))(lp)
            named = {word.arg: word.value for word in call.keywords}
            inspect.signature(function).bind(*call.args, **named)


def test_the_readme_has_at_most_150_lines():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 150


def test_the_picture_of_a_model_shows_the_numbers_of_the_lift():
    drawn = runpy.run_path(str(DOCS / "draw_model.py"))["picture"]()
    assert drawn == (DOCS / "model.svg").read_text(encoding="utf-8"), "python docs/draw_model.py"


def test_matplotlib_is_imported_where_the_guide_says():
    importing = re.compile(r"^\s*(?:import|from) matplotlib", re.MULTILINE)
    files = [*(ROOT / "lumped").rglob("*.py"), *(ROOT / "components").rglob("*.py")]
    found = {file.parent.name for file in files if importing.search(file.read_text("utf-8"))}
    machines = {place.name for place in (ROOT / "models").rglob("") if place.is_dir()}
    assert found <= {"plots", "drawing"} | machines
