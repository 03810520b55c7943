"""One lock under which a process assembles, compiles and loads; forks wait until it is open.

CasADi and LLVM have locks of their own, which a forked process would find closed for ever.
"""

from __future__ import annotations

import os
import sys
from functools import cached_property
from threading import RLock

process_lock = RLock()
"""Held by the one thread that makes something of symbols or of machine code."""


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
    os.register_at_fork(
        before=process_lock.acquire,
        after_in_parent=process_lock.release,
        after_in_child=process_lock.release,
    )
    if sys.version_info < (3, 12):
        os.register_at_fork(after_in_child=_open_properties)
