"""Whether a drive keeps limits, how far it uses them, and where."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np

from lumped.errors import OptionError, SolverError
from lumped.functionals import Condition, mean, peak
from lumped.functionals.functional import refuse_other
from lumped.plots.draw import Canvas, draw
from lumped.plots.numbers import utilisation
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.display_units import Units, speed_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.timeloop.results.trajectory import Trajectory
from lumped.vibration.ordered.order_amplitudes import OrderAmplitudes
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.rotating.harmonics import refuse_unbalanced
from lumped.vibration.rules.limits import Limit, Measure
from lumped.vibration.rules.measures import find_peaks_of_use, measure_quantity
from lumped.vibration.speeds.campbell import BarredRange

_FOUND = 1e-6
"""Relative error of a maximum from which on a note is due."""


@dataclass(frozen=True, eq=False)
class Result:
    """How far a drive uses one limit.

    Attributes
    ----------
    name, quantity, unit, measure, clause, source : str
        The limit.
    value, permitted, utilisation : float
        Where it is used most.
    speed : float
        There, rad/s; nan for a run.
    beyond : tuple of BarredRange
        Speeds at which it is exceeded.
    """

    name: str
    quantity: str
    unit: str
    measure: str
    clause: str
    source: str
    value: float
    permitted: float
    utilisation: float
    speed: float
    beyond: tuple[BarredRange, ...]

    @property
    def passed(self) -> bool:
        """Whether the limit is kept everywhere."""
        return self.utilisation <= 1

    def format_values(self, units: Units = None, digits: int = 6) -> tuple[str, ...]:
        """Value, permitted value and unit, as they are shown."""
        is_change = self.measure in ("maximum", "half range", "sum")
        own = self.quantity, self.unit, self.value, self.permitted
        return amounts(*own, digits=digits, units=units, is_change=is_change)


@dataclass(frozen=True, eq=False)
class Verdict(RichHtml):
    """All limits, how far they are used, where, and whether they are kept.

    Attributes
    ----------
    results : tuple of Result
        By utilisation, the largest first.
    notes : tuple of str
        What it does not cover, and what is known of the accuracy of what is judged.
    """

    results: tuple[Result, ...]
    notes: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether all limits are kept."""
        return all(result.passed for result in self.results)

    @property
    def barred(self) -> tuple[BarredRange, ...]:
        """Speeds at which any limit is exceeded, joined where they meet."""
        every = sorted((r.begin, r.end) for result in self.results for r in result.beyond)
        found: list[BarredRange] = []
        for begin, end in every:
            if found and begin <= found[-1].end:
                found[-1] = BarredRange(found[-1].begin, max(end, found[-1].end))
            else:
                found.append(BarredRange(begin, end))
        return tuple(found)

    @checked
    def plot(self, **canvas: Unpack[Canvas]) -> Any:
        """How far the limits are used, a bar for each.

        Parameters
        ----------
        backend, ax
            As in `lumped.Trajectory.plot`.
        """
        shares = [(f"{r.name}: {r.quantity} ({r.measure})", r.utilisation) for r in self.results]
        kept = sum(result.passed for result in self.results)
        title = "; ".join([f"{kept} of {len(shares)} limits kept", *self.notes])
        return draw(utilisation(title, shares), **canvas)

    def __repr__(self) -> str:
        kept = sum(result.passed for result in self.results)
        head = f"{'passed' if self.passed else 'FAILED'}: {kept} of {len(self.results)} limits kept"
        speed = speed_unit()
        rows = [
            (
                r.name,
                r.quantity,
                r.measure,
                *r.format_values(),
                f"{r.utilisation:.1%}",
                "-" if np.isnan(r.speed) else number(speed.value(r.speed)),
                "yes" if r.passed else "NO",
                " ".join(part for part in (r.clause, r.source) if part) or "-",
            )
            for r in self.results
        ]
        columns = (
            *("limit", "quantity", "measure", "value", "permitted", "unit", "used"),
            *(f"at, {speed.unit}", "kept", "source"),
        )
        text = f"{head}\n" + table(columns, rows)
        if self.barred:
            text += "\nbarred: " + "; ".join(str(each) for each in self.barred)
        return "\n".join([text, *self.notes])


@checked
def verdict(found: OrderAmplitudes | Trajectory, limits: Iterable[Limit | Condition]) -> Verdict:
    """Whether vibrations keep limits, how far these are used, and where.

    Order responses are judged over the range of their speeds, at these and at all maxima between
    them; operating points and amplitudes that were given at each speed lie on lines between these.
    Vibrations of other kinds are judged at the speeds that were computed. What a verdict does
    not cover, and what is known of the accuracy of what it judges, stands in its `notes`.

    Parameters
    ----------
    found : OrderResponse, OrbitRange or Trajectory
        Steady vibration over the speed, or a run.
    limits : iterable of Limit or Condition
        The limits; of a run conditions too, such as ``lumped.functionals.rms("motor.tau") <= 40``.

    Returns
    -------
    Verdict

    Raises
    ------
    OptionError
        If there is no limit, it holds at no computed speed, or permits nothing.
    UnitError
        If a limit has a unit of another dimension than its quantity.
    UnknownNameError
        If a quantity was not computed.
    """
    every = tuple(limits)
    if not every:
        raise OptionError("verdict: name at least one limit.")
    notes: dict[str, None] = {}
    results = [
        _check_bound(found, each) if isinstance(each, Condition) else _result(found, each, notes)
        for each in every
    ]
    known: tuple[str, ...] = ()
    if isinstance(found, OrderResponse):
        known = found.tell_notes(np.unique([result.speed for result in results]))
    elif isinstance(found, OrderAmplitudes):
        known = found.notes
    return Verdict(tuple(sorted(results, key=lambda r: -r.utilisation)), (*known, *notes))


def _result(found: OrderAmplitudes | Trajectory, limit: Limit, notes: dict[str, None]) -> Result:
    key = found.system.key(limit.quantity)
    unit = found.system.quantity(key).unit
    beyond: Iterable[tuple[float, float]] = ()
    if limit.measure == "mean power" and unit != "W":
        raise OptionError(
            f"limit '{limit.name}' of {key}: a mean power is that of a quantity in W, not {unit}."
        )
    if limit.measure == "with mean" and isinstance(found, OrderResponse):
        what = f"limit '{limit.name}' of {key}, with its mean"
        refuse_unbalanced(found.small, found.rotation, what)
    if isinstance(found, Trajectory):
        speeds, values = np.array([np.nan]), np.array([_of_run(found, key, limit.measure)])
        if callable(limit.permitted) or (
            isinstance(limit.permitted, Sequence) and not isinstance(limit.permitted, str)
        ):
            raise OptionError(
                f"limit '{limit.name}' of {key} depends on the speed; a run needs one value."
            )
        permitted = limit.at(speeds, unit)
    else:
        speeds, values, permitted, beyond = _judge_speeds(found, key, limit, notes)
    used = values / permitted
    k = int(used.argmax())
    if used[k] > 1 and limit.advice:
        notes[f"limit '{limit.name}' of {key}: {limit.advice}"] = None
    if limit.barred is not None:
        beyond = [_widen(limit.barred, ends, speeds, used) for ends in beyond]
    return Result(
        limit.name,
        key,
        unit,
        "largest"
        if isinstance(found, Trajectory) and limit.measure != "mean power"
        else limit.measure,
        limit.clause,
        limit.source,
        float(values[k]),
        float(permitted[k]),
        float(used[k]),
        float(speeds[k]),
        tuple(BarredRange(*ends) for ends in beyond),
    )


def _judge_speeds(
    found: OrderAmplitudes, key: str, limit: Limit, notes: dict[str, None]
) -> tuple[Real, Real, Real, Iterable[tuple[float, float]]]:
    """Speeds, a measure there, what is permitted, and ends of the ranges that exceed it."""
    ascending = np.argsort(found.speeds)
    speeds, shown = found.speeds[ascending], speed_unit()
    begin, end = limit.ends or (speeds[0], speeds[-1])
    low, high = float(max(begin, speeds[0])), float(min(end, speeds[-1]))
    computed, unit = limit.holding(speeds), found.system.quantity(key).unit
    if low > high or not (len(computed) or isinstance(found, OrderResponse)):
        raise OptionError(
            f"limit '{limit.name}' of {key} holds from {begin:g} to {end:g} rad/s, where no speed "
            "was computed."
        )
    if (begin, end) != (low, high):
        notes[
            f"limit '{limit.name}' of {key} is judged from {shown.value(low):.6g} to "
            f"{shown.value(high):.6g} {shown.unit} only"
        ] = None
    if isinstance(found, OrderResponse):
        try:
            peaks = find_peaks_of_use(found, key, limit, (low, high))
        except SolverError as error:
            why = f"between the {len(speeds)} speeds of the response nothing is judged: {error}"
            notes[why.rstrip(".")] = None
        else:
            if peaks.missed > _FOUND:
                notes[
                    f"{limit.measure} of {key} between the speeds of the response is known to "
                    f"{peaks.missed:.0e} only"
                ] = None
            permitted = limit.at(peaks.speeds, unit)
            return peaks.speeds, peaks.sizes * permitted, permitted, peaks.stretches
    elif len(computed) > 1:
        notes[f"judged at the {len(computed)} speeds that were computed, not between these"] = None
    values = measure_quantity(found, key, limit.measure)[ascending][np.isin(speeds, computed)]
    permitted = limit.at(computed, unit)
    return computed, values, permitted, _beyond(computed, values / permitted)


def _widen(
    barred: Callable[[float], BarredRange], ends: tuple[float, float], speeds: Real, used: Real
) -> tuple[float, float]:
    """A range in which a limit is exceeded, and what a rule bars about the worst speed there."""
    inside = (speeds >= ends[0]) & (speeds <= ends[1])
    ruled = barred(float(speeds[np.where(inside, used, -np.inf).argmax()]))
    return min(ends[0], ruled.begin), max(ends[1], ruled.end)


def _check_bound(found: OrderAmplitudes | Trajectory, condition: Condition) -> Result:
    """How far a run uses the bound of a functional."""
    if not isinstance(found, Trajectory):
        raise OptionError(f"verdict: {condition} is a limit of a run; take a Limit over the speed.")
    refuse_other([condition.of], "run", "verdict")
    unit = condition.of.unit(found.system)
    low, high = condition.bounds(unit, "verdict")
    value, is_upper = found.value(condition.of), low == -np.inf
    part, whole, bound = (value, high, high) if is_upper else (low, value, low)
    # a share says something only of what lies on one side of zero
    used = part / whole if part > 0 and whole > 0 else (0.0 if part <= whole else np.inf)
    name, measure = "condition", "at most" if is_upper else "at least"
    return Result(
        name, str(condition.of), unit, measure, "", "", value, bound, used, float("nan"), ()
    )


def _of_run(found: Trajectory, key: str, measure: Measure) -> float:
    """Largest size of a quantity, or its mean, over the run."""
    return found.value(mean(key) if measure == "mean power" else peak(key))


def _beyond(speeds: Real, used: Real) -> list[tuple[float, float]]:
    """Ranges of speeds in which a limit is exceeded; ends by lines between the speeds."""
    above = np.concatenate([[False], used > 1, [False]])
    edges = np.flatnonzero(above[1:] != above[:-1]).tolist()
    found = []
    for first, after in zip(edges[::2], edges[1::2], strict=True):
        begin, end = speeds[first], speeds[after - 1]
        if first:
            begin = np.interp(1.0, used[first - 1 : first + 1], speeds[first - 1 : first + 1])
        if after < len(speeds):
            end = np.interp(1.0, used[[after, after - 1]], speeds[[after, after - 1]])
        found.append((float(begin), float(end)))
    return found
