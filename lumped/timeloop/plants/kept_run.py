"""Records of a run, which another run of the same thread has when it is over."""

from __future__ import annotations

import numpy as np

from lumped.code.records import Record, address
from lumped.kernel.enclosed import Enclosed
from lumped.kernel.instant_search import InstantSearch
from lumped.kernel.plant import Plant
from lumped.kernel.roots import Bracket
from lumped.kernel.run import Run, RunOutput

_TURNS = 256
"""Room for changes of the method between two visits to Python."""
_PARTS = {name: f.kind for name, f in InstantSearch.fields.items() if isinstance(f.kind, type)}
"""Records that belong to an instant."""


class OutputRoom:
    """Arrays that the time loop fills.

    Parameters
    ----------
    sizes : tuple of int
        Most points, smooth pieces and changes between two visits; states, implicit quantities and
        modes.

    Attributes
    ----------
    output : RunOutput
        The record with these arrays.
    t, x, implicit : ndarray, shapes (points,), (points, n) and (points, implicit)
        Times, states, implicit quantities.
    piece_settings : ndarray, shape (pieces, modes)
        Modes of each smooth piece.
    changes, when : ndarray, shapes (changes, 4) and (changes, 2)
        What changed; time and loss.
    turns : ndarray
        When the method changed, s.
    """

    def __init__(self, sizes: tuple[int, int, int, int, int, int]) -> None:
        self.sizes = sizes
        rows, pieces, changes, n, implicit, modes = sizes
        self.t, self.x = np.empty(rows), np.empty((rows, n))
        self.implicit, self.piece_settings = np.empty((rows, implicit)), np.empty((pieces, modes))
        self.changes, self.when = np.empty((changes, 4), dtype=np.int64), np.empty((changes, 2))
        self.turns = np.empty(_TURNS)
        self.output = RunOutput(
            t=self.t,
            x=self.x.ravel(),
            implicit=self.implicit.ravel(),
            most_rows=rows,
            piece_row=np.empty(pieces, dtype=np.int64),
            piece_settings=self.piece_settings.ravel(),
            most_pieces=pieces,
            change=self.changes.ravel(),
            change_time=self.when.ravel(),
            most_changes=changes,
            turn=self.turns,
            most_turns=len(self.turns),
        )

    def begin(self, grid: np.ndarray, taken: int, *, on_grid: bool, both_sides: bool) -> None:
        """Empty it for a run with output times, of which some were handed out."""
        out = self.output
        out.rows = out.pieces = out.changes = out.turns = 0
        out.grid, out.grid_size, out.grid_next = grid, len(grid), taken
        out.is_on_grid, out.has_both_sides = on_grid, both_sides


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
            self._memory_at_begin[:] = run.memory
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
    kinds: list[type[Record]] = [*_PARTS.values(), InstantSearch, Run]
    words = [kind.words(sizes) for kind in kinds]
    block = np.zeros(sum(words), dtype=np.int64)
    *parts, search, own = np.split(block, np.cumsum(words)[:-1])
    places = zip(_PARTS.items(), parts, strict=True)
    held = {name: kind(sizes, memory) for (name, kind), memory in places}
    instant = InstantSearch(sizes, search, **held)
    run = Run(sizes, own, plant=plant, instant=instant)
    run.enclosed_margins = Enclosed(sizes, results=plant.margins)
    run.enclosed_rates = Enclosed(sizes, results=plant.states, is_still=1)
    run.bracket = Bracket({})
    run.memory, run.memory_at_first = block, np.zeros_like(block)
    run.memory_size = (int(own[Run.fields["scratch"].place]) - address(block)) // 8
    return run


def remember(run: Run) -> None:
    """Note the present state of a run as the first one."""
    for record in _records(run):
        record.remember()
    run.memory_at_first[:] = run.memory


def place_of(run: Run, field: str) -> int:
    """Number of the word of a field in the memory of a run."""
    return (address(run) - address(run.memory)) // 8 + Run.fields[field].place


def _records(run: Run) -> list[Record]:
    """A run, and what it alone writes and another must find as it was."""
    instant = run.instant
    return [run, instant, *(getattr(instant, name) for name in _PARTS if name != "reserve")]
