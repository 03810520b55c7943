"""Records of a run, which another run of the same thread has when it is over."""

from __future__ import annotations

import numpy as np

from lumped.code.records import Record
from lumped.kernel.enclosed import Enclosed
from lumped.kernel.instant_search import InstantSearch
from lumped.kernel.plant import Plant
from lumped.kernel.roots import Bracket
from lumped.kernel.run import Run
from lumped.timeloop.plants.output_room import OutputRoom

_PARTS = {name: f.kind for name, f in InstantSearch.fields.items() if isinstance(f.kind, type)}
"""Records that belong to an instant."""


class KeptRun:
    """A run with its room for output, which has its options and is at no point yet.

    Parameters
    ----------
    options : object
        All that the records depend on, but for the point and the time of a run.
    run : Run
        With these options.
    room : OutputRoom
        Where it writes.

    Attributes
    ----------
    times : object
        Begin, end and output times that the records have at the begin; None if they have none.
    """

    def __init__(self, options: object, run: Run, room: OutputRoom) -> None:
        self.options, self.run, self.room = options, run, room
        self.times: object = None
        self._memory_at_begin = run.memory.copy()

    def note(self, times: object) -> None:
        """Have these times at the begin from now on."""
        self.times = times
        self._memory_at_begin[:] = self.run.memory

    def begin(self) -> None:
        """Make the records those at the begin of a run with the same options and times."""
        run = self.run
        had_matrix = run.has_matrix
        run.memory[:] = self._memory_at_begin
        if had_matrix and not run.has_matrix:
            run.matrix, run.work, run.has_matrix = run.matrix, run.work, 1
        self.room.output.grid_next = 0

    def begin_again(self) -> tuple[Run, OutputRoom]:
        """The run without options, but with its matrix; and the room."""
        run = self.run
        held = (run.matrix, run.work) if run.has_matrix else None
        run.memory[:] = run.memory_at_first
        for record in _records(run):
            record.begin_again()
        if held is not None:
            run.matrix, run.work = held
            run.has_matrix = 1
        return run, self.room


def make_run(sizes: dict[str, int], plant: Plant) -> Run:
    """A run; what it writes is in one block of memory."""
    kinds: list[type[Record]] = [Run, InstantSearch, *_PARTS.values()]
    words = [kind.words(sizes) for kind in kinds]
    block = np.zeros(sum(words), dtype=np.int64)
    own, search, *parts = np.split(block, np.cumsum(words)[:-1])
    places = zip(_PARTS.items(), parts, strict=True)
    held = {name: kind(sizes, memory) for (name, kind), memory in places}
    instant = InstantSearch(sizes, search, **held)
    run = Run(sizes, own, plant=plant, instant=instant)
    run.enclosed_margins = Enclosed(sizes, results=plant.margins)
    run.enclosed_rates = Enclosed(sizes, results=plant.states, is_still=1)
    run.bracket = Bracket({})
    run.memory, run.memory_at_first, run.memory_size = block, np.zeros_like(block), len(block)
    return run


def remember(run: Run) -> None:
    """Note the present state of a run as the first one."""
    for record in _records(run):
        record.remember()
    run.memory_at_first[:] = run.memory


def _records(run: Run) -> list[Record]:
    """A run, and what it alone writes and another must find as it was."""
    instant = run.instant
    return [run, instant, *(getattr(instant, name) for name in _PARTS if name != "reserve")]
