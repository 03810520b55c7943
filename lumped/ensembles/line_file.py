"""Results of many runs in a file of lines, from which interrupted work goes on."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

from lumped.errors import OptionError


class LineFile:
    """Lines of JSON in a file; without a path nothing is kept.

    The first line says what the results belong to, each other one holds some of them. A last line
    that was not written to its end is dropped.

    Parameters
    ----------
    path : str or Path or None
        The file; made if there is none.
    head : dict
        The first line; its entry "lumped" names the analysis.

    Raises
    ------
    OptionError
        If the file holds something else, or a line of it is damaged.
    """

    def __init__(self, path: str | Path | None, head: dict[str, Any]) -> None:
        self._path = Path() if path is None else Path(path)
        self._head, self._analysis = head, head.get("lumped", "")
        self._file: Any = None
        if path is None:
            return
        held = self._path.read_bytes() if self._path.exists() else b""
        lines = held.split(b"\n")
        whole = len(held) - len(lines.pop())
        begin = json.dumps({"lumped": self._analysis})[:-1].encode()
        if lines or (held and not begin.startswith(held[: len(begin)])):
            self._compare(lines[0] if lines else held)
        for number, line in enumerate(lines[1:], 2):
            try:
                self.read(json.loads(line))
            except (ValueError, TypeError, KeyError, AttributeError) as fault:
                raise OptionError(
                    f"{self._analysis}: line {number} of {self._path} is damaged ({fault}). Remove "
                    "this line, and its runs are made again."
                ) from None
        self._file = self._path.open("ab")
        self._file.truncate(whole)
        if not lines:
            self.write(self._head)

    def read(self, entry: Any) -> None:
        """Take over results that were written before.

        Raises
        ------
        ValueError, TypeError, KeyError, AttributeError
            If they are damaged.
        """
        raise NotImplementedError

    def write(self, entry: Mapping[str, Any]) -> None:
        """Write a line, at once."""
        if self._file is None:
            return
        try:
            self._file.write(json.dumps(entry).encode() + b"\n")
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as fault:
            raise OSError(fault.errno, fault.strerror, str(self._path)) from None

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()

    def _refuse(self, text: str) -> NoReturn:
        raise OptionError(f"{self._analysis}: {self._path} holds {text}")

    def _compare(self, line: bytes) -> None:
        """Refuse a file of something else, and say what differs."""
        try:
            found = json.loads(line)
        except ValueError:
            found = None
        if not isinstance(found, dict) or found.get("lumped") != self._analysis:
            self._refuse(f"something else than runs of {self._analysis}. Choose another file.")
        if found == self._head:
            return
        changes = filter(None, (_change(n, found.get(n), now) for n, now in self._head.items()))
        self._refuse(
            f"runs of another {', another '.join(changes)}. Choose another file, or remove it."
        )


def _change(name: str, before: object, now: object) -> str:
    """What differs in a part of the first line, in words; empty if nothing does."""
    if before == now:
        return ""
    if name == "model":
        return "model, or version of lumped"
    if name == "until":
        return f"time (until = {before} s, now {now} s)"
    if name == "points":
        return "choice of parameters"
    if not (isinstance(before, dict) and isinstance(now, dict)):
        return name
    places = [n for n in dict.fromkeys((*before, *now)) if before.get(n) != now.get(n)]
    if name == "of":
        return f"result {', '.join(map(repr, places))} (the function, or what it uses)"
    return f"value of {', '.join(places[:6])}"
