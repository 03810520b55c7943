"""Results of many runs in a file of lines, from which an interrupted sweep goes on."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.timeloop.fingerprint import fingerprint

__all__ = ["SweepFile", "heading"]

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


class SweepFile:
    """Results in a file; without a path nothing is kept.

    The first line says what the results belong to, each other one holds one result. A last line
    that was not written to its end is dropped.

    Parameters
    ----------
    path : str or Path or None
        The file; made if there is none.
    head : dict
        From `heading`.

    Attributes
    ----------
    known : dict of str to list of float or str
        Results that were found, or why there are none, by their point.

    Raises
    ------
    OptionError
        If the file holds something else, or a line of it is damaged.
    """

    def __init__(self, path: str | Path | None, head: dict[str, Any]) -> None:
        self._path = Path() if path is None else Path(path)
        self._head = head
        self.known: dict[str, Outcome] = {}
        self._file: Any = None
        if path is None:
            return
        held = self._path.read_bytes() if self._path.exists() else b""
        lines = held.split(b"\n")
        whole = len(held) - len(lines.pop())
        if lines or (held and not b'{"lumped": "sweep"'.startswith(held[:18])):
            self._compare(lines[0] if lines else held)
        for number, line in enumerate(lines[1:], 2):
            key, outcome = self._entry(number, line)
            self.known[key] = outcome
        self._file = self._path.open("ab")
        self._file.truncate(whole)
        if not lines:
            self._write(self._head)

    def __getitem__(self, point: Point) -> Outcome | None:
        """What is known of a point."""
        return self.known.get(_key(point))

    def add(self, point: Point, outcome: Outcome) -> None:
        """Keep a result, at once."""
        if self._file is not None:
            kind = "failure" if isinstance(outcome, str) else "values"
            self._write(
                {"point": point, kind: outcome if isinstance(outcome, str) else _told(outcome)}
            )

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()

    def _write(self, entry: Mapping[str, Any]) -> None:
        try:
            self._file.write(json.dumps(entry).encode() + b"\n")
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as fault:
            raise OSError(fault.errno, fault.strerror, str(self._path)) from None

    def _compare(self, line: bytes) -> None:
        """Refuse a file of something else, and say what differs."""
        try:
            found = json.loads(line)
        except ValueError:
            found = None
        if not isinstance(found, dict) or found.get("lumped") != "sweep":
            raise OptionError(
                f"sweep: {self._path} holds something else than runs of a sweep. Choose another "
                "file."
            )
        if found == self._head:
            return
        changes = filter(None, (_change(n, found.get(n), now) for n, now in self._head.items()))
        raise OptionError(
            f"sweep: {self._path} holds runs of another {', another '.join(changes)}. Choose "
            "another file, or remove it."
        )

    def _entry(self, number: int, line: bytes) -> tuple[str, Outcome]:
        """A result that was written before."""
        try:
            entry = json.loads(line)
            point = {str(name): float(value) for name, value in entry["point"].items()}
            if isinstance(failure := entry.get("failure"), str):
                return _key(point), failure
            values = [float(value) for value in entry["values"]]
            if len(values) != len(self._head["of"]):
                raise ValueError(f"{len(values)} results")
        except (ValueError, TypeError, KeyError, AttributeError) as fault:
            raise OptionError(
                f"sweep: line {number} of {self._path} is damaged ({fault}). Remove this line, and "
                "its run is made again."
            ) from None
        return _key(point), values


def _change(name: str, before: object, now: object) -> str:
    """What differs in a part of the first line, in words; empty if nothing does."""
    if before == now:
        return ""
    if name == "model":
        return "model, or version of lumped"
    if name == "until":
        return f"time (until = {before} s, now {now} s)"
    if not (isinstance(before, dict) and isinstance(now, dict)):
        return name
    places = [n for n in dict.fromkeys((*before, *now)) if before.get(n) != now.get(n)]
    if name == "of":
        return f"result {', '.join(map(repr, places))} (the function, or what it uses)"
    return f"value of {', '.join(places[:6])}"


def _key(point: Point) -> str:
    return json.dumps(point, sort_keys=True)


def _told(values: Sequence[float]) -> list[float | str]:
    """Numbers for JSON, which has none that is not finite."""
    return [value if math.isfinite(value) else repr(value) for value in values]
