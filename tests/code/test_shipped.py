"""Machine code that a wheel brings along."""

import ctypes
import struct

import numpy as np
import pytest

from lumped.code import shipped, sources, targets
from lumped.code.records import address
from lumped.code.to_llvm import as_llvm
from lumped.code.words import Integers, Numbers, kernel

X86, ARM = 62, 183
"""Numbers of processors in the head of an object file."""


@kernel
def sum_of_squares(n: Integers, x: Numbers) -> float:
    """Of some numbers."""
    total = 0.0
    for i in range(n[0]):
        total += x[i] * x[i]
    return total


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(shipped, "FOLDER", tmp_path / "shipped_code")
    text = as_llvm({"sum_of_squares": sum_of_squares})
    shipped.write_code({"sums": lambda: text}, targets.RELEASED)
    return shipped.FOLDER


def test_release_has_a_file_for_each_target(folder):
    received = {}
    for file in folder.iterdir():
        (processor,) = struct.unpack_from("<H", file.read_bytes(), 18)
        received[file.name.rpartition("-")[0]] = processor
    expected = {f"sums-x86_64-linux-x86-64-v{level}": X86 for level in (2, 3, 4)}
    assert received == expected | {"sums-aarch64-linux-generic": ARM}


def own_levels():
    """Targets of a release whose machine code this processor can run."""
    own = targets.find_own_target()
    names = [target.name for target in targets.RELEASED]
    if own is None or own.name not in names:
        return []
    own_part = own.name.partition("-")[0]
    return [t for t in targets.RELEASED[names.index(own.name) :] if t.name.startswith(own_part)]


@pytest.mark.parametrize("target", own_levels(), ids=lambda target: target.level)
@pytest.mark.usefixtures("folder")
def test_code_for_each_level_of_this_processor_runs(target, monkeypatch):
    monkeypatch.setattr(shipped, "find_own_target", lambda: target)
    code = shipped.load_code("sums")
    call = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p)
    n, x = np.array([24]), np.arange(1.0, 25.0)
    assert call(code.address("sum_of_squares"))(address(n), address(x)) == 70.0**2


@pytest.mark.parametrize("what", ["modules", "system", "level"])
@pytest.mark.usefixtures("folder")
def test_code_of_other_modules_or_processors_is_not_taken(what, monkeypatch):
    linux = targets.RELEASED[-1]
    other = {"system": ("aarch64-apple-darwin23.1", "generic"), "level": (linux.triple, "v9")}
    target = targets.Target(*other.get(what, linux))
    monkeypatch.setattr(shipped, "find_own_target", lambda: target)
    if what == "modules":
        monkeypatch.setattr(shipped, "hash_of_modules", lambda: sources.hash_of_modules() + "0")
    assert shipped.load_code("sums") is None


def test_level_of_a_processor_is_the_highest_whose_instructions_it_has(monkeypatch):
    words = " ".join(targets._X86_LEVELS.values()).split()
    received = []
    for missing in ("none", "avx512vl", "fma", "popcnt"):
        features = {word: word != missing for word in words}
        monkeypatch.setattr(targets.llvm, "get_host_cpu_features", lambda f=features: f)
        monkeypatch.setattr(targets.llvm, "get_process_triple", lambda: "x86_64-pc-linux-gnu")
        found = targets.find_own_target.__wrapped__()
        received.append(found and found.name)
    expected = [f"x86_64-linux-x86-64-v{level}" for level in (4, 3, 2)]
    assert received == [*expected, None]
