"""Reference files of the machines, computed apart from this project."""

from pathlib import Path

import numpy as np

DATA = Path(__file__).parents[2] / "data"


def columns(machine: str, name: str, *, named: bool = True) -> np.ndarray:
    """A reference file: columns by their names, or one row for each line."""
    heads = {"names": True, "deletechars": ""} if named else {"skip_header": 1}
    return np.genfromtxt(DATA / machine / f"{name}.csv", delimiter=",", **heads)
