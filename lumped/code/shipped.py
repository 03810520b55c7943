"""Machine code that a wheel brings along: it is as valid as the modules from which it was made.

The name of a file has the hash of these modules, so an edited module finds none. Versions of Python
and packages do not matter, since nothing is made from them any more but the numbers by which CasADi
calls its operations.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import casadi as ca

from lumped.code.machine_code import Code, compile_module
from lumped.code.sources import hash_of_modules
from lumped.code.targets import Target, find_own_target
from lumped.support.process_lock import process_lock

FOLDER = Path(__file__).with_name("shipped_code")


def _name(kind: str, target: Target) -> str:
    numbers = [f"{name} {getattr(ca, name)}" for name in sorted(dir(ca)) if name[:3] == "OP_"]
    key = hashlib.sha256("\n".join([hash_of_modules(), *numbers]).encode()).hexdigest()
    return f"{kind}-{target.name}-{key[:16]}.o"


def write_code(modules: Mapping[str, Callable[[], str]], targets: Iterable[Target]) -> None:
    """Write machine code of modules, given by name and LLVM assembly."""
    FOLDER.mkdir()
    texts = {kind: write() for kind, write in modules.items()}
    for target in targets:
        for kind, text in texts.items():
            code = compile_module(True, text, machine=target.machine())
            (FOLDER / _name(kind, target)).write_bytes(code)


def load_code(kind: str) -> Code | None:
    """Machine code of a module for this processor; None if the package brings none."""
    target = find_own_target()
    if target is None or not FOLDER.is_dir():
        return None
    try:
        code = (FOLDER / _name(kind, target)).read_bytes()
    except OSError:
        return None
    with process_lock:
        return Code(code)
