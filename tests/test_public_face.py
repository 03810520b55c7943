"""What `import lumped` shows: names, when they load, and what is said where there is none."""

import ast
import tomllib
from types import ModuleType

import networkx as nx
import pytest
from processes import ROOT, loaded, python
from public_names import PLACES, PUBLIC, THEMES

import lumped as lp
from lumped.support.lazy_names import sources

INTERNAL = {
    "many_runs",
    *("cli", "code", "compiler", "flattening", "kernel", "language", "numerics", "reduction"),
    *("plots", "support", "timeloop"),
}
HEAVY = {"casadi", "matplotlib", "networkx", "numpy", "pandas", "scipy"}


def place(name: str) -> ModuleType:
    return lp if name == "lumped" else getattr(lp, name.removeprefix("lumped."))


# -- names ---------------------------------------------------------------------------------------


def test_the_themes_are_the_folders_of_analyses():
    folders = {p.parent.name for p in (ROOT / "lumped").glob("*/__init__.py")}
    assert set(THEMES) == folders - INTERNAL - {"components", "functionals", "models"}


@pytest.mark.parametrize("name", PLACES)
def test_dir_and_all_show_exactly_the_names_of_the_stub(name):
    """A line for each: ``from lumped.vibration.natural.find_modes import modes as modes``."""
    stub = (ROOT / name.replace(".", "/") / "__init__.pyi").read_text(encoding="utf-8")
    lines = ast.parse(stub).body
    aliases = [a for line in lines if isinstance(line, ast.ImportFrom) for a in line.names]
    others = [ast.unparse(line) for line in lines if not isinstance(line, ast.ImportFrom)]
    expected = sorted(alias.name for alias in aliases)
    assert [*place(name).__all__] == dir(place(name)) == expected
    assert [alias.asname for alias in aliases] == [alias.name for alias in aliases]
    assert others == (["__version__: str"] if name == "lumped" else [])


def test_internals_are_not_shown():
    assert not INTERNAL & {*dir(lp), *lp.__all__}


def test_the_core_is_small():
    assert len(lp.__all__) - len(THEMES) <= 64


def test_what_the_core_repeats_is_the_same_object():
    for theme in THEMES:
        for name in getattr(lp, theme).__all__:
            if name in lp.__all__:
                assert getattr(lp, name) is getattr(getattr(lp, theme), name)


def test_a_theme_has_all_names_of_the_core_that_its_modules_define():
    homes = {f"lumped.{theme}": theme for theme in THEMES}
    for name, source in sources("lumped").items():
        home = homes.get(".".join(source.split(".")[:2]))
        assert home is None or name in getattr(lp, home).__all__


def test_no_name_is_in_two_themes():
    names = [name for theme in THEMES for name in getattr(lp, theme).__all__]
    assert len(set(names)) == len(names)


def test_a_module_does_not_hide_the_function_of_its_name():
    code = (
        "import lumped.vibration.natural.modes, lumped as lp; print(lp.vibration.modes is lp.modes)"
    )
    assert python("-c", code) == "True\n"
    code = "import lumped as lp; lp.modes; import lumped.vibration.natural.modes\n"
    code += "print(lp.vibration.modes)"
    assert python("-c", code).startswith("<function modes")


def test_a_star_import_gives_the_core():
    names: dict[str, object] = {}
    exec("from lumped import *", names)
    assert {*names} - {"__builtins__"} == {*lp.__all__}


def test_errors_are_caught_by_their_public_names():
    with pytest.raises(lp.errors.OptionError):
        lp.modes(None)


# -- when they load ------------------------------------------------------------------------------


def test_importing_lumped_loads_nothing_but_the_names():
    found = {name for name in loaded("import lumped") if name.partition(".")[0] == "lumped"}
    assert found == {"lumped", "lumped.support", "lumped.support.lazy_names"}


def test_importing_lumped_loads_no_other_package():
    assert not HEAVY & loaded("import lumped")


@pytest.mark.parametrize("module", ["lumped.components", "lumped.models", "lumped.cli"])
def test_importing_a_library_or_the_command_loads_nothing_heavy(module):
    heavy = {"matplotlib", "networkx", "pandas", "scipy.integrate", "scipy.linalg"}
    heavy |= {"scipy.optimize", "scipy.sparse", "scipy.stats"}
    found = loaded(f"import {module}")
    assert module in found
    assert not heavy & found


def test_listing_a_theme_loads_none_of_its_analyses():
    found = loaded("import lumped as lp; dir(lp.vibration)")
    assert "lumped.vibration" in found
    assert not [name for name in found if name.startswith("lumped.vibration.")]


def test_components_load_no_analysis():
    found = loaded("from lumped.components import *")
    late = {*THEMES, "code", "compiler", "kernel", "models", "numerics", "reduction", "timeloop"}
    assert "lumped.components.gearing.gears" in found
    assert not [name for name in found if name.startswith("lumped.") and name.split(".")[1] in late]


def test_a_component_loads_none_of_other_folders():
    found = loaded("from lumped.components import Inertia")
    folders = {name.split(".")[2] for name in found if name.startswith("lumped.components.")}
    assert folders == {"inertia"}


def test_only_drawing_needs_matplotlib():
    """SciPy loads each of its packages at its first use."""
    late = {"matplotlib", "networkx", "pandas", "scipy.integrate", "scipy.optimize", "scipy.sparse"}
    code = "import lumped as lp\nfor theme in {!r}: exec(f'from lumped.{{theme}} import *')"
    for themes, expected in ((set(THEMES) - {"drawing"}, set()), ({"drawing"}, {"matplotlib"})):
        assert late & loaded(code.format(sorted(themes))) == expected


def test_an_analysis_loads_no_other():
    found = loaded("import lumped as lp; lp.modes")
    assert "lumped.vibration.natural.find_modes" in found
    assert not {"lumped.optimisation", "lumped.exchange", "lumped.orbits", "matplotlib"} & found


def loaded_by(lines: list[ast.stmt]) -> set[str]:
    """What lines load as a module is loaded: functions and annotations load nothing."""
    found: set[str] = set()
    for line in lines:
        if isinstance(line, ast.Import):
            found |= {alias.name for alias in line.names}
        elif isinstance(line, ast.ImportFrom):
            found |= {f"{line.module}.{alias.name}" for alias in line.names}
        elif not isinstance(line, ast.FunctionDef):
            is_typing = isinstance(line, ast.If) and "TYPE_CHECKING" in ast.unparse(line.test)
            for block in ("orelse", "finalbody") if is_typing else ("body", "orelse", "finalbody"):
                found |= loaded_by(getattr(line, block, []))
            found |= {name for h in getattr(line, "handlers", []) for name in loaded_by(h.body)}
    return found


def test_each_module_loads_alone_and_without_components():
    """As none waits for itself, it does not matter what is loaded before."""
    files = {}
    for path in (ROOT / "lumped").rglob("*.py"):
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        files[name.removesuffix(".__init__")] = path
    loads = nx.DiGraph()
    loads.add_nodes_from(files)
    for name, path in files.items():
        for other in loaded_by(ast.parse(path.read_text(encoding="utf-8")).body):
            above = {other.rsplit(".", k)[0] for k in range(other.count(".") + 1)} | {other}
            own = {a for a in above if f"{name}.".startswith(f"{a}.")}
            loads.add_edges_from((name, a) for a in (above - own) & files.keys())
    assert [*nx.simple_cycles(loads)] == []
    for name in PLACES:
        for source in sources(name).values():
            assert "lumped.components" not in nx.descendants(loads, source)


def test_the_contract_of_the_core_covers_all_that_loads_late():
    """import-linter sees no import that a name makes when it is first used."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = {c["id"]: c for c in settings["tool"]["importlinter"]["contracts"]}
    core = contracts["core"]
    assert core["forbidden_modules"] == ["lumped.components", "lumped.models"]
    late = set()
    for name in PLACES:
        for known, source in sources(name).items():
            late.add(f"lumped.{known}" if source == "lumped" else ".".join(source.split(".")[:2]))
    assert late <= {*core["source_modules"]}
    (layers,) = (c["layers"] for c in contracts.values() if c["type"] == "layers")
    above = {"(__main__)", "cli", "models", "components"}
    below = {f"lumped.{part}" for row in layers if row not in above for part in row.split(" | ")}
    assert below == {*core["source_modules"]}


# -- what is said --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (
            "modal_energy",
            "lumped has no 'modal_energy'. Did you mean lumped.vibration.modal_energies?",
        ),
        ("simulat", "lumped has no 'simulat'. Did you mean lumped.simulate?"),
        ("vibrations", "lumped has no 'vibrations'. Did you mean lumped.vibration?"),
        (
            "Xyzzy",
            "lumped has no 'Xyzzy'. dir(lumped) lists its names; components stand in "
            "lumped.components.",
        ),
        ("vibration.pareto", "lumped.vibration has no 'pareto'. It is lumped.optimisation.pareto."),
        ("vibration.assemble", "lumped.vibration has no 'assemble'. It is lumped.assemble."),
        ("vibration.turn", "lumped.vibration has no 'turn'. Did you mean lumped.vibration.turns?"),
        ("vibration._names", "lumped.vibration has no '_names'."),
    ],
)
def test_a_name_that_is_not_there_is_told_where_it_is(name, text):
    theme, _, last = name.rpartition(".")
    with pytest.raises(AttributeError) as caught:
        getattr(place(f"lumped.{theme}" if theme else "lumped"), last)
    assert str(caught.value) == text


@pytest.mark.parametrize("name", sorted(set(PUBLIC) - set(lp.__all__)))
def test_every_name_that_moved_into_a_theme_is_told_where_it_is(name):
    (theme,) = (theme for theme in THEMES if name in getattr(lp, theme).__all__)
    expected = rf"^lumped has no '{name}'\. It is lumped\.{theme}\.{name}\.$"
    with pytest.raises(AttributeError, match=expected):
        getattr(lp, name)


@pytest.mark.parametrize("library", ["components", "models"])
def test_a_library_is_told_how_to_be_imported(library):
    code = f"import lumped\ntry: lumped.{library}\nexcept AttributeError as error: print(error)"
    expected = f"lumped has no '{library}'. Write 'from lumped.{library} import ...'.\n"
    assert python("-c", code) == expected


def test_python_adds_no_suggestion_of_its_own():
    code = "import lumped\ntry: lumped.simulat\nexcept AttributeError:\n"
    code += "    import traceback; print(traceback.format_exc().splitlines()[-1])"
    expected = "AttributeError: lumped has no 'simulat'. Did you mean lumped.simulate?\n"
    assert python("-c", code) == expected
