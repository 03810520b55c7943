"""The site is built without a warning, and its links, names and tables are sound."""

import inspect
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from public_names import PUBLIC, THEMES

import lumped
import lumped.components
from lumped.components import translation

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
# The first notebook is executed; test_gallery.py runs all of them.
UNEXECUTED = "nb_execution_excludepatterns=gallery/0[2-9]_*,gallery/[1-9][0-9]_*"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    for name in ("sphinx", "myst_nb", "ipykernel", "furo"):
        pytest.importorskip(name)
    folder = tmp_path_factory.mktemp("site")
    search = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    built = subprocess.run(
        [sys.executable, "-m", "sphinx", "-qW", "--keep-going", "-D", UNEXECUTED, DOCS, folder],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": search},
    )
    assert built.returncode == 0, built.stderr  # warnings are errors; kernels of notebooks chat
    return folder


def test_every_page_is_built(site):
    for page in DOCS.rglob("*.md"):
        assert (site / page.relative_to(DOCS)).with_suffix(".html").exists()


def test_the_gallery_shows_a_picture_of_a_notebook(site):
    listed = (site / "gallery" / "README.html").read_text(encoding="utf-8")
    (picture,) = set(
        re.findall(r'<a [^>]*href="01_first_shaft.html"><img [^>]*src="(.*?)"', listed)
    )
    assert (site / "gallery" / picture).stat().st_size > 5_000


def test_every_public_name_stands_in_the_reference(site):
    reference = (site / "api.html").read_text(encoding="utf-8")
    wanted = {
        f"lumped.{name}" if name in lumped.__all__ else f"lumped.{theme}.{name}"
        for theme in THEMES
        for name in (*lumped.__all__, *getattr(lumped, theme).__all__)
        if not inspect.ismodule(PUBLIC[name])
    }
    for library in (lumped.components, translation):
        for name, kind in inspect.getmembers(library, inspect.isclass):
            if name in library.__all__:
                wanted.add(f"{kind.__module__}.{name}")
    missing = {name for name in wanted if f'id="{name}"' not in reference}
    assert missing == {"lumped.time"}  # a symbol; a sentence there names it


def headings(page):
    """Anchors of a page as the forges make them."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(ROOT)) for page in PAGES])
def test_links_within_the_project_lead_somewhere(page):
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if not target.startswith(("https://", "http://")):
            path, _, anchor = target.partition("#")
            file = (page.parent / path).resolve() if path else page
            assert file.exists(), target
            assert not anchor or anchor in headings(file), target


def test_the_tables_of_the_benchmarks_are_those_of_their_files(monkeypatch):
    monkeypatch.syspath_prepend(ROOT)
    from benchmarks.__main__ import RESULTS, as_markdown

    page = (RESULTS / "README.md").read_text(encoding="utf-8")
    tables = sorted(RESULTS.glob("*.csv"))
    assert tables
    assert [path.name for path in tables if as_markdown(path) not in page] == []


def test_the_readme_names_all_extras():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    table = PAGES[0].read_text(encoding="utf-8").partition("| extra |")[2].partition("\n\n")[0]
    named = re.findall(r"`(\w+)`", " ".join(re.findall(r"^\|([^|]*)\|", table, re.MULTILINE)))
    assert set(named) == set(project["optional-dependencies"])
