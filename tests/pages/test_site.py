"""The site is built without a warning, and its links, names and tables are sound."""

import inspect
import os
import re
import shutil
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
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]


def build(source, folder, *options):
    """Build a site with the project's settings; warnings are errors."""
    for name in ("sphinx", "myst_nb", "ipykernel", "furo"):
        pytest.importorskip(name)
    search = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    built = subprocess.run(
        [
            sys.executable,
            "-m",
            "sphinx",
            "-qW",
            "--keep-going",
            *options,
            "-c",
            DOCS,
            source,
            folder,
        ],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": search},
    )
    assert built.returncode == 0, built.stderr
    return folder


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """All pages; test_gallery.py runs the notebooks."""
    # what is not executed does not say its language
    unexecuted = "-Dnb_execution_mode=off", "-Dsuppress_warnings=ref.python,myst-nb.lexer"
    return build(DOCS, tmp_path_factory.mktemp("site"), *unexecuted)


def test_every_page_is_built(site):
    for page in DOCS.rglob("*.md"):
        assert (site / page.relative_to(DOCS)).with_suffix(".html").exists()


def test_the_gallery_shows_a_picture_of_an_executed_notebook(tmp_path):
    gallery = tmp_path / "pages" / "gallery"
    gallery.mkdir(parents=True)
    shutil.copy(DOCS / "gallery" / "01_first_shaft.md", gallery)
    head, *_ = (DOCS / "gallery" / "README.md").read_text(encoding="utf-8").partition("\n* [Geared")
    (gallery / "README.md").write_text(head, encoding="utf-8")
    contents = "# Pages\n\n```{toctree}\ngallery/README\ngallery/01_first_shaft\n```\n"
    (tmp_path / "pages" / "index.md").write_text(contents, encoding="utf-8")
    listed = build(tmp_path / "pages", tmp_path / "site") / "gallery" / "README.html"
    pattern = r'<a [^>]*href="01_first_shaft.html"><img [^>]*src="(.*?)"'
    (picture,) = re.findall(pattern, listed.read_text(encoding="utf-8"))
    assert (listed.parent / picture).stat().st_size > 5_000


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
