"""Errors of lumped: each says what is wrong, where, why it is likely so, and what to do."""

from __future__ import annotations

import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any

__all__ = [
    "ConnectError",
    "DeclarationError",
    "EquationError",
    "ExportError",
    "Interrupted",
    "LumpedError",
    "ModelWarning",
    "OptimisationError",
    "OptionError",
    "ParameterError",
    "SingularModelError",
    "SolverError",
    "StartError",
    "UnitError",
    "UnknownNameError",
    "doubt",
    "nearest",
    "shown",
    "told_by",
]


class LumpedError(Exception):
    """Base of every error that lumped raises on purpose."""


class DeclarationError(LumpedError):
    """A component class or instance is declared in a way that cannot be a part."""


class EquationError(LumpedError):
    """An equation or expression is written in a way that has no meaning here."""


class ConnectError(LumpedError):
    """Ports of different kinds meet, or a port that must be connected is not."""


class OptionError(LumpedError, ValueError):
    """An option of an analysis that makes no sense."""


class ParameterError(LumpedError):
    """Parameters are missing or out of their range; all faults of a model in one error."""


class SingularModelError(LumpedError):
    """The equations of the model over-determine or under-determine its unknowns."""


class StartError(LumpedError):
    """Start values contradict each other or cannot be met."""


class UnitError(LumpedError):
    """A value has a unit of another dimension, or one that cannot be read."""


class UnknownNameError(LumpedError, KeyError, AttributeError):
    """A name that the model does not have; the text lists the nearest ones."""

    def __str__(self) -> str:
        return str(self.args[0])


class ModelWarning(UserWarning):
    """A model can be computed, but a part of it does nothing and is likely not meant so."""


class SolverError(LumpedError):
    """A numerical run failed.

    Attributes
    ----------
    partial : Trajectory or None
        What was computed up to the failure.
    """

    def __init__(self, text: str, partial: Any = None) -> None:
        super().__init__(text)
        self.partial = partial


class ExportError(LumpedError):
    """A model cannot be written for another tool."""


class OptimisationError(LumpedError):
    """No optimum was found; the text names the constraint that is violated most.

    Attributes
    ----------
    status : str
        What the solver says.
    """

    def __init__(self, text: str, status: str) -> None:
        super().__init__(text)
        self.status = status

    def __reduce__(self) -> tuple[type[OptimisationError], tuple[str, str]]:
        return type(self), (str(self), self.status)


class Interrupted(KeyboardInterrupt):
    """A run, or a study of many, was interrupted (Ctrl-C).

    Attributes
    ----------
    partial : Trajectory, or what the study gives
        What was computed until then; None if that is nothing.
    """

    def __init__(self, text: str, partial: Any) -> None:
        super().__init__(text)
        self.partial = partial

    def __reduce__(self) -> tuple[type[Interrupted], tuple[str, Any]]:
        return type(self), (str(self), self.partial)


def doubt(rtol: float) -> str:
    """What to say before a failure of a run is told as one of the drive; empty up to 1e-6."""
    if rtol <= 1e-6:
        return ""
    return (
        f"At rtol = {rtol:g} this may be the error of the run itself; first run with rtol = 1e-6. "
    )


_ALIKE = 0.55
"""Likeness of two names, of 1, from which one may be meant for the other."""


def nearest(name: str, known: Iterable[str], most: int = 4) -> str:
    """Text that offers the known names nearest to `name`."""
    names = list(known)
    lowered = {n.lower(): n for n in names}
    close = get_close_matches(name, names, most, _ALIKE)
    close += [
        lowered[n]
        for n in get_close_matches(name.lower(), lowered, most, _ALIKE)
        if lowered[n] not in close
    ]
    path, _, tail = name.rpartition(".")
    close += [n for n in names if n.rpartition(".")[2] == tail and n not in close]
    if path:
        close += [n for n in names if n.rpartition(".")[0] == path and n not in close]
    if close:
        return "Nearest: " + ", ".join(close[:most]) + "."
    if not names:
        return "There are none."
    return "Known: " + ", ".join(names[:12]) + (", ..." if len(names) > 12 else "") + "."


def shown(value: object) -> str:
    """A value in one short line."""
    line = " ".join(repr(value).split())
    return line if len(line) <= 60 else f"{line[:57]}..."


@contextmanager
def told_by(label: str, method: str) -> Iterator[None]:
    """Run a method that a component brings, so that what it raises tells of which component.

    Raises
    ------
    EquationError
        With the component, and where in the code it comes from.
    """
    try:
        yield
    except EquationError as error:
        raise EquationError(f"{label}: {error}") from None
    except LumpedError:
        raise
    except Exception as fault:  # whatever a foreign method raises
        frame = traceback.extract_tb(fault.__traceback__)[-1]
        raise EquationError(
            f"{label}: {method} raised {type(fault).__name__}: {fault} (line {frame.lineno} of "
            f"{Path(frame.filename).name}). Correct the method, or what was given to it."
        ) from fault
