"""Locks that a forked process does not find closed by a thread that it does not have."""

from __future__ import annotations

import os
import sys
from functools import cached_property
from threading import RLock
from types import TracebackType
from weakref import WeakSet

__all__ = ["Lock", "forked_between"]


class Lock:
    """A re-entrant lock; a forked process has a new one if another thread held it."""

    def __init__(self) -> None:
        self._lock = RLock()
        _known.add(self)

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(
        self, kind: type[BaseException] | None, fault: object, trace: TracebackType | None
    ) -> None:
        self._lock.release()

    def open(self) -> None:
        """Take a new lock unless the old one is open or this thread's."""
        if self._lock.acquire(blocking=False):
            self._lock.release()
        else:
            self._lock = RLock()


_known: WeakSet[Lock] = WeakSet()


def forked_between(lock: RLock) -> RLock:
    """The lock, of which forks wait until no other thread holds it.

    Of several, the last one that was made is waited for first.
    """
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(
            before=lock.acquire, after_in_parent=lock.release, after_in_child=lock.release
        )
    return lock


def _open_all() -> None:
    for lock in list(_known):
        lock.open()
    if sys.version_info < (3, 12):
        _open_properties()


def _open_properties() -> None:
    """The same for cached properties, which Python 3.11 computes under locks of their own."""
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
    os.register_at_fork(after_in_child=_open_all)
