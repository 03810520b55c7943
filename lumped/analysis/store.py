"""Results in files and in the tables of other libraries."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.analysis.fingerprint import fingerprint
from lumped.errors import OptionError, UnknownNameError, nearest
from lumped.system import Name, System

if TYPE_CHECKING:
    from lumped.analysis.result import Trajectory

__all__ = ["Saved", "fingerprint", "load", "saved"]


@dataclass(frozen=True, eq=False)
class Saved:
    """Quantities of a run, apart from its model; ``saved[name]`` gives one of them over `t`.

    Attributes
    ----------
    t : ndarray, shape (k,)
        Times, s.
    values : dict of str to ndarray, shape (k,)
        Quantities.
    units, texts : dict of str to str
        Their units and what they are.
    parameters : dict of str to float
        Parameters of the run.
    parameter_units : dict of str to str
        Their units.
    model : str
        Name of the model.
    fingerprint : str
        Hash of its equations (see `fingerprint`).
    """

    t: NDArray[np.float64]
    values: dict[str, NDArray[np.float64]]
    units: dict[str, str]
    texts: dict[str, str]
    parameters: dict[str, float]
    parameter_units: dict[str, str]
    model: str
    fingerprint: str

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name == "time":
            return self.t
        if name not in self.values:
            raise UnknownNameError(f"'{name}' was not saved. {nearest(name, self.values)}")
        return self.values[name]

    def to_pandas(self) -> Any:
        """A DataFrame over the time, one column for each quantity; units in ``frame.attrs``."""
        import pandas

        frame = pandas.DataFrame(self.values, index=pandas.Index(self.t, name="time"))
        frame.attrs = {"model": self.model, "fingerprint": self.fingerprint, "units": self.units}
        return frame

    def to_xarray(self) -> Any:
        """A Dataset over the time, with units and texts as attributes."""
        import xarray

        columns = {
            name: ("time", values, {"units": self.units[name], "long_name": self.texts[name]})
            for name, values in self.values.items()
        }
        time = ("time", self.t, {"units": "s", "long_name": "time"})
        about = {"model": self.model, "fingerprint": self.fingerprint}
        return xarray.Dataset(columns, coords={"time": time}, attrs=about)

    def write(self, path: str | Path) -> Path:
        """Write a file; its ending says what: .nc, .npz, .csv or .mat.

        Times and values are stored in full. ``.nc`` is NetCDF 3; ``.mat`` is the result file that
        Modelica tools read; ``.csv`` has the units in its second line and no parameters.

        Raises
        ------
        OptionError
            If the ending is none of these.
        """
        path = Path(path)
        writers = {".nc": _netcdf, ".npz": _npz, ".csv": _csv, ".mat": _modelica}
        if path.suffix not in writers:
            raise OptionError(f"{path.name}: the ending must be one of {', '.join(writers)}.")
        writers[path.suffix](self, path)
        return path


def saved(run: Trajectory, names: Iterable[Name] | None = None) -> Saved:
    """Quantities of a run by themselves; default is every state and what the model still has.

    Parameters
    ----------
    run : Trajectory
        From `lumped.simulate`.
    names : iterable of names, optional
        Quantities; default is all that the system computes.
    """
    system = run.system
    chosen = _computed(system) if names is None else [system.key(name) for name in names]
    quantities = {name: system.quantity(name) for name in chosen}
    p = system._flat.parameters
    given = {p.names[i]: float(v) for i, v in zip(p.free, run.theta, strict=True)}
    return Saved(
        run.t,
        {name: run[name] for name in chosen},
        {name: quantity.unit for name, quantity in quantities.items()},
        {name: quantity.text for name, quantity in quantities.items()},
        given,
        {p.names[i]: p.declared[i].unit for i in p.free},
        system.name,
        fingerprint(system),
    )


def _computed(system: System) -> list[str]:
    """Quantities that do not need a state that was left out."""
    tree = system._tree
    names = system.names()
    nodes = [system._reduced.node(tree.unknown(name)) for name in names]
    known = [node for node in nodes if node is not None]
    usable = dict(zip(known, system.available(known, cyclic=True).tolist(), strict=True))
    return [n for n, node in zip(names, nodes, strict=True) if node is None or usable[node]]


def load(path: str | Path) -> Saved:
    """Read what `Trajectory.save` wrote as .nc, .npz or .csv.

    Raises
    ------
    OptionError
        If the ending is another, or the file was not written by lumped.
    """
    path = Path(path)
    readers = {".nc": _from_netcdf, ".npz": _from_npz, ".csv": _from_csv}
    if path.suffix not in readers:
        raise OptionError(f"{path.name}: the ending must be one of {', '.join(readers)}.")
    try:
        return readers[path.suffix](path)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as fault:
        raise OptionError(f"{path}: this is no result that lumped wrote ({fault}).") from None


def _netcdf(data: Saved, path: Path) -> None:
    with scipy.io.netcdf_file(path, "w", version=2) as file:
        file.createDimension("time", len(data.t))
        for name, values in (("time", data.t), *data.values.items()):
            column = file.createVariable(name, "d", ("time",))
            column[:] = values
            column.units = data.units.get(name, "s")
            column.long_name = data.texts.get(name, "time")
        for name, value in data.parameters.items():
            scalar = file.createVariable(f"parameter {name}", "d", ())
            scalar.data[...] = value
            scalar.units = data.parameter_units[name]
        file.model, file.fingerprint = data.model, data.fingerprint


def _from_netcdf(path: Path) -> Saved:
    with scipy.io.netcdf_file(path, "r", mmap=False) as file:
        columns = {n: v for n, v in file.variables.items() if v.dimensions == ("time",)}
        scalars = {n[10:]: v for n, v in file.variables.items() if n.startswith("parameter ")}
        time = columns.pop("time")
        return Saved(
            time.data.astype(float),
            {n: v.data.astype(float) for n, v in columns.items()},
            {n: v.units.decode() for n, v in columns.items()},
            {n: v.long_name.decode() for n, v in columns.items()},
            {n: float(v.data) for n, v in scalars.items()},
            {n: v.units.decode() for n, v in scalars.items()},
            file.model.decode(),
            file.fingerprint.decode(),
        )


def _npz(data: Saved, path: Path) -> None:
    parameters = data.parameters
    np.savez_compressed(
        path,
        t=data.t,
        names=np.array(list(data.values), dtype=str),
        values=np.array([*data.values.values()]).reshape(-1, len(data.t)),
        units=np.array([data.units[n] for n in data.values], dtype=str),
        texts=np.array([data.texts[n] for n in data.values], dtype=str),
        parameter_names=np.array(list(parameters), dtype=str),
        parameters=np.array(list(parameters.values()), dtype=float),
        parameter_units=np.array([data.parameter_units[n] for n in parameters], dtype=str),
        about=np.array([data.model, data.fingerprint]),
    )


def _from_npz(path: Path) -> Saved:
    with np.load(path) as file:
        names, given = file["names"].tolist(), file["parameter_names"].tolist()
        return Saved(
            file["t"],
            dict(zip(names, file["values"], strict=True)),
            dict(zip(names, file["units"].tolist(), strict=True)),
            dict(zip(names, file["texts"].tolist(), strict=True)),
            dict(zip(given, file["parameters"].tolist(), strict=True)),
            dict(zip(given, file["parameter_units"].tolist(), strict=True)),
            *file["about"].tolist(),
        )


def _csv(data: Saved, path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["time", *data.values])
        rows.writerow(["s", *(data.units[n] for n in data.values)])
        table = np.column_stack([data.t, *data.values.values()])
        rows.writerows([repr(v) for v in row] for row in table.tolist())


def _from_csv(path: Path) -> Saved:
    with path.open(newline="", encoding="utf-8") as file:
        names, units, *rows = csv.reader(file)
    if (names[0], units[0]) != ("time", "s"):
        raise ValueError("the first column is not the time in s")
    table = np.array(rows, dtype=float).reshape(len(rows), len(names))
    inner = names[1:]
    return Saved(
        table[:, 0],
        dict(zip(inner, table[:, 1:].T, strict=True)),
        dict(zip(inner, units[1:], strict=True)),
        dict.fromkeys(inner, ""),
        {},
        {},
        "",
        "",
    )


def _modelica(data: Saved, path: Path) -> None:
    """Result file of Dymola, version 1.1: parameters in data_1, trajectories in data_2."""
    t = data.t
    ends = [t[0], t[-1]] if len(t) else [0.0, 0.0]
    names = ["time", *data.values, *data.parameters]
    texts = ["time [s]"]
    texts += [f"{data.texts[n]} [{data.units[n]}]" for n in data.values]
    texts += [f"[{data.parameter_units[n]}]" for n in data.parameters]
    info = np.zeros((4, len(names)), dtype=np.int32)
    columns = len(data.values)
    info[0, 1:], info[3] = 2, -1
    info[0, 1 + columns :] = 1
    info[1] = [1, *range(2, columns + 2), *range(2, len(data.parameters) + 2)]
    info[2, 1 + columns :] = 0
    fixed = np.array([ends, *([v, v] for v in data.parameters.values())])
    scipy.io.savemat(
        path,
        {
            "Aclass": np.array(["Atrajectory", "1.1", "", "binTrans"]),
            "name": _transposed(names),
            "description": _transposed(texts),
            "dataInfo": info,
            "data_1": fixed,
            "data_2": np.array([t, *data.values.values()]),
        },
        format="4",
    )


def _transposed(lines: list[str]) -> NDArray[np.str_]:
    """The columns of a matrix of characters that has one line in each row."""
    width = max(len(line) for line in lines)
    padded = [line.ljust(width) for line in lines]
    return np.array(["".join(column) for column in zip(*padded, strict=True)])
