"""The site is built without a warning, and its links, names and tables are sound."""

import base64
import inspect
import operator
import re
import shutil
import tomllib

import pytest
from all_workers import made_once, wait_until
from browser import opened
from processes import ROOT, python
from public_names import PUBLIC, THEMES

import lumped
import lumped.components
from lumped.components import translation

DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]


@pytest.fixture(scope="module")
def sphinx():
    """Skips if an extension is missing."""
    for name in ("sphinx", "myst_nb", "ipykernel", "furo", "sphinx_design"):
        pytest.importorskip(name)


def build(source, folder, *options):
    """Build a site with the project's settings; warnings are errors."""
    command = (
        "import gc, sys; from sphinx.cmd.build import main; "
        "gc.set_threshold(100_000); sys.exit(main(sys.argv[1:]))"
    )
    python("-c", command, "-qW", "--keep-going", *options, "-c", DOCS, source, folder)
    return folder


@pytest.fixture(scope="module")
def site(sphinx, tmp_path_factory):
    """All pages, built once for all workers; test_gallery.py runs the notebooks."""
    # what is not executed does not say its language
    options = ["-Dnb_execution_mode=off", "-Dsuppress_warnings=ref.python,myst-nb.lexer"]
    # the names beside a page and the theme take long; `themed` has the theme
    options += ["-Dtoc_object_entries=0", "-Dhtml_theme=basic"]
    return made_once(tmp_path_factory, "site", lambda place: build(DOCS, place / "pages", *options))


@pytest.fixture(scope="module")
def themed(sphinx, tmp_path_factory):
    """A few pages as readers see them, with an executed notebook, made once for all workers."""

    def made(place):
        gallery = place / "sources" / "gallery"
        gallery.mkdir(parents=True)
        shutil.copy(DOCS / "gallery" / "01_first_shaft.md", gallery)
        page = (DOCS / "gallery" / "README.md").read_text(encoding="utf-8")
        head, *_ = page.partition("\n* [Geared")
        (gallery / "README.md").write_text(head, encoding="utf-8")
        shutil.copy(DOCS / "cheat_sheet.md", place / "sources")
        names = "gallery/README\ngallery/01_first_shaft\ncheat_sheet"
        contents = f"# Pages\n\n```{{toctree}}\n{names}\n```\n"
        (place / "sources" / "index.md").write_text(contents, encoding="utf-8")
        # links of the sheet lead to pages that are not here, and names to the reference
        options = ["-Dsuppress_warnings=ref.python,myst.xref_missing"]
        return build(place / "sources", place / "pages", *options)

    return made_once(tmp_path_factory, "themed", made)


def test_every_page_is_built(site):
    for page in DOCS.rglob("*.md"):
        assert (site / page.relative_to(DOCS)).with_suffix(".html").exists()


def test_the_gallery_shows_a_picture_of_an_executed_notebook(themed):
    listed = themed / "gallery" / "README.html"
    pattern = r'<a [^>]*href="01_first_shaft.html"><img [^>]*src="(.*?)"'
    (picture,) = re.findall(pattern, listed.read_text(encoding="utf-8"))
    assert (listed.parent / picture).stat().st_size > 5_000


def test_every_public_name_stands_in_the_reference_once(site):
    pages = sorted((site / "api").rglob("*.html"))
    anchors = [
        anchor
        for page in pages
        for anchor in re.findall(r'<dt [^>]*id="(.*?)"', page.read_text(encoding="utf-8"))
    ]
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
    missing = {name for name in wanted if anchors.count(name) != 1}
    assert missing == {"lumped.time"}  # a symbol; a sentence there names it


def test_the_reference_leads_from_types_to_their_classes(site):
    page = (site / "api" / "vibration.html").read_text(encoding="utf-8")
    assert 'href="core.html#lumped.modes"' in page
    assert 'href="core.html#lumped.System"' in page


def groups(text, pattern):
    """Titles of the groups of elements and the pages in each."""
    found = re.findall(pattern, text, re.MULTILINE)
    return {title.lower(): re.findall(r"(\w+)(?:\.md\)|$)", lines, re.M) for title, lines in found}


def test_the_site_groups_elements_as_their_page_does():
    expected = groups(
        (DOCS / "elements" / "README.md").read_text(encoding="utf-8"), r"^## (.*)\n\n((?:\* .*\n)+)"
    )
    received = groups(
        (DOCS / "index.md").read_text(encoding="utf-8").replace("elements/README\n", ""),
        r'^:caption: "Elements: (.*)"\n:hidden:\n:maxdepth: 1\n\n((?:elements/.*\n)+)',
    )
    assert received == expected
    pages = {page.stem for page in (DOCS / "elements").glob("[a-z]*.md")}
    assert pages == {page for group in expected.values() for page in group}


def test_the_calls_that_answer_questions_exist_and_lead_to_every_page():
    text = (DOCS / "analyses" / "README.md").read_text(encoding="utf-8")
    calls = re.findall(r"\blp\.([\w.]+)\(", text)
    assert len(calls) > 30
    assert [call for call in calls if not callable(operator.attrgetter(call)(lumped))] == []
    linked = set(re.findall(r"\]\((\w+\.md)", text))
    assert {page.name for page in (DOCS / "analyses").glob("[a-z]*.md")} <= linked


def test_formulas_are_set_without_a_script(site):
    page = (site / "elements" / "elasto_gap.html").read_text(encoding="utf-8")
    assert "<math " in page
    assert "mathjax" not in page.lower()


def test_no_page_loads_anything_from_the_network(site, themed):
    loads = re.compile(
        r"<(?:script|img|iframe)[^>]* src=\"(?:https?:)?//|<link[^>]* href=\"https?:"
    )
    pages = [*site.rglob("*.html"), *themed.rglob("*.html")]
    assert [page for page in pages if loads.search(page.read_text(encoding="utf-8"))] == []


@pytest.fixture
def browser(tmp_path):
    with opened(tmp_path / "profile") as found:
        yield found


def test_the_search_finds_pages_without_a_server(themed, browser):
    browser.open(themed / "search.html", query="?q=campbell")
    links = "[...document.querySelectorAll('#search-results li a')].map(a => a.href).join(' ')"
    wait_until(lambda: "cheat_sheet.html" in browser.value(links))
    assert [each for each in browser.requests if not each.startswith(("file:", "data:"))] == []


def test_the_cheat_sheet_prints_on_one_page_of_a4(themed, browser):
    browser.open(themed / "cheat_sheet.html")
    printed = browser.call("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
    pages = re.findall(
        rb"/Type\s*/Page\b.*?/MediaBox\s*\[(.*?)\]", base64.b64decode(printed["data"]), re.S
    )
    (box,) = pages
    assert [round(float(each)) for each in box.split()[2:]] == [595, 842]  # points


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


def test_the_table_of_published_problems_is_that_of_their_file(monkeypatch):
    monkeypatch.syspath_prepend(ROOT)
    from benchmarks.report import published_page

    page = (DOCS / "published.md").read_text(encoding="utf-8")
    assert "\n".join(published_page.lines()) in page


def test_the_page_on_installation_names_all_extras():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    page = (DOCS / "install.md").read_text(encoding="utf-8")
    table = page.partition("| extra |")[2].partition("\n\n")[0]
    named = re.findall(r"`(\w+)`", " ".join(re.findall(r"^\|([^|]*)\|", table, re.MULTILINE)))
    assert set(named) == set(project["optional-dependencies"])
