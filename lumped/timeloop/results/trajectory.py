"""Simulated runs: frozen, answering to names and references, printing as tables."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError, UnknownNameError
from lumped.functionals import Functional
from lumped.plots.draw import Canvas, draw
from lumped.support.arguments import checked
from lumped.support.display_units import Units, choose_units
from lumped.support.text_table import amounts, table
from lumped.support.units import read_time
from lumped.timeloop.fit_states import SingularPositionError, singular_text
from lumped.timeloop.leading_states import bind_states
from lumped.timeloop.plants.many_points import quantity_along
from lumped.timeloop.programs import ProgramInputs
from lumped.timeloop.results.event import Event
from lumped.timeloop.results.fingerprint import fingerprint
from lumped.timeloop.results.operating_point import (
    Named,
    OperatingPoint,
    PointOfRun,
    on_both_sides,
    with_left_out,
)
from lumped.timeloop.results.result_files import Saved, draw_curves, list_computable, state_names
from lumped.timeloop.results.statistics import Statistics

Read = Callable[[Sequence[Functional]], np.ndarray]
Again = Callable[[np.ndarray], "Trajectory"]


@dataclass(frozen=True, eq=False)
class Piece:
    """A smooth part of a run.

    Attributes
    ----------
    system : System
        The system with the states of this part.
    t : ndarray, shape (k,)
        Times, s.
    x : ndarray, shape (k, n)
        States.
    settings : ndarray, shape (k, m)
        Modes, and implicit quantities nearby.
    ends : ndarray or None
        Ends of all steps, s, if points are recorded at some of them only.
    """

    system: System
    t: np.ndarray
    x: np.ndarray
    settings: np.ndarray
    ends: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Trajectory(Named):
    """A simulated run.

    ``run[name]`` gives any quantity of the system over `t`; it is computed when first asked for.
    ``run[[name, name]]`` gives several as columns, ``list(run)`` all names.

    Attributes
    ----------
    system : System
        What was simulated.
    pieces : tuple of Piece
        Smooth parts, in order of time.
    theta : ndarray
        Parameters.
    events : tuple of Event
        Jumps of functions of time, changes of modes, impacts, and changes of states.
    statistics : Statistics
        Cost of the run.
    certificate : Certificate or None
        Error estimate, if it was asked for.
    read : callable or None
        Makes the run again and gives functionals of it; None where nobody can.
    again : callable or None
        Makes the same run with the states that were left out, at some times and on both sides of
        its own jumps; None where there are none, or nobody can.
    program_inputs : dict of int to ndarray, shape (samples, 1 + values)
        Instants at which programs were asked, s, and what they were given, by the number of the
        jump; with it a run that goes on from here brings them to where they were.
    """

    system: System
    pieces: tuple[Piece, ...]
    theta: np.ndarray
    events: tuple[Event, ...]
    statistics: Statistics
    certificate: Any = None
    read: Read | None = None
    again: Again | None = None
    program_inputs: ProgramInputs = field(default_factory=dict)
    _known: dict[str, np.ndarray] = field(default_factory=dict, repr=False)

    @cached_property
    def t(self) -> np.ndarray:
        """Times, s; on a jump the same time occurs twice, before and after it."""
        return np.concatenate([np.zeros(0), *(piece.t for piece in self.pieces)])

    @cached_property
    def x(self) -> np.ndarray:
        """States, shape (len(t), n), in the order of the system."""
        if any(piece.system is not self.system for piece in self.pieces):
            return np.column_stack([self._along(name) for name in self.system.state_names])
        none = np.zeros((0, len(self.system.structure.states)))
        return np.concatenate([none, *(piece.x for piece in self.pieces)])

    @checked
    def value(self, of: Functional) -> float:
        """A functional of the run, such as ``lumped.functionals.peak("shaft.tau")``.

        The run is made again from its start, and the time loop collects what the functional reads
        on the way, as for an ensemble: to the tolerance of the run, whatever its output times are.

        Parameters
        ----------
        of : Functional
            From `lumped.functionals`.

        Returns
        -------
        float

        Raises
        ------
        OptionError
            If the run has no such functional, an event that it asks for does not happen, or the run
            does not come from `lumped.simulate`.
        UnknownNameError
            If a quantity does not exist.
        """
        if self.read is None:
            raise OptionError(f"{self.system.name}: {of}: only runs from lumped.simulate are read.")
        return float(self.read([of])[0])

    @property
    def steps(self) -> int:
        """Accepted steps."""
        return self.statistics.steps

    def __getitem__(self, name: Name | list[Name]) -> np.ndarray:
        if isinstance(name, list):
            return self.table(name)
        key = self.system.key(name)
        if key == "time":
            return self.t
        if key not in self._known:
            try:
                found = self._along(key)
            except UnknownNameError:
                if self.again is None:
                    raise
                found = self.whole[key]
            bad = np.flatnonzero(np.isnan(found))
            if len(bad):
                raise SolverError(
                    f"{self.system.name}: {key} is not a number at t = {self.t[bad[0]]:g} s "
                    f"(and at {len(bad) - 1} other times of {len(found)}): zero over zero or a "
                    "function outside its range, such as a linkage that a prescribed motion asks "
                    "to go where it cannot. Check the motion and the parameters that enter it."
                )
            self._known[key] = found
        return self._known[key]

    def _along(self, key: str) -> np.ndarray:
        """A quantity at all times."""
        parts = [np.zeros(0)]
        for system, pieces in itertools.groupby(self.pieces, lambda piece: piece.system):
            rows = zip(*((p.t, p.x, p.settings) for p in pieces), strict=True)
            t, x, settings = map(np.concatenate, rows)
            if key in system.state_names:
                parts.append(x[:, system.state_names.index(key)])
            elif len(t):
                parts.append(quantity_along(system, key, self.theta, t, x, settings))
        return np.concatenate(parts)

    @cached_property
    def whole(self) -> Trajectory:
        """The run with the states that were left out, if they can be made.

        They are integrated in another run with the same tolerances; all else is that of this run.
        """
        if self.again is None or not len(self.t):
            return self
        run, pieces, first = self.again(self.t), [], 0
        for piece in self.pieces:
            here = slice(first, first + len(piece.t))
            first = here.stop

            def read_left_out(name: str, here: slice = here) -> np.ndarray:
                return on_both_sides(run.t, run[name], self.t)[here]

            system, x = with_left_out(piece.system, piece.x, read_left_out)
            pieces.append(replace(piece, system=system, x=x))
        return replace(self, pieces=tuple(pieces), again=None, _known={})

    def check_instant(self, time: float) -> None:
        """Refuse an instant outside of the run."""
        if not self.t[0] <= time <= self.t[-1]:
            raise OptionError(
                f"{self.system.name}: t = {time:g} s is not within the run, {self.t[0]:g} to "
                f"{self.t[-1]:g} s."
            )

    @checked
    def point(self, time: float | str) -> OperatingPoint:
        """The recorded point nearest to a time, to linearise there; on a jump that after it.

        Raises
        ------
        OptionError
            If the time is not within the run.
        """
        time = read_time(time, "t")
        if not len(self.t):
            raise OptionError(f"{self.system.name}: nothing was computed, so there is no point.")
        self.check_instant(time)
        pieces = [piece for piece in self.pieces if len(piece.t)]
        distance = [np.abs(piece.t - time).min() for piece in pieces]
        piece = pieces[len(pieces) - 1 - int(np.argmin(distance[::-1]))]
        gaps = np.abs(piece.t - time)[::-1]
        k = len(gaps) - 1 - int(gaps.argmin())
        found, made = float(piece.t[k]), self.again
        system, x, settings = piece.system, piece.x[k].copy(), piece.settings[k].copy()
        if system.structure.redundant:
            try:
                own = bind_states(self.system.bound, system, self.theta, found, x, settings)
            except SingularPositionError as error:
                text = singular_text(system, error, f"t = {found:g} s")
                raise OptionError(text) from None
            system, x, settings = own
        again = None if made is None else PointOfRun(made, found)
        return OperatingPoint(
            system,
            found,
            x,
            self.theta,
            settings,
            again=again,
            program_inputs={
                k: rows[rows[:, 0] <= found] for k, rows in self.program_inputs.items()
            },
        )

    @checked
    def table(self, names: Iterable[Name]) -> np.ndarray:
        """Several quantities as columns, shape (k, len(names))."""
        columns = [self[name] for name in names]
        if not columns:
            raise OptionError(f"{self.system.name}: name at least one quantity.")
        return np.column_stack(columns)

    @checked
    def save(
        self, path: str | Path, names: Iterable[Name] | None = None, *, units: Units = None
    ) -> Path:
        """Write quantities to a file (.nc, .npz, .csv, .mat); see `lumped.load` to read it.

        The file is written whole or not at all.

        Parameters
        ----------
        path : str or Path
            Its ending says the format; ``.mat`` is the result file of Modelica tools.
        names : iterable of names, optional
            Quantities; default is all that need no state that was left out.
        units : mapping of str to str or str, optional
            Units of the values, see `lumped.display_units`; default is SI units, whatever the
            session shows, as a file is read by programs.

        Raises
        ------
        OptionError
            If the ending is none of these.
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        OSError
            If the file cannot be written.
        """
        return self._select(names).write(path, units=units)

    @checked
    def to_pandas(self, names: Iterable[Name] | None = None, *, units: Units = None) -> Any:
        """A pandas DataFrame over the time, one column for each quantity (see `Saved`)."""
        return self._select(names).to_pandas(units=units)

    @checked
    def to_xarray(self, names: Iterable[Name] | None = None, *, units: Units = None) -> Any:
        """An xarray Dataset over the time, with units and texts as attributes (see `Saved`)."""
        return self._select(names).to_xarray(units=units)

    def _select(self, names: Iterable[Name] | None) -> Saved:
        """Some quantities by themselves; all that need no state that was left out by default."""
        system, p = self.system, self.system.structure.parameters
        chosen = list_computable(system) if names is None else [system.key(n) for n in names]
        if names is not None and not chosen:
            raise OptionError(f"{system.name}: name at least one quantity.")
        quantities = {name: system.quantity(name) for name in chosen}
        return Saved(
            self.t,
            {name: self[name] for name in chosen},
            {name: quantity.unit for name, quantity in quantities.items()},
            {name: quantity.text for name, quantity in quantities.items()},
            dict(zip(p.free_names, self.theta.tolist(), strict=True)),
            {p.names[i]: p.declared[i].unit for i in p.free},
            system.name,
            fingerprint(system),
            tuple(name for name in state_names(system) if name in quantities),
            self.events,
        )

    @checked
    def plot(
        self,
        names: Iterable[Name] | None = None,
        *,
        units: Units = None,
        **canvas: Unpack[Canvas],
    ) -> Any:
        """Curves over time; marks on the time axis tell what happened.

        A panel holds quantities of one unit and of similar range. Without `names` up to six panels
        of eight curves each are drawn, and a note says how many are left out.

        Parameters
        ----------
        names : iterable of names or references, optional
            Quantities to draw, all of them; default is the states.
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).
        backend : {"matplotlib", "plotly"}
            What draws; plotly makes an interactive figure.
        ax : matplotlib Axes, or an array of as many as there are panels, optional
            Where matplotlib draws; default is a new figure, which needs no display.

        Returns
        -------
        matplotlib.figure.Figure or plotly.graph_objects.Figure

        Raises
        ------
        OptionError
            If there is nothing to draw, plotly is not installed, or `ax` does not fit.
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        system = self.system
        wanted = [*(state_names(system) if names is None else map(system.key, names))]
        quantities = {name: system.quantity(name) for name in wanted}
        found = {name: (q.unit, q.text, self[name]) for name, q in quantities.items()}
        choice = choose_units(units, ("time", *self))
        picture = draw_curves(system.name, self.t, found, self.events, choice, names is not None)
        return draw(picture, **canvas)

    def __repr__(self) -> str:
        s = self.statistics
        if not len(self.t):
            return f"{self.system.name}: nothing was computed"
        head = (
            f"{self.system.name}: {self.t[0]:g} to {self.t[-1]:g} s, {len(self.t)} points; "
            f"{s.method}, {s.steps} steps, {s.rejected} rejected, "
            f"{s.evaluations} evaluations, {len(self.events)} events"
        )
        rows = []
        for name in self.system.state_names[:12]:
            if "(" in name:
                continue
            y, unit = self[name], self.system.quantity(name).unit
            rows.append((name, *amounts(name, unit, y[0], y[-1], y.min(), y.max())))
        if s.method in ("exact", "explicit then implicit", "explicit and implicit"):
            head += f"\n{s.method}: {s.why}"
        if self.statistics.small:
            head += (
                f"\nsmall, so that the absolute tolerance governs their accuracy: "
                f"{', '.join(self.statistics.small)}"
            )
        text = head + "\n" + table(("state", "start", "end", "min", "max", "unit"), rows)
        return text if self.certificate is None else f"{text}\n\n{self.certificate!r}"
