"""From a model to a system."""

from __future__ import annotations

import gc
import time as clock
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from lumped.compiler.idle_parts import find_idle_parts
from lumped.compiler.structure import Name, Structure
from lumped.compiler.system import System
from lumped.errors import ModelWarning, SingularModelError
from lumped.flattening.flatten import flatten
from lumped.language.component import Component
from lumped.reduction.block_errors import UnheldError
from lumped.support.arguments import checked
from lumped.support.process_lock import process_lock


@contextmanager
def _pause_collector() -> Iterator[None]:
    """No garbage collection while many small objects are made that all stay: halves the time."""
    running = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if running:
            gc.enable()


@checked
def assemble(
    model: Component, *, of: Iterable[Name] | None = None, keep: Iterable[Name] = ()
) -> System:
    """Flatten, check and reduce a model.

    Parameters
    ----------
    model : Component
        What to assemble.
    of : iterable of names or references, optional
        Compute only what these need. Default: everything but cyclic coordinates, the absolute
        angles or positions on which nothing depends.
    keep : iterable of names or references
        Quantities to compute all the same. A run has them without that, too: what was left out is
        integrated when it is first asked for, at the cost of another run.

    Returns
    -------
    System

    Warns
    -----
    ModelWarning
        If a part is connected to nothing, or all its ends are joined to one another.

    Raises
    ------
    OptionError
        If `model` is no component.
    ParameterError, ConnectError, EquationError, SingularModelError
        If the model is not sound; the text names the components.
    UnknownNameError
        If `of` or `keep` names something the model does not have.
    """
    with process_lock, _pause_collector():
        begin = clock.perf_counter()
        structure = _reduce(model, of, keep)
        reduced = clock.perf_counter()
        system = System(structure)
        spent = sum(structure.seconds.values())
        system.seconds = {"flatten": reduced - begin - spent, **system.seconds}
        idle = find_idle_parts(structure.flat)
    for text in idle:
        warnings.warn(f"{structure.flat.name}: {text}", ModelWarning, stacklevel=3)
    return system


def _reduce(model: Component, of: Iterable[Name] | None, keep: Iterable[Name]) -> Structure:
    """The model reduced, with the equations of friction that has springs only on a side."""
    of, keep = None if of is None else list(of), list(keep)
    try:
        return Structure(flatten(model), of, keep)
    except UnheldError as error:
        unheld = error
    massless: dict[str, bool] = {}
    found = unheld.massless
    while not found.keys() <= massless.keys():
        massless |= found
        try:
            return Structure(flatten(model, massless=massless), of, keep)
        except UnheldError as error:
            found = error.massless
        except SingularModelError:
            break
    raise SingularModelError(str(unheld))
