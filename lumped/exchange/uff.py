"""Universal files (UFF): measured and computed curves and mode shapes.

Source: Universal File Formats for Modal Analysis Testing, University of Cincinnati, SDRL: data sets
55 (data at nodes), 58 (function at nodal degree of freedom) and 2414 (analysis data).
"""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.exchange.uff_shapes import (
    UffShape,
    analysis_data,
    is_shape,
    shape_of_55,
    shape_of_2414,
    shapes_as_55,
)
from lumped.support.arguments import checked
from lumped.support.optional_packages import extra
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.support.whole_files import whole_file
from lumped.timeloop.results.trajectory import Trajectory
from lumped.vibration.natural.modes import Modes
from lumped.vibration.responses.response import FrequencyResponse

_KINDS = {1: "time", 4: "frequency response"}
_TURNS, _SLIDES = 4, 1
_DIRECTIONS = {
    **dict.fromkeys(("rad", "rad/s", "rad/s2", "N.m"), _TURNS),
    **dict.fromkeys(("m", "m/s", "m/s2", "N"), _SLIDES),
}
"""Rotation about x and translation along x; anything else is a scalar, 0."""
_TYPES = {
    **dict.fromkeys(("rad", "m"), 8),
    **dict.fromkeys(("rad/s", "m/s"), 11),
    **dict.fromkeys(("rad/s2", "m/s2"), 12),
    **dict.fromkeys(("N.m", "N"), 13),
}
"""Displacement, velocity, acceleration, excitation; anything else is unknown, 0."""
_TIME, _FREQUENCY = 17, 18
_LONGEST = 80
"""Letters of an identification line."""


@dataclass(frozen=True, eq=False)
class UffCurve:
    """A curve of a universal file (data set 58).

    Attributes
    ----------
    kind : {"time", "frequency response"}
        What it is over.
    x : ndarray, shape (k,)
        Time, s, or frequency, Hz.
    y : ndarray, shape (k,)
        Values, complex for a frequency response, in `unit`.
    name, reference : str
        First two identification lines; those that `write_uff` writes are output and input.
    node, direction : int
        Where, and 1 to 3 for translation along x, y, z, 4 to 6 for rotation, 0 for a scalar.
    reference_node, reference_direction : int
        The same of the input.
    unit : str
        As the file has it.
    """

    kind: str
    x: np.ndarray
    y: np.ndarray
    name: str
    reference: str
    node: int
    direction: int
    reference_node: int
    reference_direction: int
    unit: str


@dataclass(frozen=True, eq=False)
class UffFile(RichHtml):
    """What a universal file holds.

    Attributes
    ----------
    curves : tuple of UffCurve
        Runs and frequency responses.
    shapes : tuple of UffShape
        Mode shapes.
    left_out : tuple of int
        Numbers of the other data sets, such as 15 for coordinates, and 58 for other functions.
    """

    curves: tuple[UffCurve, ...]
    shapes: tuple[UffShape, ...]
    left_out: tuple[int, ...]

    def __repr__(self) -> str:
        rows = [
            (c.kind, c.name, c.reference, f"{len(c.x)}", f"{number(c.x[0])} .. {number(c.x[-1])}")
            for c in self.curves
        ]
        rows += [
            ("shape", f"{len(s.nodes)} nodes", "", "", f"{number(s.hertz)} Hz") for s in self.shapes
        ]
        others = f", {len(self.left_out)} other data sets" if self.left_out else ""
        head = f"{len(self.curves)} curves, {len(self.shapes)} mode shapes{others}"
        return f"{head}\n" + table(("kind", "name", "reference", "points", "from, to"), rows)


@checked
def read_uff(path: str | Path) -> UffFile:
    """Read curves and mode shapes of a universal file, as text or binary.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    UffFile

    Raises
    ------
    OptionError
        If there is no such file, it cannot be read, or pyuff is missing.
    """
    pyuff = extra("pyuff", "uff", "read_uff")
    if not Path(path).is_file():
        raise OptionError(f"read_uff: there is no file {path}.")
    try:
        found = pyuff.UFF(str(path))
        known = [int(kind) for kind in found.get_set_types()]
        places = [i for i, kind in enumerate(known) if kind in (55, 58, 2414)]
        sets = found.read_sets(places) if places else []
    except Exception as fault:  # pyuff raises nothing narrower
        raise OptionError(f"read_uff: {path} is no universal file: {fault}.") from None
    if not known:
        raise OptionError(f"read_uff: {path} is no universal file: it has no data set.")
    sets = sets if isinstance(sets, list) else [sets]
    curves = [_curve(s) for s in sets if s["type"] == 58 and s["func_type"] in _KINDS]
    old = [shape_of_55(s) for s in sets if s["type"] == 55 and s["analysis_type"] in (2, 3)]
    new = [shape_of_2414(s) for s in sets if s["type"] == 2414 and is_shape(s)]
    rest = [kind for kind in known if kind not in (55, 58, 2414)]
    for kind, taken in ((58, curves), (55, old), (2414, new)):
        rest += [kind] * (known.count(kind) - len(taken))
    return UffFile(tuple(curves), (*old, *new), tuple(sorted(rest)))


def _curve(found: Mapping[str, Any]) -> UffCurve:
    return UffCurve(
        _KINDS[found["func_type"]],
        found["x"],
        found["data"],
        found["id1"].strip(),
        found["id2"].strip(),
        int(found["rsp_node"]),
        int(found["rsp_dir"]),
        int(found["ref_node"]),
        int(found["ref_dir"]),
        found["ordinate_axis_units_lab"].strip(),
    )


@checked
def write_uff(
    path: str | Path,
    result: Trajectory | FrequencyResponse | Modes,
    *,
    nodes: Mapping[str, int] | Mapping[Name, int],
    shapes: Literal[55, 2414] = 55,
) -> Path:
    """Write a run, a frequency response or mode shapes as a universal file.

    Curves are binary, so nothing is rounded; shapes are text of six digits. Turning is rotation
    about x, sliding translation along x; a shape has its amplitudes in the column of x.

    Parameters
    ----------
    path : str or Path
        The file; one of this name is replaced.
    result : Trajectory, FrequencyResponse or Modes
        From `simulate`, `frequency_response` or `modes`.
    nodes : mapping of name to int
        Number of the node of each quantity to write: of the outputs and inputs of a response.
    shapes : {55, 2414}
        Data set for mode shapes: data at nodes, or analysis data, which newer programs take.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    OptionError
        If nothing is named, a number is not positive, a name is longer than 80 letters, an output
        or input of a response has no node, or pyuff is missing.
    OSError
        If the file cannot be written.
    UnknownNameError
        If a name does not exist.
    """
    pyuff = extra("pyuff", "uff", "write_uff")
    system = result.system
    places = {system.key(name): int(node) for name, node in nodes.items()}
    for name, node in places.items():
        if node < 1 or len(name) > _LONGEST:
            raise OptionError(
                f"write_uff: {name} at node {node}: node numbers begin at 1, and names have at "
                f"most {_LONGEST} letters."
            )
    if isinstance(result, Modes) and places and shapes == 2414:
        with whole_file(path) as file:
            file.write(analysis_data(result, places).encode())
        return Path(path)
    if isinstance(result, Trajectory):
        sets = list(_runs(result, places))
    elif isinstance(result, FrequencyResponse):
        sets = list(_responses(result, places))
    else:
        sets = list(shapes_as_55(result, places))
    if not sets:
        raise OptionError(f"write_uff: {system.name} has nothing to write; name quantities.")
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # pyuff leaves binary files open
        made = Path(folder) / "made.uff"
        pyuff.UFF(str(made)).write_sets(sets, mode="add")  # overwriting, it loses binary headers
        content = made.read_bytes()
    with whole_file(path) as file:
        file.write(content)
    return Path(path)


def _runs(run: Trajectory, places: Mapping[str, int]) -> Iterator[dict[str, Any]]:
    for name, node in places.items():
        unit = run.system.quantity(name).unit
        yield _function(1, run.t, run[name], (name, node, unit), ("NONE", 0, "1"))


def _responses(found: FrequencyResponse, places: Mapping[str, int]) -> Iterator[dict[str, Any]]:
    system = found.system
    for name in (*found.outputs, *found.inputs):
        if name not in places:
            raise OptionError(f"write_uff: {name} has no node; name it in `nodes`.")
    for output in found.outputs:
        for given in found.inputs:
            ends = [(n, places[n], system.quantity(n).unit) for n in (output, given)]
            yield _function(4, found.hertz, found[output, given], *ends)


def _function(
    kind: int,
    x: np.ndarray,
    y: np.ndarray,
    output: tuple[str, int, str],
    given: tuple[str, int, str],
) -> dict[str, Any]:
    """Data set 58, in double precision, with all its abscissae."""
    if len(x) < 2:
        raise OptionError(f"write_uff: {output[0]} has {len(x)} value; two are needed.")
    over = ("time", "s", _TIME) if kind == 1 else ("frequency", "Hz", _FREQUENCY)
    return {
        "type": 58,
        "binary": 1,
        "func_type": kind,
        "id1": output[0],
        "id2": given[0],
        "rsp_node": output[1],
        "rsp_dir": _DIRECTIONS.get(output[2], 0),
        "ref_node": given[1],
        "ref_dir": _DIRECTIONS.get(given[2], 0),
        "x": x,
        "data": y,
        "abscissa_axis_lab": over[0],
        "abscissa_axis_units_lab": over[1],
        "abscissa_spec_data_type": over[2],
        "ordinate_spec_data_type": _TYPES.get(output[2], 0),
        "ordinate_axis_units_lab": output[2],
        "orddenom_spec_data_type": _TYPES.get(given[2], 0),
        "orddenom_axis_units_lab": given[2],
    }
