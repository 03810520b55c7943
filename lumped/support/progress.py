"""Progress of long work, on a terminal."""

from __future__ import annotations

import sys
import time as clock
from weakref import WeakSet

_FIRST, _EVERY = 1.0, 0.2  # s

_open: WeakSet[Progress] = WeakSet()
"""The work whose line is shown; at most one.

Held weakly, as an interrupt between two instructions may leave a block without its end.
"""


class Progress:
    """A line that says how much is done and how long the rest will take.

    It appears after a second, and only if standard error is a terminal. Of nested work only the
    outermost is shown.

    Parameters
    ----------
    what : str
        Name of the work.
    total : float
        Total amount of work.

    Attributes
    ----------
    is_shown : bool
        Whether there is ever a line.
    """

    def __init__(self, what: str, total: float) -> None:
        self._what, self._total = what, total
        self._begin = clock.monotonic()
        self.is_shown = sys.stderr.isatty() and not _open
        self._next, self._shown = self._begin + _FIRST, False

    def at(self, done: float) -> None:
        """Show how much is done."""
        if not (self.is_shown and done):
            return
        now = clock.monotonic()
        if now < self._next:
            return
        left = (now - self._begin) * (self._total / done - 1.0)
        text = f"{self._what}: {100 * done / self._total:.0f} %, {_format_time(left)} left"
        sys.stderr.write(f"\r{text:<78}")
        sys.stderr.flush()
        self._next, self._shown = now + _EVERY, True

    def __enter__(self) -> Progress:
        if self.is_shown:
            _open.add(self)
        return self

    def __exit__(self, *_: object) -> None:
        """Remove the line."""
        if self.is_shown:
            _open.discard(self)
        if self._shown:
            sys.stderr.write("\r" + " " * 78 + "\r")
            sys.stderr.flush()
            self._shown = False


def _format_time(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
