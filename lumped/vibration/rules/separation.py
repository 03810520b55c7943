"""Whether natural frequencies keep away from what excites in operation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lumped.errors import OptionError
from lumped.support.arguments import checked
from lumped.support.display_units import speed_unit
from lumped.vibration.rules.verdict import Result, Verdict
from lumped.vibration.speeds.campbell import BarredRange, Campbell, CriticalSpeed, Orders

MarginRule = Literal["API 617", "KR propulsion", "KR generating set"]


@dataclass(frozen=True)
class _Margin:
    """Least distances below and above the operation, as shares of it, and where they stand."""

    below: float
    above: float
    source: str
    is_about_rated: bool = False


_KR = "read in KR Rules for Steel Ships 2025, 5-4-204"
_RULES: dict[str, _Margin] = {
    "API 617": _Margin(0.1, 0.1, "read in Wang, Feese and Pettinato (2012)"),
    "KR propulsion": _Margin(0.2, 0.1, _KR, is_about_rated=True),
    "KR generating set": _Margin(0.1, 0.1, _KR, is_about_rated=True),
}


@checked
def separation(
    critical: Campbell | Iterable[CriticalSpeed],
    *,
    between: tuple[float, float],
    margin: float | MarginRule | Callable[[float], float] = 0.1,
    source: str = "user's number",
    frequencies: Orders = (),
) -> Verdict:
    """Whether natural frequencies keep away from what excites in operation.

    Parameters
    ----------
    critical : Campbell or iterable of CriticalSpeed
        From `campbell`, or from `critical_speeds`.
    between : tuple of float
        First and last speed of operation, rad/s.
    margin : float, callable or {"API 617", "KR propulsion", "KR generating set"}
        Least distance of a critical speed from these, as a share of the nearest of them: a number,
        a function of the order, or the name of a rule.
    source : str
        Where a margin of your own stands.
    frequencies : iterable of float or mapping of str to float
        What excites at every speed, Hz, such as the frequency of the line and its double. They are
        judged by the natural frequencies of a diagram, on lines between its speeds.

    Returns
    -------
    Verdict
        A row for each critical speed, and for each mode and frequency: its distance, and the margin
        over it as utilisation; infinite within the range.

    Raises
    ------
    OptionError
        If the range or the margin makes no sense, or a diagram does not reach as far as both.

    Notes
    -----
    "API 617" asks for 10 % from all that excites in operation (told by Q. Wang, T. Feese and
    B. Pettinato, 41st Turbomachinery Symposium, 2012).

    "KR propulsion" and "KR generating set" ask that no major critical speed lies from 80 % or 90 %
    to 110 % of the rated speed, which both ends of `between` are (Korean Register, Rules for the
    Classification of Steel Ships, 2025, Pt 5 Ch 4, 204). Major are, for n cylinders in line and the
    mode with one node, the orders n and n/2 of four strokes and n of two.
    """
    low, high = between
    if not 0 < low <= high < np.inf:
        raise OptionError(
            f"separation: between = {between}: the first and last speed of operation, rad/s, above "
            "zero."
        )
    every = critical.critical if isinstance(critical, Campbell) else tuple(critical)
    asked = [_margin_of(margin, each.order, source, between) for each in every]
    searched = [each.searched for each in every]
    if isinstance(critical, Campbell):
        searched.append((float(critical.speeds[0]), float(critical.speeds[-1])))
    if not searched:
        raise OptionError("separation: there is no critical speed; give the diagram.")
    _check_reach(searched, between, asked or [_margin_of(margin, 1.0, source, between)])
    clause = margin if isinstance(margin, str) else ""
    results = [_judge(*pair, between, clause) for pair in zip(every, asked, strict=True)]
    if frequencies:
        if not isinstance(critical, Campbell) or callable(margin):
            raise OptionError(
                "separation: frequencies need the natural frequencies of a diagram, and one margin."
            )
        own = _margin_of(margin, 1.0, source, between)
        results += _judge_frequencies(critical, frequencies, own, between, clause)
    notes: list[str] = []
    if not every:
        first, last = (speed_unit().value(end) for end in searched[0])
        notes.append(f"no critical speed lies from {first:.6g} to {last:.6g} {speed_unit().unit}")
    if frequencies and isinstance(critical, Campbell) and np.ptp(critical.hertz, axis=0).any():
        notes.append(
            f"between the {len(critical.speeds)} speeds of the diagram natural frequencies are "
            "taken on lines"
        )
    return Verdict(tuple(sorted(results, key=lambda r: -r.utilisation)), tuple(notes))


def _margin_of(
    margin: float | str | Callable[[float], float],
    order: float,
    source: str,
    between: tuple[float, float],
) -> _Margin:
    if isinstance(margin, str):
        rule = _RULES[margin]
        if rule.is_about_rated and between[0] != between[1]:
            raise OptionError(
                f"separation: {margin} is about the rated speed; between = {between} must be that "
                "speed twice."
            )
        return rule
    share = margin(order) if callable(margin) else margin
    if not (isinstance(share, int | float) and 0 < share < 1):
        of_order = f" of order {order:g}" if callable(margin) else ""
        raise OptionError(f"separation: margin = {share}{of_order} must be between 0 and 1.")
    return _Margin(share, share, source)


def _check_reach(
    searched: list[tuple[float, float]], between: tuple[float, float], asked: list[_Margin]
) -> None:
    low, high = between
    below, above = max(each.below for each in asked), max(each.above for each in asked)
    first, last = low * (1 - below), high * (1 + above)
    for begin, end in searched:
        if begin > first or end < last:
            raise OptionError(
                f"separation: the diagram reaches from {begin:g} to {end:g} rad/s; speeds from "
                f"{low:g} to {high:g} rad/s with their margin need critical speeds from {first:g} "
                f"to {last:g}. Make the diagram over these."
            )


def _judge(
    each: CriticalSpeed, asked: _Margin, between: tuple[float, float], clause: str
) -> Result:
    low, high = between
    is_below = each.speed < low
    share = max(low - each.speed, each.speed - high, 0.0) / (low if is_below else high)
    least = asked.below if is_below else asked.above
    ends = BarredRange(each.speed / (1 + asked.above), each.speed / (1 - asked.below))
    what = f"mode {each.mode + 1}, {each.label or f'order {each.order:g}'}"
    beyond = () if share >= least else (ends,)
    return _row(what, clause, asked.source, share, least, each.speed, beyond)


def _judge_frequencies(
    diagram: Campbell,
    frequencies: Orders,
    asked: _Margin,
    between: tuple[float, float],
    clause: str,
) -> list[Result]:
    """How far each natural frequency in operation is from each frequency that excites."""
    named = (
        frequencies
        if isinstance(frequencies, Mapping)
        else {f"{hertz:g} Hz": hertz for hertz in frequencies}
    )
    inside = diagram.speeds[(diagram.speeds > between[0]) & (diagram.speeds < between[1])]
    speeds, found = np.unique([*between, *inside]), []
    for label, hertz in named.items():
        if not 0 < hertz < np.inf:
            raise OptionError(f"separation: frequency {hertz:g} Hz must be positive.")
        for mode, own in enumerate(diagram.hertz.T):
            apart = np.interp(speeds, diagram.speeds, own) / hertz - 1
            if np.isnan(apart).all():
                continue
            k = int(np.nanargmin(np.abs(apart)))
            meets = np.nanmin(apart) <= 0 <= np.nanmax(apart)
            share = 0.0 if meets else abs(float(apart[k]))
            least = asked.above if apart[k] > 0 else asked.below
            what = f"mode {mode + 1}, {label}"
            found.append(_row(what, clause, asked.source, share, least, float(speeds[k]), ()))
    return found


def _row(
    what: str,
    clause: str,
    source: str,
    share: float,
    least: float,
    speed: float,
    beyond: tuple[BarredRange, ...],
) -> Result:
    used = least / share if share else np.inf
    head = "separation", what, "1", "distance", clause, source
    return Result(*head, share, least, used, speed, beyond)
