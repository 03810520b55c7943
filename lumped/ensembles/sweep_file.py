"""Results of a sweep in a file, run by run."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lumped.compiler.system import System
from lumped.ensembles.line_file import LineFile
from lumped.timeloop.results.fingerprint import fingerprint

Point = dict[str, float]
Outcome = list[float] | str


def heading(
    system: System, until: float, of: Mapping[str, object], options: Mapping[str, object]
) -> dict[str, Any]:
    """All on which the results of a sweep depend but the point, for the first line of its file."""
    return {
        "lumped": "sweep",
        "model": fingerprint(system),
        "parameters": system.parameters,
        "until": until,
        "of": {label: fingerprint(measure) for label, measure in of.items()},
        "options": {name: fingerprint(value) for name, value in options.items()},
    }


class SweepFile(LineFile):
    """Results in a file, one line for each run (see `LineFile`).

    Attributes
    ----------
    known : dict of str to list of float or str
        Results that were found, or why there are none, by their point.
    """

    def __init__(self, path: str | Path | None, head: dict[str, Any]) -> None:
        self.known: dict[str, Outcome] = {}
        super().__init__(path, head)

    def __getitem__(self, point: Point) -> Outcome | None:
        """What is known of a point."""
        return self.known.get(_key(point))

    def add(self, point: Point, outcome: Outcome) -> None:
        """Keep a result, at once."""
        kind = "failure" if isinstance(outcome, str) else "values"
        content = outcome if isinstance(outcome, str) else _encode(outcome)
        self.write({"point": point, kind: content})

    def read(self, entry: Any) -> None:
        """Take over a run that was written before."""
        point = {str(name): float(value) for name, value in entry["point"].items()}
        if isinstance(failure := entry.get("failure"), str):
            self.known[_key(point)] = failure
            return
        values = [float(value) for value in entry["values"]]
        if len(values) != len(self._head["of"]):
            raise ValueError(f"{len(values)} results")
        self.known[_key(point)] = values


def _key(point: Point) -> str:
    return json.dumps(point, sort_keys=True)


def _encode(values: Sequence[float]) -> list[float | str]:
    """Numbers for JSON, which has none that is not finite."""
    return [value if math.isfinite(value) else repr(value) for value in values]
