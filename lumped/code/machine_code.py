"""Machine code from LLVM assembly, in this process."""

from __future__ import annotations

import hashlib
import weakref
from collections.abc import Callable
from functools import cache
from typing import Any

import llvmlite
import llvmlite.binding as llvm

from lumped.code import code_cache
from lumped.support.process_lock import process_lock

"""LLVM compiles and links for one thread at a time."""


@cache
def _target() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple()


def _target_machine() -> Any:
    features = llvm.get_host_cpu_features().flatten()
    return _target().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=features, opt=2, jit=True
    )


@cache
def _host() -> str:
    """Text of all on which object code depends besides its source."""
    _target()
    cpu = (llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten())
    return "|".join((llvmlite.__version__, llvm.get_default_triple(), *cpu))


_engines: dict[int, Any] = {}
"""What LLVM linked, until code is linked again after the last use.

LLVM frees it under a lock of its own, which a process forked beside a thread whose collector of
garbage does so would find closed for ever.
"""
_unused: list[int] = []


class Code:
    """Object code linked into this process."""

    def __init__(self, code: bytes) -> None:
        while _unused:
            del _engines[_unused.pop()]
        empty = llvm.parse_assembly("")
        self._engine = llvm.create_mcjit_compiler(empty, _target_machine())
        _engines[id(self._engine)] = self._engine
        weakref.finalize(self, _unused.append, id(self._engine)).atexit = False
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()

    def address(self, name: str) -> int:
        """Address of a function.

        Raises
        ------
        KeyError
            If there is none of this name.
        """
        found: int = self._engine.get_function_address(name)
        if not found:
            raise KeyError(name)
        return found


def load_or_compile(
    source: str,
    write: Callable[[], tuple[str, ...]],
    prefix: str = "",
) -> Code:
    """Object code of a source: kept from before, or compiled now.

    Parameters
    ----------
    source : str
        Text that identifies the code.
    write : callable
        Gives the LLVM assembly if it is needed; behind it that of functions that it calls, which
        are optimised in any case.
    prefix : str
        Begin of the name under which the code is kept. Code with a prefix is optimised by LLVM;
        straight-line code does not need that.
    """
    with process_lock:
        found = load_code(source, prefix)
        if found is not None:
            return found
        code = compile_module(bool(prefix), *write())
        code_cache.save(_key(source, prefix), code)
        return Code(code)


def load_code(source: str, prefix: str = "") -> Code | None:
    """Object code made before from the same source; None if there is none."""
    with process_lock:
        code = code_cache.load(_key(source, prefix))
        return None if code is None else Code(code)


def _key(source: str, prefix: str) -> str:
    return prefix + hashlib.sha256((source + _host()).encode()).hexdigest()


def compile_module(tuned: bool, assembly: str, *called: str, machine: Any = None) -> bytes:
    """Object code of an LLVM module, and of others that it calls, which are always tuned.

    It is made for this processor unless another ``machine`` is given.
    """
    target = machine or _target_machine()
    module = _module(assembly, tuned, target)
    for text in called:
        module.link_in(_module(text, True, target))
    code: bytes = target.emit_object(module)
    return code


def _module(assembly: str, tuned: bool, target: Any) -> Any:
    module = llvm.parse_assembly(assembly)
    module.verify()
    if tuned:
        # unrolled loops take a third of the time to compile and make no run faster
        tuning = llvm.create_pipeline_tuning_options(speed_level=2)
        tuning.loop_unrolling = tuning.slp_vectorization = False
        builder = llvm.create_pass_builder(target, tuning)
        builder.getModulePassManager().run(module, builder)
    return module
