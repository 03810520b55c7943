"""Results in files and in the tables of other libraries."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError, UnknownNameError, nearest
from lumped.flattening.tree import key_of
from lumped.plots.draw import Canvas, draw
from lumped.plots.over_time import draw_over_time
from lumped.plots.picture import Picture
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.by_name import ByName
from lumped.support.display_units import Units, choose_units, display, time_unit
from lumped.support.made_once import made_once
from lumped.support.optional_packages import extra
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, table
from lumped.support.whole_files import whole_file
from lumped.timeloop.results.event import Event
from lumped.timeloop.results.file_formats import READERS, WRITERS, Contents, apart

_SHOWN = 12
"""Quantities of a printed file."""


@dataclass(frozen=True, eq=False)
class Saved(Contents, ByName, RichHtml):
    """Quantities of a run, apart from its model; ``saved[name]`` gives one of them over `t`.

    Attributes
    ----------
    t : ndarray, shape (k,)
        Times, s.
    values : dict of str to ndarray, shape (k,)
        Quantities.
    units, texts : dict of str to str
        Their units, SI unless the file was written with others, and what they are.
    parameters : dict of str to float
        Parameters of the run.
    parameter_units : dict of str to str
        Their units.
    model : str
        Name of the model.
    fingerprint : str
        Hash of the model but for the values of its parameters.
    states : tuple of str
        Those of the quantities that are states, which `plot` draws unless others are named.
    events : tuple of Event
        Jumps of functions of time, changes of modes, impacts, and changes of states.
    """

    def __getitem__(self, name: Name | list[Name]) -> Real:
        if isinstance(name, list):
            return np.column_stack([self[one] for one in name])
        key = key_of(name)
        if key == "time":
            return self.t
        if key not in self.values:
            raise UnknownNameError(f"'{key}' was not saved. {nearest(key, self.values)}")
        return self.values[key]

    def __contains__(self, name: Name) -> bool:
        return key_of(name) in ("time", *self.values)

    def _names(self) -> list[str]:
        return [*self.values]

    def _ipython_key_completions_(self) -> list[str]:
        return ["time", *self.values]

    @property
    def main(self) -> list[str]:
        """What is shown unless others are named: the states, or all if none are known."""
        return [*(self.states or self.values)]

    def in_units(self, units: Units) -> Saved:
        """The same in other units; times stay in s.

        Parameters
        ----------
        units : mapping of str to str, str or None
            See `lumped.display_units`; None is what the session shows.

        Raises
        ------
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        choice = choose_units(units, self)
        found = {name: display(name, unit, choice) for name, unit in self.units.items()}
        values = {name: found[name].value(y) for name, y in self.values.items()}
        return replace(self, values=values, units={name: to.unit for name, to in found.items()})

    @checked
    def plot(
        self,
        names: Iterable[Name] | None = None,
        *,
        units: Units = None,
        **canvas: Unpack[Canvas],
    ) -> Any:
        """Curves over time (see `lumped.Trajectory.plot`).

        Default is the states; of a file that does not tell them, such as a csv, all quantities.
        """
        wanted = self.main if names is None else [*map(key_of, names)]
        found = {name: self[name] for name in wanted}
        own, texts = {"time": "s", **self.units}, {"time": "time", **self.texts}
        shown = {name: (own[name], texts[name], y) for name, y in found.items()}
        choice = choose_units(units, ("time", *self))
        picture = draw_curves(self.model, self.t, shown, self.events, choice, names is not None)
        return draw(picture, **canvas)

    def to_pandas(self, *, units: Units = None) -> Any:
        """A DataFrame over the time, one column for each quantity; units in ``frame.attrs``.

        Its index increases strictly: where values jump, those before the jump are one step of
        rounding earlier, and ``frame.loc[t]`` gives those after it.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units of the values, see `in_units`; times stay in s.

        Raises
        ------
        OptionError
            If pandas is not installed.
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        pandas = extra("pandas", "data", "to_pandas")
        shown = self.in_units(units)
        frame = pandas.DataFrame(shown.values, index=pandas.Index(apart(self.t), name="time"))
        frame.attrs = {"model": self.model, "fingerprint": self.fingerprint, "units": shown.units}
        return frame

    def to_xarray(self, *, units: Units = None) -> Any:
        """A Dataset over the time, with units and texts as attributes.

        Times are as in `to_pandas`, so that it can be indexed and interpolated.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units of the values, see `in_units`; times stay in s.

        Raises
        ------
        OptionError
            If xarray is not installed.
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        xarray = extra("xarray", "data", "to_xarray")
        shown = self.in_units(units)
        columns = {
            name: ("time", values, {"units": shown.units[name], "long_name": self.texts[name]})
            for name, values in shown.values.items()
        }
        time = ("time", apart(self.t), {"units": "s", "long_name": "time"})
        about = {"model": self.model, "fingerprint": self.fingerprint}
        return xarray.Dataset(columns, coords={"time": time}, attrs=about)

    @checked
    def write(self, path: str | Path, *, units: Units = None) -> Path:
        """Write a file; its ending says what: .nc, .npz, .csv or .mat.

        Times and values are stored in full. ``.nc`` is NetCDF 3; ``.mat`` is the result file that
        Modelica tools read; ``.csv`` has units behind the names and neither parameters nor events.
        Times in ``.nc`` and ``.csv`` are those of `to_pandas`; `lumped.load` undoes that. The file
        is written whole or not at all.

        Parameters
        ----------
        path : str or Path
            The file.
        units : mapping of str to str or str, optional
            Units of the values, see `in_units`; default is to leave them. Times stay in s.

        Raises
        ------
        OptionError
            If the ending is none of these.
        OSError
            If it cannot be written.
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        path = Path(path)
        if path.suffix not in WRITERS:
            raise OptionError(f"{path.name}: the ending must be one of {', '.join(WRITERS)}.")
        shown = self if units is None else self.in_units(units)
        with whole_file(path) as file:
            WRITERS[path.suffix](shown, file)
        return path

    def __repr__(self) -> str:
        over = f", {self.t[0]:g} to {self.t[-1]:g} s" if len(self.t) else ""
        head = (
            f"{self.model or 'run'} from a file: {len(self.values)} quantities at {len(self.t)} "
            f"points{over}; {len(self.events)} events"
        )
        rows = []
        for name in self.main[:_SHOWN] if len(self.t) else ():
            y = self.values[name]
            rows.append((name, *amounts(name, self.units[name], y[0], y[-1], y.min(), y.max())))
        return head + "\n" + table(("quantity", "start", "end", "min", "max", "unit"), rows)


def draw_curves(
    title: str,
    t: Real,
    quantities: Mapping[str, tuple[str, str, Real]],
    events: Sequence[Event],
    units: Units,
    all_of_them: bool,
) -> Picture:
    """Curves of SI units, texts and values over time (see `lumped.plots.over_time`)."""
    if not len(t):
        raise OptionError(f"{title}: nothing was computed, so there is nothing to draw.")
    if not quantities:
        raise OptionError(f"{title}: no states to draw; name the quantities to see.")
    time, shown = time_unit(units), {}
    for name, (unit, text, values) in quantities.items():
        to_show = display(name, unit, units)
        shown[name] = to_show.unit, text, to_show.value(values)
    happened = [(time.value(event.time), *_describe_event(event)) for event in events]
    axis = time.value(t), time.unit
    return draw_over_time(title, axis, shown, happened, all_of_them=all_of_them)


def _describe_event(event: Event) -> tuple[str, str]:
    """What happened, and of what sort it is."""
    sort = "impacts" if event.loss else "changes of mode"
    if event.kind == "time":
        sort = "functions of time"
    return f"{event.component}: {event.before} to {event.after}", sort


def state_names(system: System) -> list[str]:
    """Names of the states that are quantities of components, not derivatives of such."""
    return [name for name in system.state_names if not name.startswith("der(")]


@made_once
def list_computable(system: System) -> list[str]:
    """Quantities that do not need a state that was left out."""
    tree = system.structure.tree
    names = system.names()
    nodes = [system.structure.reduced.node(tree.unknown(name)) for name in names]
    known = [node for node in nodes if node is not None]
    usable = dict(zip(known, system.structure.available(known, cyclic=True).tolist(), strict=True))
    return [n for n, node in zip(names, nodes, strict=True) if node is None or usable[node]]


@checked
def load(path: str | Path) -> Saved:
    """Read what `Trajectory.save` wrote as .nc, .npz or .csv.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Saved

    Raises
    ------
    OptionError
        If the ending is another, or the file is damaged or was not written by lumped.
    OSError
        If there is no such file.
    """
    path = Path(path)
    if path.suffix not in READERS:
        raise OptionError(f"{path.name}: the ending must be one of {', '.join(READERS)}.")
    held = path.read_bytes()
    try:
        return Saved(**READERS[path.suffix](held))
    except Exception as fault:  # readers fail in many ways on bytes that are not theirs
        raise OptionError(
            f"{path}: this is no result that lumped wrote, or it is damaged ({fault})."
        ) from None
