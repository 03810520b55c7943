"""Plain text tables."""

from __future__ import annotations

from collections.abc import Sequence

from lumped.support.display_units import Units, display


def list_names(names: Sequence[str], most: int = 6) -> str:
    """Names with commas; those beyond `most` are only counted."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def count_words(count: int, word: str) -> str:
    """A number of things, with an s where there are several."""
    return f"{count} {word}{'s' * (count != 1)}"


def list_lines(lines: Sequence[str], most: int) -> str:
    """Indented lines; those beyond `most` are only counted."""
    more = [f"... and {len(lines) - most} more"] if len(lines) > most else []
    return "\n".join(f"  {line}" for line in [*lines[:most], *more])


def number(value: float, digits: int = 6) -> str:
    """A number in few characters."""
    return f"{value:.{digits}g}"


def amounts(
    path: str,
    unit: str,
    *values: float,
    digits: int = 6,
    units: Units = None,
    is_change: bool = False,
) -> tuple[str, ...]:
    """Values of a quantity as they are shown, and their unit.

    Parameters
    ----------
    path, unit : str
        Name and SI unit of the quantity.
    *values : float
        In SI units.
    digits : int
        Of each number.
    units, is_change
        See `lumped.support.display_units.display`.
    """
    to_show = display(path, unit, units, is_change=is_change)
    return *(number(to_show.value(float(value)), digits) for value in values), to_show.unit


def format_comparison(
    published: float | None,
    computed: float,
    bounds: tuple[float | None, float | None] | None = None,
    fitted: bool = False,
) -> tuple[str, str, str]:
    """A published value, the computed one and the deviation, as texts.

    Parameters
    ----------
    published : float or None
        Value as published, with all its digits; None if there is none.
    computed : float
        Value of a model.
    bounds : (float or None, float or None), optional
        Least and greatest value, where a range was published instead of a value.
    fitted : bool
        Whether an unknown value was chosen so that both agree.

    Returns
    -------
    tuple of str
        Published, computed, and the deviation in per cent, or whether the range is met.
    """
    text_computed = number(computed)
    if bounds is not None:
        low, high = bounds
        met = (low is None or computed >= low) and (high is None or computed <= high)
        text, verdict = _range(low, high), "met" if met else "not met"
    elif published is not None:
        off = round(100 * (computed / published - 1), 2) + 0.0  # never "-0.00"
        text, verdict = number(published, 12), f"{off:+.2f}"
        text_computed = number(computed, max(6, len(text.strip("-").replace(".", ""))))
    else:
        return "-", text_computed, "-"
    return text, text_computed, verdict + ", fitted" * fitted


def _range(low: float | None, high: float | None) -> str:
    if low is None or high is None:
        return f"above {low:g}" if high is None else f"below {high:g}"
    return f"{low:g} to {high:g}"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns side by side; the first to the left, the others to the right."""
    widths = [max(len(str(row[i])) for row in (head, *rows)) for i in range(len(head))]
    lines = []
    for row in (head, ["-" * w for w in widths], *rows):
        cells = [str(row[0]).ljust(widths[0])]
        cells += [str(c).rjust(w) for c, w in zip(row[1:], widths[1:], strict=True)]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)
