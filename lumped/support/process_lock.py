"""One lock under which a process assembles, compiles and loads; forks wait until it is open.

CasADi and LLVM have locks of their own, which a forked process would find closed for ever.
"""

from __future__ import annotations

import os
import sys
from functools import cached_property
from threading import RLock
from typing import Any

process_lock = RLock()
"""Held by the one thread that makes something of symbols or of machine code."""
_held: list[Any] = []


def _close() -> None:
    """Wait for the lock, and for the one under which LLVM lets go of code, in any thread."""
    process_lock.acquire()
    if binding := sys.modules.get("llvmlite.binding.ffi"):
        binding.lib._lock._lock.acquire()
        _held.append(binding.lib._lock._lock)


def _open() -> None:
    while _held:
        _held.pop().release()
    process_lock.release()


def _open_properties() -> None:
    """Open cached properties, which Python 3.11 computes under locks of their own."""
    modules = [module for name, module in list(sys.modules.items()) if name.startswith("lumped")]
    classes = {c for module in modules for c in list(vars(module).values()) if isinstance(c, type)}
    for own in [own for c in classes for own in list(vars(c).values())]:
        if isinstance(own, cached_property):
            lock = vars(own)["lock"]
            if lock.acquire(blocking=False):
                lock.release()
            else:
                vars(own)["lock"] = RLock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_close, after_in_parent=_open, after_in_child=_open)
    if sys.version_info < (3, 12):
        os.register_at_fork(after_in_child=_open_properties)
