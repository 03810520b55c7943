"""Options of runs: what all analyses that make some take, and the record that they hand on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any, Literal, NamedTuple, TypedDict, get_args, get_type_hints

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError
from lumped.functionals.functional import Functional, watching
from lumped.support.units import read_time
from lumped.timeloop.results.operating_point import OperatingPoint

Grid = int | Sequence[float | str] | np.ndarray | None
Method = Literal["auto", "explicit", "implicit", "exact", "steps", "taylor"]


class RunOptions(TypedDict, total=False):
    """Options of runs, which each analysis takes by name that makes some; all may be left out.

    Attributes
    ----------
    begin : float or str, optional
        Begin, s; default is the time of the start point, or zero. With a start point of another
        time, its states are taken as those at the begin.
    parameters : mapping of name to float, optional
        Parameters to change; beside a start point, from those of the point.
    start : mapping of name to float, or OperatingPoint, optional
        Start values to set or change; or a point to start from, with its time, states, parameters
        and modes: one that `equilibrium` or `start_point` found, or one of an earlier run, which
        then goes on (``start=run.point(2.0)``). Where parameters differ from those of the point,
        its states stay, and positions and modes are found anew.
    free : iterable of names
        Parameters that the start values determine (see `start_point`). Derivatives are not
        followed through them.
    atol : float, optional
        Absolute tolerance, relative to the nominal value of each state; default is
        ``rtol / 1000``, at least 1e-12. It governs a state that stays smaller than
        ``atol / rtol`` throughout; `Trajectory` names such states when printed. Analyses that make
        runs tighter than `rtol` tighten it alike.
    method : {"auto", "explicit", "implicit", "exact", "steps", "taylor"}
        "explicit" is DOP853, "implicit" Rodas5P, "steps" the second while stability
        holds the steps of the first and implicit ones are longer, else the first, as often as that
        changes. "taylor" is the same with explicit steps by Taylor's series of the states, compiled
        for the system and the order that `rtol` asks for: long ones for smooth motions, above all
        of linear drives and at tight tolerances; it is refused where what varies goes through an
        operation without derivatives, or a linkage is closed by iteration. "exact" is the closed
        form, for systems that are linear between jumps, with functions of time that are polynomials
        there. "auto" takes the closed form where there is one, rounding leaves it better than
        `rtol`, and it costs less than steps; else, and for ``grid=None``, "steps". After 50 000
        attempts it goes on as "taylor" if there are series: the rest of such a run is worth
        compiling them. Where many runs are made, "auto" is "steps", and "exact" is refused, as they
        have no closed form in common. Derivatives follow steps too, and refuse "taylor".
    max_steps : int
        Give up after so many attempted steps.
    """

    begin: Annotated[float | str | None, None]
    parameters: Annotated[Changes | None, None]
    start: Annotated[Changes | OperatingPoint | None, None]
    free: Annotated[Iterable[Name], ()]
    atol: Annotated[float | None, None]
    method: Annotated[Method, "auto"]
    max_steps: Annotated[int, 1_000_000]


_DEFAULTS: dict[str, Any] = {
    name: get_args(annotation)[1]
    for name, annotation in get_type_hints(RunOptions, include_extras=True).items()
}


class RunPlan(NamedTuple):
    """Options of runs after they were checked (see `RunOptions`), with times in seconds.

    Those for analyses that follow the states are led by these as long as they lead at all.
    """

    until: float
    rtol: float
    begin: float
    parameters: Changes | None
    start: Changes | OperatingPoint | None
    free: tuple[Name, ...]
    atol: float | None
    method: Method
    max_steps: int
    is_led: bool = False

    @property
    def relative_atol(self) -> float:
        """Absolute tolerance, relative to nominal values."""
        return max(self.rtol * 1e-3, 1e-12) if self.atol is None else self.atol

    def at(self, rtol: float) -> RunPlan:
        """The same at another tolerance, the absolute one in proportion."""
        atol = None if self.atol is None else self.atol * (rtol / self.rtol)
        return self._replace(rtol=rtol, atol=atol)

    def by_steps(self, analysis: str, *, are_followed: bool = False) -> RunPlan:
        """The same by steps, which are followed by derivatives or are those of many runs.

        Raises
        ------
        OptionError
            If another method was asked for, or parameters are free and derivatives follow.
        """
        if self.method == "exact":
            raise OptionError(
                f"{analysis}: the closed form is for single runs; take method='steps'."
            )
        if are_followed and self.method == "taylor":
            raise OptionError(
                f"{analysis}: derivatives follow no steps by Taylor's series; take method='steps'."
            )
        if are_followed and self.free:
            raise OptionError(
                f"{analysis}: derivatives are not followed through parameters that start values "
                "determine; give the values that lumped.start_point(..., free=...) finds, as "
                "parameters=."
            )
        return self._replace(method="steps") if self.method == "auto" else self

    def changes(self, system: System) -> dict[str, Any]:
        """Parameters by name that differ from those of the model, as given or of the point."""
        of_point = self.start.parameters if isinstance(self.start, OperatingPoint) else {}
        given: Mapping[Any, Any] = self.parameters or {}
        return of_point | {system.key(name): value for name, value in given.items()}

    def watching(self, system: System, of: Iterable[Functional]) -> System:
        """The system that is run, which stops at the kinks of formulas in functionals.

        Raises
        ------
        OptionError
            If the start point belongs to another system.
        """
        if not isinstance(self.start, OperatingPoint):
            return watching(system, of)
        begun = self.start.system
        if not begun.has_equations_of(system):
            raise OptionError(
                f"{system.name}: the start point belongs to another system. Make it with the "
                "system that is given."
            )
        return watching(begun.watching(system.structure.flat.watched), of)


def run_plan(until: float | str, rtol: float, options: RunOptions) -> RunPlan:
    """Options of runs, checked.

    Raises
    ------
    OptionError
        If one makes no sense.
    """
    given: dict[str, Any] = {**_DEFAULTS, **options}
    start, begin, free = given["start"], given["begin"], tuple(given["free"])
    if begin is None:
        begin = start.time if isinstance(start, OperatingPoint) else 0.0
    until, begin = read_time(until, "until"), read_time(begin, "begin")
    given |= {"until": until, "rtol": rtol, "begin": begin, "free": free}
    plan = RunPlan(**given)
    if not until > begin:
        what = "a positive, finite time" if begin == 0 else f"after the begin, {begin:g} s"
        what += " (that of the start point, unless begin= says another)" * (begin != 0)
        raise OptionError(f"until = {until!r} s: the end must be {what}.")
    if not 1e-14 <= rtol < 1:
        raise OptionError(f"rtol = {rtol}: the relative tolerance must lie between 1e-14 and 1.")
    if plan.atol is not None and not plan.atol > 0:
        raise OptionError(f"atol = {plan.atol}: the absolute tolerance must be positive.")
    if plan.max_steps < 1:
        raise OptionError(f"max_steps = {plan.max_steps}: at least one step is needed.")
    if free and isinstance(start, OperatingPoint):
        raise OptionError(
            "free: a start point has all its parameters; start values determine free ones."
        )
    return plan


def plan_of(
    what: object, analysis: str, until: float | str | None, rtol: float, options: RunOptions
) -> RunPlan | None:
    """Options of the runs of a system, checked; None for what is no system.

    Raises
    ------
    OptionError
        If one makes no sense, the end of runs is missing, or what is no system is given some.
    """
    if isinstance(what, System):
        if until is None:
            raise OptionError(f"{analysis}: a system is simulated; give until=, s.")
        plan = run_plan(until, rtol, options)
        plan.watching(what, ())  # refuses a point of another system
        return plan
    given = [name for name, value in options.items() if value is not None]
    if given or until is not None:
        raise OptionError(
            f"{analysis}: {', '.join([*given, *['until'] * (until is not None)])}: options of runs "
            "belong to a system; what else is given has its own."
        )
    return None
