"""What happens in a duty cycle: a run, a system or a history of values, and where it turns."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, shown
from lumped.gradients.legs import SmoothParts, legs_of
from lumped.gradients.readings import turning_points as between_steps
from lumped.gradients.steps import steps_of
from lumped.simulation.simulate import simulate
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.units import read_time
from lumped.timeloop.cycle_count import count_cycles
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class LoadCase:
    """A part of a duty cycle.

    Parameters
    ----------
    load : Trajectory, System or array_like
        A run; a system, which is run; or the values of the load, shape (n,).
    repetitions : int
        How often it happens in a duty cycle.
    until : float or str, optional
        End of the run of a system, s.
    parameters : mapping of name to float, optional
        Parameters to change in it.
    start : mapping of name to float, or OperatingPoint, optional
        Its start values.
    step : float or str, optional
        Time between two values of a history, s.
    """

    load: Trajectory | System | ArrayLike
    repetitions: int = 1
    until: float | str | None = None
    parameters: Changes | None = None
    start: Changes | OperatingPoint | None = None
    step: float | str | None = None

    def __repr__(self) -> str:
        if isinstance(self.load, Trajectory):
            what = f"a run of {self.load.system.name}"
        elif isinstance(self.load, System):
            what = f"{self.load.name} up to {self.until}"
        else:
            what = f"{np.size(self.load)} values"
        return f"{what}, {self.repetitions} times"


class Loaded(NamedTuple):
    """What a load case does to a part.

    Attributes
    ----------
    values : ndarray, shape (n,)
        The load, its turning points among them.
    duration : float
        Once, s.
    unit : str
        Unit of the load; empty if it is not known.
    """

    values: Real
    duration: float
    unit: str


def read_load(case: LoadCase, what: str, of: Name | None, rtol: float) -> Loaded:
    """The load of a case.

    Raises
    ------
    OptionError
        If something that belongs to this kind of load is missing or makes no sense.
    """
    n = case.repetitions
    if isinstance(n, bool) or not isinstance(n, int | np.integer) or n < 1:
        raise OptionError(
            f"{what}: repetitions = {shown(n)}: a whole number of at least 1 is needed. Take a "
            "longer duty cycle for what happens less often."
        )
    if isinstance(case.load, System | Trajectory):
        return _of_run(case, what, of, rtol)
    values = np.asarray(case.load)
    if values.dtype.kind not in "iuf" or values.ndim != 1 or len(values) < 2:
        raise OptionError(
            f"{what}: load = {shown(case.load)}: a run, a system, or at least two values of the "
            "load are needed."
        )
    if not np.isfinite(values).all():
        raise OptionError(f"{what}: load: value {np.argmin(np.isfinite(values))} is not finite.")
    _refuse(case, what, ("until", "parameters", "start"), "a history of values")
    if case.step is None:
        raise OptionError(f"{what}: step, the time between two values of the load, is missing.")
    step = read_time(case.step, f"{what}: step")
    if not 0 < step < np.inf:
        raise OptionError(f"{what}: step = {step:g} s must be positive and finite.")
    return Loaded(values.astype(float), step * (len(values) - 1), "")


def _of_run(case: LoadCase, what: str, of: Name | None, rtol: float) -> Loaded:
    """The load of a case that is a run, or is run."""
    if of is None:
        raise OptionError(f"{what}: a run has many quantities; say which is the load, of='...'.")
    if isinstance(case.load, Trajectory):
        _refuse(case, what, ("until", "parameters", "start", "step"), "a run")
        run = case.load
    else:
        assert isinstance(case.load, System)
        _refuse(case, what, ("step",), "a system")
        if case.until is None:
            raise OptionError(f"{what}: until, the end of the run of the system, is missing.")
        given = {"parameters": case.parameters, "start": case.start, "until": case.until}
        system = case.load.watching([case.load.key(of)])
        run = simulate(system, grid=None, rtol=rtol, **given)  # type: ignore[arg-type]
    unit = run.system.quantity(of).unit
    return Loaded(turning_points(run, of, rtol=rtol), float(run.t[-1] - run.t[0]), unit)


def _refuse(case: LoadCase, what: str, names: tuple[str, ...], kind: str) -> None:
    """Refuse what does not belong to a kind of load."""
    for name in names:
        if getattr(case, name) is not None:
            raise OptionError(f"{what}: {name} = {shown(getattr(case, name))}: not for {kind}.")


@checked
def turning_points(run: Trajectory, of: Name, *, rtol: float = 1e-6) -> Real:
    """Values at which a quantity of a run turns, with its first and last.

    It is enclosed inside the steps of the run, so an extreme between two output times is found as
    well, however short it is.
    Where the quantity jumps, both sides count.

    Parameters
    ----------
    run : Trajectory
        From `simulate`, best with ``grid=None``, which records all steps.
    of : name or expression
        The quantity.
    rtol : float
        Swings that are smaller than this part of its range are left out.

    Returns
    -------
    ndarray, shape (t,)
        At least two, to be given to `rainflow`.

    Raises
    ------
    OptionError
        If `rtol` is not between 0 and 1, or the run has no steps.
    SolverError
        If the output times are too far apart to follow the quantity between them.
    UnknownNameError
        If the quantity does not exist.
    """
    if not 0 < rtol < 1:
        raise OptionError(f"turning_points: rtol = {rtol:g} must be between 0 and 1.")
    key, system = run.system.key(of), run.system
    if not len(run.t) or run.t[-1] == run.t[0]:
        raise OptionError(f"{system.name}: the run has no steps in which {key} could turn.")
    found: list[float] = []
    # states may change places; from then on another system leads the run
    pieces = (piece for piece in run.pieces if len(piece.t))
    for leading, group in itertools.groupby(pieces, lambda piece: piece.system):
        part = replace(run, system=leading, pieces=tuple(group), _known={})
        course = SmoothParts(part, legs_of(part), steps_of(leading, ()), rtol)
        points = between_steps.turning_points(course, (key,))
        found += [point.value for point in points]
    values = np.array(found)
    turning = values[count_cycles(values).turning]
    return turning if len(turning) > 1 else values[:2]
