"""Pictures made in threads: quick ones together, slow ones after them, for the latest values."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from lumped.errors import LumpedError
from lumped.explorer.sliders import Slider
from lumped.explorer.study import Moment
from lumped.explorer.views import Shown, View

_QUICK = 0.15
"""Seconds below which a picture is made together with the other quick ones."""


@dataclass(frozen=True)
class Found:
    """A picture that was made: its tables, or why there are none.

    Attributes
    ----------
    view : View
        Which.
    shown : Shown or None
        Its tables.
    error : str
        Empty where there are tables.
    """

    view: View
    shown: Shown | None
    error: str = ""


class Computing:
    """Makes pictures for the latest values.

    Parameters
    ----------
    views : sequence of View
        Pictures.
    tell : callable
        Called in a thread with the latest moment, pictures that were made of it, and those that
        are still to come.
    """

    def __init__(
        self, views: Sequence[View], tell: Callable[[Moment, list[Found], list[View]], None]
    ) -> None:
        self._views, self._tell = tuple(views), tell
        self._seconds = {view.title: float("inf") for view in views}
        self._latest = 0
        self._first = ThreadPoolExecutor(1, "explorer-quick")
        self._then = ThreadPoolExecutor(1, "explorer-slow")

    def begin(self, moment: Moment, sliders: Sequence[Slider]) -> None:
        """Make all pictures of a moment; what was not made for earlier ones is left out."""
        self._latest += 1
        self._first.submit(self._quick, self._latest, moment, tuple(sliders))

    def later(self, task: Callable[[], None]) -> None:
        """Do something long after the pictures that are being made."""
        self._then.submit(task)

    def end(self) -> None:
        """Make nothing more."""
        self._latest += 1
        for threads in (self._first, self._then):
            threads.shutdown(wait=False, cancel_futures=True)

    def _quick(self, number: int, moment: Moment, sliders: tuple[Slider, ...]) -> None:
        quick = [view for view in self._views if self._seconds[view.title] <= _QUICK]
        found = []
        for view in quick:
            if number != self._latest:
                return
            found.append(self._make(view, moment, sliders))
        slow = [view for view in self._views if view not in quick]
        if number == self._latest:
            self._tell(moment, found, slow)
            self._then.submit(self._slow, number, moment, sliders, slow)

    def _slow(
        self, number: int, moment: Moment, sliders: tuple[Slider, ...], slow: list[View]
    ) -> None:
        for i, view in enumerate(slow):
            if number != self._latest:
                return
            found = self._make(view, moment, sliders)
            if number == self._latest:
                self._tell(moment, [found], slow[i + 1 :])

    def _make(self, view: View, moment: Moment, sliders: tuple[Slider, ...]) -> Found:
        begin = time.perf_counter()
        try:
            found = Found(view, view.compute(moment, sliders))
        except Exception as fault:  # functions of the user may raise anything
            found = Found(view, None, in_words(fault))
        self._seconds[view.title] = time.perf_counter() - begin
        return found


def in_words(fault: Exception) -> str:
    """What went wrong; errors that are not ours are named by their kind."""
    return str(fault) if isinstance(fault, LumpedError) else f"{type(fault).__name__}: {fault}"
