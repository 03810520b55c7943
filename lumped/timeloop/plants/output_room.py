"""Room for what comes back from the time loop; one run after the other uses it."""

from __future__ import annotations

import numpy as np

from lumped.kernel.run import RunOutput

_TURNS = 256
"""Room for changes of the method between two visits to Python."""


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
