"""Object code on disk."""

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from lumped.code import code_cache, sources

SCRIPT = """
import lumped as lp
from lumped.components import Inertia, Spring
from lumped.timeloop.plants.executable import executable

model = lp.compose(
    a=Inertia(J=1.0, w=1.0),
    s=Spring(c=10.0),
    b=Inertia(J=2.0),
    connections=lambda m: lp.chain(m.a, m.s, m.b),
)
system = lp.assemble(model)
executable(system).compile()
run = lp.simulate(system, until=1.0, rtol=1e-9, grid=[1.0], method="steps")
print(repr(float(run["s.phi_rel"][-1])))
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("LUMPED_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def files_in(folder):
    return [path for path in folder.rglob("*") if path.is_file()]


def test_what_was_saved_is_found_again(folder):
    assert code_cache.load("key") is None
    code_cache.save("key", b"machine code")
    assert code_cache.load("key") == b"machine code"
    assert [path.name for path in folder.iterdir()] == ["key"]


@pytest.mark.parametrize("damage", [b"", b"lumped-1", b"something else, and long enough for a sum"])
def test_a_damaged_file_counts_as_none(folder, damage):
    code_cache.save("key", b"machine code")
    (folder / "key").write_bytes(damage)
    assert code_cache.load("key") is None
    whole = b"machine code"
    code_cache.save("key", whole)
    (folder / "key").write_bytes((folder / "key").read_bytes()[:-1])
    assert code_cache.load("key") is None


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("LUMPED_CACHE", str(tmp_path / "file"))
    code_cache.save("key", b"machine code")
    assert code_cache.load("key") is None


def test_the_folder_is_that_of_the_user(monkeypatch, tmp_path):
    monkeypatch.delenv("LUMPED_CACHE", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert code_cache.folder() == tmp_path / "lumped"


NO_HOME = """
import os, pwd, sys
os.environ.pop("HOME", None)
def nobody(number):
    raise KeyError("getpwuid(): uid not found")
pwd.getpwuid = nobody
"""


@pytest.mark.skipif(sys.platform == "win32", reason="homes are found otherwise")
def test_without_a_home_runs_are_made_without_a_cache(tmp_path):
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("LUMPED", "XDG", "HOME"))}
    environment = kept | {"MPLCONFIGDIR": str(tmp_path)}
    told = subprocess.run(
        [sys.executable, "-c", NO_HOME + SCRIPT],
        env=environment,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert told.returncode == 0, told.stderr
    omega = np.sqrt(10.0 * (1 + 1 / 2))
    assert float(told.stdout) == pytest.approx(-np.sin(omega) / omega, rel=1e-6)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="there is no limit for files")
def test_a_full_disk_leaves_no_half_of_a_file(folder):
    import resource

    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))
    try:
        code_cache.save("key", bytes(1000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert code_cache.load("key") is None
    assert list(folder.iterdir()) == []


def test_processes_at_once_and_damage_between_them(tmp_path):
    """Two begin without code of the model; the next finds it spoiled. The time loop is copied."""
    exec(SCRIPT, {})
    folder, loop = tmp_path / "cache", code_cache.loop_name()
    folder.mkdir(mode=0o700)
    shutil.copytree(code_cache.folder() / loop, folder / loop)
    loops = set(files_in(folder))
    environment = {**os.environ, "LUMPED_CACHE": str(folder)}
    command = [sys.executable, "-c", SCRIPT]

    def begun():
        return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)

    told = [process.communicate()[0] for process in [begun() for _ in range(2)]]
    (made,) = set(files_in(folder)) - loops
    made.write_bytes(made.read_bytes()[:-7])
    told.append(begun().communicate()[0])
    assert told == [told[0]] * 3
    # two bodies on a spring: the twist swings with c (1/J + 1/J') and starts with -1 rad/s
    omega = np.sqrt(10.0 * (1 + 1 / 2))
    assert float(told[0]) == pytest.approx(-np.sin(omega) / omega, rel=1e-6)
    assert set(files_in(folder)) == {made, *loops}


OTHERS = 12345
needs_root = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away"
)
needs_modes = pytest.mark.skipif(sys.platform == "win32", reason="files have no modes")


@pytest.fixture
def filled(folder):
    """A folder of code, and what gives each of its parts away."""
    code_cache.save("loop-1/key", b"machine code")
    code_cache._warn.cache_clear()
    return folder


PARTS = [".", "loop-1", "loop-1/key"]


def refused(folder, part):
    """Whether code is not loaded, with a warning that names what others may have written."""
    with pytest.warns(RuntimeWarning, match=r"compiled code is executed.*LUMPED_CACHE") as told:
        found = [code_cache.load("loop-1/key") for _ in range(2)]
    texts = [str(warning.message) for warning in told]
    assert found == [None, None]
    assert len(texts) == 1
    return texts[0].startswith(f"{folder / part} belongs to another user")


@needs_modes
@pytest.mark.parametrize("mode", [0o020, 0o002])
@pytest.mark.parametrize("part", PARTS)
def test_code_that_others_may_write_is_refused(filled, part, mode):
    place = filled / part
    place.chmod(place.stat().st_mode | mode)
    assert refused(filled, part)


@needs_root
@pytest.mark.parametrize("part", PARTS)
def test_code_of_another_user_is_refused(filled, part):
    os.chown(filled / part, OTHERS, OTHERS)
    assert refused(filled, part)


@needs_modes
def test_nothing_is_written_into_a_folder_that_others_may_write(filled):
    target = filled.parent / "target"
    target.write_bytes(b"mine")
    (filled / "loop-1" / "other").symlink_to(target)
    (filled / "loop-1").chmod(0o777)
    with pytest.warns(RuntimeWarning, match="compiled code is executed"):
        code_cache.save("loop-1/other", b"machine code")
    assert target.read_bytes() == b"mine"


@needs_modes
def test_what_is_saved_can_be_loaded_whatever_the_mask(folder):
    before = os.umask(0)
    try:
        code_cache.save("loop-1/key", b"machine code")
    finally:
        os.umask(before)
    assert code_cache.load("loop-1/key") == b"machine code"


def told_by(script, folder):
    """What a process prints whose code stands in a folder."""
    environment = {**os.environ, "LUMPED_CACHE": str(folder)}
    command = [sys.executable, "-W", "ignore", "-c", script]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return done.stdout


# -- what the code is made from --------------------------------------------------------------------

LOADED = """
import sys
import lumped.code.to_c
import lumped.code.to_llvm
import lumped.kernel.engine
import lumped.kernel.entries
import lumped.kernel.many_runs.lanes
print(*(m.__file__ for n, m in sys.modules.items() if n.startswith("lumped.")))
"""


def test_all_modules_that_kernels_import_are_in_the_name_of_their_code(folder):
    loaded = {Path(file) for file in told_by(LOADED, folder).split()}
    files = set(sources.find_files())
    assert {file.stem for file in loaded} > {"hold_modes", "dop853", "lanes", "translate"}
    assert {file for file in loaded - files if file.read_text().strip().count("\n") > 0} == set()
    trees = [node for file in loaded for node in ast.walk(ast.parse(file.read_text()))]
    names = [alias.name for node in trees if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module for node in trees if isinstance(node, ast.ImportFrom) and node.module]
    packages = {name.partition(".")[0] for name in names} - sys.stdlib_module_names - {"lumped"}
    assert packages == set(sources.PACKAGES)


def test_other_constants_have_other_code(monkeypatch, tmp_path):
    before = sources.hash_of_modules()
    package = shutil.copytree(sources._PACKAGE, tmp_path / "lumped", symlinks=False)
    monkeypatch.setattr(sources, "_PACKAGE", package)
    assert sources.hash_of_modules.__wrapped__() == before
    modes = package / "flattening" / "hold_modes.py"
    text = modes.read_text()
    modes.write_text(text.replace("STUCK, FORWARD, BACKWARD,", "STUCK, BACKWARD, FORWARD,"))
    assert modes.read_text() != text
    assert sources.hash_of_modules.__wrapped__() != before


@pytest.mark.parametrize("package", sources.PACKAGES)
def test_another_version_of_a_package_has_other_code(monkeypatch, package):
    before = sources.hash_of_all()
    old = sources.version
    monkeypatch.setattr(sources, "version", lambda name: "0" if name == package else old(name))
    assert sources.hash_of_all.__wrapped__() != before
