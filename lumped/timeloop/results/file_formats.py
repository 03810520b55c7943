"""Saved quantities as bytes of NetCDF, npz, csv and Modelica's result files, and back."""

from __future__ import annotations

import csv
import hashlib
import io
import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, BinaryIO

import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.errors import OptionError
from lumped.support.arrays import Real
from lumped.timeloop.results.event import Event

Read = dict[str, Any]
"""Contents by name."""


@dataclass(frozen=True, eq=False)
class Contents:
    """What a file of results holds (see `Saved`)."""

    t: Real
    values: dict[str, Real]
    units: dict[str, str]
    texts: dict[str, str]
    parameters: dict[str, float] = field(default_factory=dict)
    parameter_units: dict[str, str] = field(default_factory=dict)
    model: str = ""
    fingerprint: str = ""
    states: tuple[str, ...] = ()
    events: tuple[Event, ...] = ()


def apart(t: Real) -> Real:
    """Times that increase strictly: those before a jump are moved back by one step of rounding."""
    t = t.copy()
    while len(same := np.flatnonzero(np.diff(t) <= 0)):
        t[same] = np.nextafter(t[same + 1], -np.inf)
    return t


def together(t: Real) -> Real:
    """Times before a jump moved back to it."""
    t = t.copy()
    for i in np.flatnonzero(np.nextafter(t[1:], -np.inf) == t[:-1])[::-1].tolist():
        t[i] = t[i + 1]
    return t


def _netcdf(data: Contents, file: BinaryIO) -> None:
    """NetCDF 3 with 64 bit offsets."""
    held = io.BytesIO()
    out = scipy.io.netcdf_file(held, "w", version=2)
    out.createDimension("time", len(data.t))
    for name, values in (("time", apart(data.t)), *data.values.items()):
        column = out.createVariable(_letters(name), "d", ("time",))
        column[:] = values
        column.units = data.units.get(name, "s").encode()
        column.long_name = data.texts.get(name, "time").encode()
    for name, value in data.parameters.items():
        scalar = out.createVariable(_letters(f"parameter {name}"), "d", ())
        scalar.data[...] = value
        scalar.units = data.parameter_units[name].encode()
    out.model, out.fingerprint = data.model.encode(), data.fingerprint.encode()
    out.states = json.dumps(data.states).encode()
    out.events = json.dumps(_rows(data.events)).encode()
    out.checksum = _checksum(vars(data)).encode()
    out.flush()  # to close it would close what it was written to
    file.write(held.getvalue())


def _letters(name: str) -> str:
    """A name for SciPy, which writes one byte for each letter; the format has UTF-8."""
    return name.encode().decode("latin1")


def _from_netcdf(held: bytes) -> Read:
    with scipy.io.netcdf_file(io.BytesIO(held), "r", mmap=False) as file:
        variables = {n.encode("latin1").decode(): v for n, v in file.variables.items()}
        columns = {n: v for n, v in variables.items() if v.dimensions == ("time",)}
        scalars = {n[10:]: v for n, v in variables.items() if n.startswith("parameter ")}
        time = columns.pop("time")
        found = {
            "t": together(time.data.astype(float)),
            "values": {n: v.data.astype(float) for n, v in columns.items()},
            "units": {n: v.units.decode() for n, v in columns.items()},
            "texts": {n: v.long_name.decode() for n, v in columns.items()},
            "parameters": {n: float(v.data) for n, v in scalars.items()},
            "parameter_units": {n: v.units.decode() for n, v in scalars.items()},
            "model": file.model.decode(),
            "fingerprint": file.fingerprint.decode(),
            "states": tuple(json.loads(file.states)),
            "events": _events(json.loads(file.events)),
        }
        if file.checksum.decode() != _checksum(found):
            raise ValueError("what it holds is not what was written")
        return found


def _checksum(what: Read) -> str:
    """Hash of all that a file holds; times beside a jump may be moved by one step of rounding."""
    numbers = {"": together(apart(what["t"])), **what["values"]}
    texts = [sorted(v.items()) for n, v in what.items() if isinstance(v, dict) and n != "values"]
    rest = [what["model"], what["fingerprint"], what["states"], _rows(what["events"])]
    found = hashlib.sha256(json.dumps([*texts, *rest]).encode())
    for name in sorted(numbers):
        found.update(name.encode() + numbers[name].astype(float).tobytes())
    return found.hexdigest()


def _npz(data: Contents, file: BinaryIO) -> None:
    parameters, names = data.parameters, list(data.values)
    np.savez_compressed(
        file,
        t=data.t,
        names=_strings(names),
        values=np.array([*data.values.values()]).reshape(len(names), len(data.t)),
        units=_strings(data.units[n] for n in names),
        texts=_strings(data.texts[n] for n in names),
        parameter_names=_strings(parameters),
        parameters=np.array(list(parameters.values()), dtype=float),
        parameter_units=_strings(data.parameter_units[n] for n in parameters),
        about=_strings([data.model, data.fingerprint]),
        states=_strings(data.states),
        events=_strings([json.dumps(_rows(data.events))]),
    )


def _strings(texts: Iterable[str]) -> NDArray[np.str_]:
    return np.array(list(texts), dtype=str)


def _from_npz(held: bytes) -> Read:
    with np.load(io.BytesIO(held)) as file:
        names, given = file["names"].tolist(), file["parameter_names"].tolist()
        model, fingerprint = file["about"].tolist()
        (events,) = file["events"].tolist()
        return {
            "t": file["t"],
            "values": dict(zip(names, file["values"], strict=True)),
            "units": dict(zip(names, file["units"].tolist(), strict=True)),
            "texts": dict(zip(names, file["texts"].tolist(), strict=True)),
            "parameters": dict(zip(given, file["parameters"].tolist(), strict=True)),
            "parameter_units": dict(zip(given, file["parameter_units"].tolist(), strict=True)),
            "model": model,
            "fingerprint": fingerprint,
            "states": tuple(file["states"].tolist()),
            "events": _events(json.loads(events)),
        }


def _rows(events: Iterable[Event]) -> list[list[float | str]]:
    return [[*event] for event in events]


def _events(rows: list[list[Any]]) -> tuple[Event, ...]:
    return tuple(Event(*row) for row in rows)


def _csv(data: Contents, file: BinaryIO) -> None:
    """One line of names with units, and an empty line at the end, which says that it is whole."""
    text = io.TextIOWrapper(file, encoding="utf-8", newline="")
    rows = csv.writer(text)
    rows.writerow(f"{name} [{data.units.get(name, 's')}]" for name in ("time", *data.values))
    table = np.column_stack([apart(data.t), *data.values.values()])
    rows.writerows([repr(v) for v in row] for row in table.tolist())
    rows.writerow([])
    text.detach()


def _from_csv(held: bytes) -> Read:
    if not held.endswith(b"\n\r\n"):
        raise ValueError("the empty line at its end is missing, so it may be cut off")
    heads, *rows = csv.reader(io.StringIO(held.decode(), newline=""))
    if heads[0] != "time [s]" or not all(head.endswith("]") for head in heads):
        raise ValueError("the first line does not tell the time in s, and quantities with units")
    names = [head.rpartition(" [")[0] for head in heads]
    if len(set(names)) < len(names):
        raise ValueError("a name stands there twice")
    table = np.array(rows[:-1], dtype=float).reshape(len(rows) - 1, len(names))
    columns = dict(zip(names, table.T, strict=True))
    t = together(columns.pop("time"))
    return {
        "t": t,
        "values": columns,
        "units": {h.rpartition(" [")[0]: h.rpartition(" [")[2][:-1] for h in heads[1:]},
        "texts": dict.fromkeys(columns, ""),
    }


def _modelica(data: Contents, file: BinaryIO) -> None:
    """Result file of Dymola, version 1.1: parameters in data_1, trajectories in data_2."""
    t = data.t
    ends = [t[0], t[-1]] if len(t) else [0.0, 0.0]
    names = ["time", *data.values, *data.parameters]
    for name in names:
        if name.encode("latin1", "replace").decode("latin1") != name:
            raise OptionError(f"{name}: a .mat file has no such letters; use .nc, .npz or .csv.")
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
        file,
        {
            "Aclass": np.array(["Atrajectory", "1.1", "", "binTrans"]),
            "name": _transpose(names),
            "description": _transpose(texts),
            "dataInfo": info,
            "data_1": fixed,
            "data_2": np.array([t, *data.values.values()]),
        },
        format="4",
    )


def _transpose(lines: list[str]) -> NDArray[np.str_]:
    """The columns of a matrix of characters that has one line in each row."""
    width = max(len(line) for line in lines)
    lines = [line.encode("latin1", "replace").decode("latin1") for line in lines]
    padded = [line.ljust(width) for line in lines]
    return np.array(["".join(column) for column in zip(*padded, strict=True)])


WRITERS = {".nc": _netcdf, ".npz": _npz, ".csv": _csv, ".mat": _modelica}
READERS = {".nc": _from_netcdf, ".npz": _from_npz, ".csv": _from_csv}
