"""What a user installs: content and version of the wheel, and the names of its packages."""

import importlib
import json
import re
import shutil
import tarfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from all_workers import made_once
from packaging.metadata import Metadata
from processes import ROOT, python
from type_checkers import marked, mypy, pyright

import lumped
from lumped.models import Row

Checker = Callable[[Path, Path], set[tuple[str, int, str]]]
FOLDERS = {"lumped": "lumped", "components": "lumped/components", "models": "lumped/models"}


def build(kind: str, source: Path, target: Path) -> Path:
    python(
        "-m", "build", f"--{kind}", "--no-isolation", "--outdir", target, source, cwd=target.parent
    )
    (archive,) = target.iterdir()
    return archive


def content(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def sources_in(copy: Path) -> Path:
    """Copy of the sources without what earlier builds left behind."""
    copy.mkdir()
    for file in ROOT.iterdir():
        if file.is_file():
            shutil.copy(file, copy)
    for folder in (*FOLDERS, "benchmarks", "docs", "tests"):
        shutil.copytree(
            ROOT / folder,
            copy / folder,
            symlinks=True,
            ignore=shutil.ignore_patterns("__pycache__"),
        )
    return copy


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return sources_in(tmp_path_factory.mktemp("source") / "project")


@pytest.fixture(scope="module")
def sdist(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build("sdist", source, tmp_path_factory.mktemp("sdist") / "dist")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built once for all workers."""

    def built(place: Path) -> Path:
        return build("wheel", sources_in(place / "project"), place / "dist")

    return made_once(tmp_path_factory, "wheel", built)


def test_wheel_holds_every_module_under_its_installed_name(wheel: Path):
    expected = {
        f"{name}/{file.relative_to(ROOT / folder).as_posix()}"
        for folder, name in FOLDERS.items()
        for file in (ROOT / folder).rglob("*.py")
    }
    received = {name for name in content(wheel) if name.endswith(".py")}
    assert {"lumped/components/__init__.py", "lumped/models/__init__.py"} <= expected
    assert received == expected


def test_wheel_is_typed_and_lists_the_public_names(wheel: Path):
    stubs = {file.relative_to(ROOT).as_posix() for file in (ROOT / "lumped").glob("**/*.pyi")}
    assert {"lumped/__init__.pyi", "lumped/vibration/__init__.pyi"} < stubs
    assert {"lumped/py.typed", *stubs} <= set(content(wheel))


@pytest.mark.parametrize(("checker", "place"), [(mypy, 0), (pyright, 1)], ids=["mypy", "pyright"])
def test_type_checkers_read_the_constructors_in_the_wheel(
    checker: Checker, place: int, wheel: Path, tmp_path: Path
):
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "installed")
    folder = tmp_path / "user"
    folder.mkdir()
    received = checker(tmp_path / "installed", folder)
    expected = marked(place)
    assert received == expected
    assert len(expected) > 30


def test_editable_install_names_the_folder_that_type_checkers_read(source: Path, tmp_path: Path):
    code = "import sys, setuptools.build_meta as b; b.build_editable(sys.argv[1])"
    python("-c", code, tmp_path, cwd=source)
    (wheel,) = tmp_path.iterdir()
    received = [text.decode() for name, text in content(wheel).items() if name.endswith(".pth")]
    expected = [str(source)]
    assert [text.strip() for text in received] == expected
    assert (source / "lumped" / "components" / "inertia.py").exists()


def test_wheel_holds_the_c_sources_of_exported_models(wheel: Path):
    folder = ROOT / "lumped" / "exchange" / "c"
    expected = {f"lumped/exchange/c/{file.name}" for file in folder.iterdir()}
    assert {name for name in content(wheel) if name.startswith("lumped/exchange/c/")} == expected
    assert len(expected) > 10


def test_wheel_installs_nothing_beside_lumped(wheel: Path):
    received = {name.split("/")[0] for name in content(wheel)}
    assert received == {"lumped", f"lumped-{lumped.__version__}.dist-info"}


def test_wheel_has_valid_metadata_the_readme_and_the_licence(wheel: Path):
    files = content(wheel)
    folder = f"lumped-{lumped.__version__}.dist-info"
    metadata = Metadata.from_email(files[f"{folder}/METADATA"], validate=True)
    assert str(metadata.version) == lumped.__version__
    assert metadata.description_content_type == "text/markdown"
    assert metadata.description.strip() == (ROOT / "README.md").read_text(encoding="utf-8").strip()
    assert files[f"{folder}/licenses/LICENSE"] == (ROOT / "LICENSE").read_bytes()
    assert b"lumped = lumped.cli:main" in files[f"{folder}/entry_points.txt"]


def test_changelog_begins_with_this_version_and_goes_down():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    headings = re.findall(r"^## (.*)$", text, re.MULTILINE)
    dated = r"\[(\d+)\.(\d+)\.(\d+)\] - (?:\d{4}-\d\d-\d\d|unreleased|never published)"
    found = [re.fullmatch(dated, heading) for heading in headings]
    assert None not in found
    versions = [tuple(map(int, each.groups())) for each in found if each]
    assert versions == sorted(set(versions), reverse=True)
    assert ".".join(map(str, versions[0])) == lumped.__version__
    assert not any("unreleased" in heading for heading in headings[1:])


def test_citation_names_this_version():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.findall(r"^version: (.*)$", text, re.MULTILINE) == [lumped.__version__]


def test_wheel_computes_without_the_sources_what_the_checkout_computes(
    wheel: Path, tmp_path: Path, machine_rows: Callable[[str], list[Row]]
):
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    file = tmp_path / "wheel.json"
    code = "import sys, lumped.cli, lumped.components as c, lumped.models as m\n"
    code += "print(c.__file__, m.__file__)\nsys.exit(lumped.cli.main(sys.argv[1:]))"
    call = ("-c", code, "run", "reversing_mill", "--json", file)
    printed = python(*call, cwd=tmp_path, PYTHONPATH=str(tmp_path)).split()
    places = [tmp_path / f"lumped/{name}/__init__.py" for name in ("components", "models")]
    assert [Path(place) for place in printed[:2]] == places
    received = {row["quantity"]: row["computed"] for row in json.loads(file.read_text())["rows"]}
    assert received
    assert received == {row.quantity: row.computed for row in machine_rows("reversing_mill")}


RUNS = """
import lumped as lp
from lumped.components import Inertia, SpringDamper, Torque
from lumped.functionals import peak
from lumped.ops import sin
class Drive(lp.Component):
    motor: Torque = Torque(tau=40 * sin(30 * lp.time))
    a: Inertia = Inertia(J=2.0)
    shaft: SpringDamper = SpringDamper(c=2e4, d=4.0)
    b: Inertia = Inertia(J=0.5)
    def connections(self):
        yield from lp.chain(self.motor, self.a, self.shaft, self.b)
system = lp.assemble(Drive())
run = lp.simulate(system, until=0.5)
many = lp.ensemble(system, over={"a.J": [1 + k / 9 for k in range(16)]}, until=0.5,
                   of={"top": peak("shaft.tau")}, workers=1)
for numbers in (run.t, run["shaft.tau"], many["top"]):
    print(*[float(number).hex() for number in numbers])
"""


def installed(wheel: Path, place: Path) -> dict[str, str]:
    """Variables of a process that finds the wheel, and an empty cache."""
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(place / "installed")
    return {"PYTHONPATH": str(place / "installed"), "LUMPED_CACHE": str(place / "cache")}


def test_wheel_brings_the_machine_code_that_the_checkout_compiles(wheel: Path, tmp_path: Path):
    received = python("-c", RUNS, cwd=tmp_path, **installed(wheel, tmp_path))
    assert list((tmp_path / "cache").glob("loop-*")) == []
    assert received.count("0x") > 100
    assert received == python("-c", RUNS)


def test_edited_wheel_compiles_its_loop(wheel: Path, tmp_path: Path):
    variables = installed(wheel, tmp_path)
    with (tmp_path / "installed/lumped/kernel/loop.py").open("a") as file:
        file.write("# edited")
    code = "from lumped.kernel.engine import time_loop; time_loop()"
    python("-c", code, cwd=tmp_path, **variables)
    assert len(list((tmp_path / "cache").glob("loop-*"))) == 1


def test_source_distribution_holds_all_sources_documentation_and_tests(source: Path, sdist: Path):
    files = [file for file in source.rglob("*") if file.is_file()]
    expected = {file.relative_to(source).as_posix() for file in files}
    expected = {name for name in expected if not name.startswith((".", "build/"))}
    assert {"RELEASE.md", "docs/index.md", "docs/start.png", "lumped/drawing/page.css"} < expected
    with tarfile.open(sdist) as archive:
        received = {name.partition("/")[2] for name in archive.getnames()}
    assert expected - received == set()


def test_source_distribution_builds_the_same_wheel(sdist: Path, wheel: Path, tmp_path: Path):
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    unpacked = tmp_path / f"lumped-{lumped.__version__}"
    rebuilt = build("wheel", unpacked, tmp_path / "wheel")
    assert content(rebuilt) == content(wheel)


@pytest.mark.parametrize("name", ["components", "models"])
def test_short_name_is_refused(name: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(ROOT)
    with pytest.raises(ImportError, match=f"'lumped.{name}'"):
        importlib.import_module(name)
