"""Mode shapes of universal files: data sets 55 and 2414, read and written.

Source: Universal File Formats for Modal Analysis Testing, University of Cincinnati, SDRL.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lumped.vibration.natural.modes import Modes

_COMPLEX = (5, 6)
_IN_LINE = 6
"""Numbers of a line of analysis data."""


@dataclass(frozen=True, eq=False)
class UffShape:
    """A mode shape of a universal file (data set 55 or 2414).

    Attributes
    ----------
    hertz, damping : float
        Natural frequency, Hz, and damping ratio.
    nodes : tuple of int
        Where.
    values : ndarray, shape (nodes, 1, 3 or 6)
        Amplitudes: translation along x, y, z, and where the file has them rotation about them. A
        torsional shape of `write_uff` has its angles in the first column.
    """

    hertz: float
    damping: float
    nodes: tuple[int, ...]
    values: np.ndarray


def shape_of_55(found: Mapping[str, Any]) -> UffShape:
    """Data at nodes, as pyuff has read them."""
    if found["analysis_type"] == 2:
        hertz, damping = float(found["freq"]), float(found["modal_damp_vis"])
    else:
        hertz, damping = _of_eigenvalue(found["eig"])
    columns = [found[f"r{i}"] for i in range(1, 7) if f"r{i}" in found]
    nodes = tuple(int(n) for n in found["node_nums"])
    return UffShape(float(hertz), float(damping), nodes, np.column_stack(columns))


def is_shape(found: Mapping[str, Any]) -> bool:
    """Whether analysis data are modes at nodes, in lines that pyuff reads."""
    numbers = found["number_of_data_values_for_the_data_component"]
    size = numbers * (2 if found["data_type"] in _COMPLEX else 1)
    return (
        found["analysis_type"] in (2, 3, 7) and found["dataset_location"] == 1 and size <= _IN_LINE
    )


def shape_of_2414(found: Mapping[str, Any]) -> UffShape:
    """Analysis data that are a shape, as pyuff has read them."""
    if found["analysis_type"] == 2:
        hertz, damping = found["record12_field2"], found["record12_field5"]
    else:
        eigenvalue = complex(found["record13_field1"], found["record13_field2"])
        hertz, damping = _of_eigenvalue(eigenvalue)
    values = np.array(found["data_at_node"])
    if found["data_type"] in _COMPLEX:
        values = values[:, ::2] + 1j * values[:, 1::2]
    nodes = tuple(int(n) for n in found["node_nums"])
    return UffShape(float(hertz), float(damping), nodes, values)


def _of_eigenvalue(value: complex) -> tuple[float, float]:
    """Natural frequency, Hz, and damping ratio."""
    size = abs(value)
    return size / (2 * np.pi), -value.real / size if size else 0.0


def shapes_as_55(found: Modes, places: Mapping[str, int]) -> Iterator[dict[str, Any]]:
    """Data sets 55: normal modes, or complex ones of a damped system."""
    if not places:
        return
    values = np.array([found.shape(name) for name in places])
    zero = np.zeros_like(values[:, 0]) if values.size else values
    for i, hertz in enumerate(found.hertz):
        yield {
            "type": 55,
            "analysis_type": 3 if np.iscomplexobj(values) else 2,
            "data_ch": 2,
            "spec_data_type": 8,
            "load_case": 1,
            "mode_n": i + 1,
            "freq": hertz,
            "modal_damp_vis": found.damping[i],
            "eig": found.eigenvalues[i],
            "node_nums": list(places.values()),
            "r1": values[:, i],
            "r2": zero,
            "r3": zero,
        }


def analysis_data(found: Modes, places: Mapping[str, int]) -> str:
    """Data sets 2414: normal modes with frequency and damping, complex ones with eigenvalue.

    Written here, as pyuff 2.5.8 shifts the columns of negative real parts of eigenvalues.
    """
    values = np.array([found.shape(name) for name in places])
    is_complex = np.iscomplexobj(values)
    kind, number = (3, 5) if is_complex else (2, 2)
    lines: list[str] = []
    for i in range(len(found.hertz) if places else 0):
        root = found.eigenvalues[i]
        reals = np.zeros(12)
        reals[[1, 4]] = found.hertz[i], found.damping[i]
        if is_complex:
            reals[[6, 7]] = root.real, root.imag
        lines += ["    -1", "  2414", _integers(i + 1), f"mode {i + 1}", _integers(1)]
        lines += [found.system.name[:80], *["NONE"] * 4]
        lines += [_integers(1, kind, 2, 8, number, 3)]
        lines += [_integers(0, 0, 0, 0, 0, i + 1, 0, 0), _integers(0, 0)]
        lines += [_reals(reals[:6]), _reals(reals[6:])]
        for node, value in zip(places.values(), values[:, i], strict=True):
            at_node = np.array([value, 0.0, 0.0])
            lines += [_integers(node), _reals(at_node.view(float))]
        lines.append("    -1")
    return "".join(f"{line}\n" for line in lines)


def _integers(*numbers: int) -> str:
    return "".join(f"{n:10d}" for n in numbers)


def _reals(numbers: np.ndarray) -> str:
    return "".join(f"{x:13.5E}" for x in numbers)
