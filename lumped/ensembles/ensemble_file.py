"""Results of an ensemble in a file, chunk by chunk."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lumped.compiler.system import System
from lumped.ensembles.line_file import LineFile
from lumped.ensembles.variants import ParameterSets
from lumped.functionals import Functional
from lumped.kernel.run import FULL
from lumped.many_runs.native_runs import Batch
from lumped.timeloop.results.fingerprint import fingerprint
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.run_options import RunPlan


def heading(
    system: System, variants: ParameterSets, of: Mapping[str, Functional], plan: RunPlan
) -> dict[str, Any]:
    """All on which the results of an ensemble depend, for the first line of its file."""
    values = np.ascontiguousarray(variants.values)
    options = {name: str(value) for name, value in plan._asdict().items() if name != "until"}
    if isinstance(start := plan.start, OperatingPoint):
        options["start"] = fingerprint((start.time, start.x, start.theta, start.settings))
    return {
        "lumped": "ensemble",
        "model": fingerprint(system),
        "parameters": system.parameters,
        "until": plan.until,
        "points": [*variants.names, hashlib.sha256(values.tobytes()).hexdigest()[:16]],
        "runs": len(values),
        "of": {label: f"{f}: {f.readings!r}" for label, f in of.items()},
        "options": options,
    }


class EnsembleFile(LineFile):
    """Results in a file, one line for each chunk of runs (see `LineFile`).

    Attributes
    ----------
    known : list of (int, Batch)
        Results that were found: first run, and those from it on.
    """

    def __init__(self, path: str | Path | None, head: dict[str, Any]) -> None:
        self.known: list[tuple[int, Batch]] = []
        super().__init__(path, head)

    def add(self, which: np.ndarray, batch: Batch) -> None:
        """Keep results of some runs, ascending, at once; without those that were interrupted."""
        done = np.flatnonzero(batch.status != FULL)
        for part in np.split(done, np.flatnonzero(np.diff(which[done]) != 1) + 1):
            if self._file is not None and len(part):
                values, status = batch.values[part], batch.status[part]
                self.write(
                    {
                        "first": int(which[part[0]]),
                        "values": _pack(values.astype("<f8")),
                        "status": _pack(status.astype("<i8")),
                    }
                )

    def read(self, entry: Any) -> None:
        """Take over a chunk that was written before."""
        status = np.frombuffer(base64.b64decode(entry["status"]), "<i8").astype(np.int64)
        values = np.frombuffer(base64.b64decode(entry["values"]), "<f8").astype(float)
        first = int(entry["first"])
        if not 0 <= first <= first + len(status) <= self._head["runs"]:
            raise ValueError(f"there are no runs {first} to {first + len(status) - 1}")
        batch = Batch(values.reshape(len(status), len(self._head["of"])), status)
        self.known.append((first, batch))


def _pack(numbers: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(numbers).tobytes()).decode()
