"""Units in which results are shown; inside, everything stays in SI units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager, ExitStack
from functools import cache
from typing import NamedTuple, TypeAlias, TypeVar

import numpy as np

from lumped.errors import OptionError, UnitError, UnknownNameError, nearest, shown
from lumped.support.known_units import measure
from lumped.support.units import convert_number

Units: TypeAlias = Mapping[str, str] | str | None
"""A preset, or the units to show by path, last name or SI unit; None is the session's choice."""

Value = TypeVar("Value", float, np.ndarray)

PRESETS: dict[str, dict[str, str]] = {
    "engineering": {
        "N.m": "kN.m",
        "N.m/rad": "kN.m/rad",
        "Pa": "MPa",
        "W": "kW",
        "rad": "deg",
        "rad/s": "1/min",
    },
}
"""What engineers read in calculations of drives, as `display_units` takes it by name."""

_SPEED = {("rad/s", "1/min"): "rpm"}
"""What a speed of rotation in 1/min means where it is shown."""


class Shown(NamedTuple):
    """A unit to show, and how a value in SI units becomes one in it.

    Parameters
    ----------
    unit : str
        To show.
    factor, offset : float
        A value shown is `factor` times the one in SI units, plus `offset`.
    """

    unit: str
    factor: float = 1.0
    offset: float = 0.0

    def value(self, si: Value) -> Value:
        """Values, in SI units, as they are shown."""
        if self.factor == 1.0 and not self.offset:
            return si
        return self.factor * si + self.offset


class _Choice(dict[str, str]):
    """A choice that was checked."""


class _Usual(_Choice):
    """A choice for the session: what fits a quantity counts, as names differ between models."""


class _Session:
    """What the session shows results in."""

    units = _Usual()


def display(
    path: str,
    unit: str,
    units: Units = None,
    *,
    usual: str | None = None,
    is_change: bool = False,
) -> Shown:
    """The unit in which a quantity is shown.

    Parameters
    ----------
    path : str
        Its name, such as ``"motor.w"``.
    unit : str
        Its SI unit.
    units : mapping of str to str, str or None
        See `display_units`; None is the choice of the session. A path goes before a last name,
        and a last name before an SI unit; the number ``"peak(motor.w)"`` answers to the names of
        its quantity too, if their unit fits. A key such as ``"s"``, which may be a name or a unit,
        is a unit where the unit to show is of its kind.
    usual : str, optional
        Unit to show if nothing is chosen for the quantity.
    is_change : bool
        Whether a difference or an amplitude is shown, which has no zero: one of temperatures stays
        in K.

    Returns
    -------
    Shown
        Unit, factor and offset.

    Raises
    ------
    UnitError
        If the unit to show is of another kind, unless the session chose it, or cannot be read.
    """
    choice = choose_units(units)
    wanted = usual or unit
    loose, inner = isinstance(choice, _Usual), _inner(path)
    named = [
        key
        for key in (path, _last(path), *inner)
        if key in choice
        and not _is_unit(key, choice[key])
        and (_fits(choice[key], unit) or not (loose or key in inner))
    ]
    if named:
        wanted = choice[named[0]]
    elif unit in choice and not (unit.isidentifier() and not _is_unit(unit, choice[unit])):
        wanted = choice[unit]
    factor, offset = _scale(wanted, unit, f"units: {path} ({unit}) cannot be shown in")
    return Shown(unit) if is_change and offset else Shown(wanted, factor, offset)


def _last(path: str) -> str:
    return path.rpartition(".")[2]


def _inner(path: str) -> tuple[str, ...]:
    """The quantity of a number such as ``peak(motor.tau, between 0 and 1)``, and its last name."""
    _, bracket, rest = path.partition("(")
    own = rest.rstrip(")").partition(",")[0]
    return (own, _last(own)) if bracket else ()


def speed_unit(units: Units = None) -> Shown:
    """How speeds of rotation over which something is shown are shown, usually in 1/min."""
    return display("speed", "rad/s", units, usual="1/min")


def frequency_unit(units: Units = None) -> Shown:
    """How frequencies of vibrations are shown."""
    return display("frequency", "Hz", units)


def time_unit(units: Units = None) -> Shown:
    """How instants are shown."""
    return display("time", "s", units)


def choose_units(
    units: Units, names: Iterable[str] | None = None, *, usual: str | None = None
) -> Mapping[str, str]:
    """A choice of units as a mapping.

    Parameters
    ----------
    units : mapping of str to str, str or None
        See `display_units`; None is the choice of the session.
    names : iterable of str, optional
        All names that a result shows. A key that is none of them, nor a unit, is refused.
    usual : str, optional
        Preset that counts if neither here nor for the session anything was chosen.

    Raises
    ------
    OptionError
        If it is no mapping of texts and no preset.
    UnitError
        If a unit cannot be read, or is of another kind than the unit for which it stands.
    UnknownNameError
        If a key is neither a unit nor a name of the result.
    """
    if isinstance(units, _Choice):
        return units
    if units is None:
        return _Session.units or _Choice(PRESETS[usual] if usual else {})
    if isinstance(units, str):
        if units not in PRESETS:
            raise OptionError(
                f"units = {units!r}: a mapping such as {{'rad/s': 'rpm'}} or the name of a preset "
                f"is needed: {', '.join(map(repr, PRESETS))}."
            )
        return _Choice(PRESETS[units])
    is_choice = isinstance(units, Mapping) and all(
        isinstance(key, str) and isinstance(unit, str) for key, unit in units.items()
    )
    if not is_choice:
        raise OptionError(
            f"units = {shown(units)}: a mapping of names or SI units to units to show is needed, "
            "such as {'rad/s': 'rpm', 'shaft.tau': 'kN.m'}."
        )
    if names is not None:
        _check_names(units, names)
    return _Choice(units)


def _check_names(units: Mapping[str, str], names: Iterable[str]) -> None:
    full: list[str] | None = None
    for key, unit in units.items():
        if _is_unit(key, unit):
            continue
        full = list(names) if full is None else full
        if any(key in (name, _last(name), *_inner(name)) for name in full):
            continue
        if _reads_as_si(key):
            _scale(unit, key, f"units: {key} cannot be shown in")
        raise UnknownNameError(
            f"units: {key!r} is neither an SI unit nor a name of this result. {nearest(key, full)}"
        )


def _reads_as_si(key: str) -> bool:
    known = measure(key)
    return known is not None and known.is_si


def _is_unit(key: str, unit: str) -> bool:
    """Whether a key is an SI unit, for which a unit to show can stand."""
    return _reads_as_si(key) and _fits(unit, key)


@cache
def _fits(wanted: str, unit: str) -> bool:
    try:
        _factors(wanted, unit)
    except UnitError:
        return False
    return True


def _scale(wanted: str, unit: str, said: str) -> tuple[float, float]:
    """Factor and offset from a unit to the one to show; an error begins with `said`."""
    try:
        return _factors(wanted, unit)
    except UnitError as fault:
        raise UnitError(f"{said} {fault}") from None


@cache
def _factors(wanted: str, unit: str) -> tuple[float, float]:
    if wanted == unit:
        return 1.0, 0.0
    if not unit:
        raise UnitError(f"{wanted!r}: in which unit it is, is not known.")
    meant = _SPEED.get((unit, wanted), wanted)
    zero, one = (convert_number(size, meant, unit, repr(wanted)) for size in (0.0, 1.0))
    return 1 / (one - zero), -zero / (one - zero) + 0.0  # never -0.0


def display_units(units: Units) -> AbstractContextManager[object]:
    """Choose the units in which results are shown from now on.

    Tables, plots and reports follow it unless they are given `units` themselves. Numbers that are
    read from results, such as ``run["motor.w"]``, stay in SI units.

    Parameters
    ----------
    units : mapping of str to str, str or None
        Units to show. Keys are paths such as ``"motor.w"``, last names such as ``"w"`` and SI units
        such as ``"rad/s"``; the first of these that is given counts. ``"engineering"`` is
        ``{"N.m": "kN.m", "N.m/rad": "kN.m/rad", "Pa": "MPa", "W": "kW", "rad": "deg",
        "rad/s": "1/min"}``, where 1/min is a speed of rotation. None is SI units. A name whose unit
        is of another kind in some model is left in SI units there, and as the choice holds for all
        models of a session, a path that a model does not have is not refused.

    Returns
    -------
    context manager
        At whose end the former choice holds again; to be used or not.

    Raises
    ------
    OptionError
        If it is no mapping of texts and no preset.
    UnitError
        If a unit cannot be read, or is of another kind than the SI unit for which it stands.
    """
    choice = _Usual() if units is None else _Usual(choose_units(units))
    for key, unit in choice.items():
        if _reads_as_si(key) and not key.isidentifier():
            _scale(unit, key, f"display_units: {key} cannot be shown in")
        elif not _is_unit(key, unit):
            _check_readable(key, unit)
    former = ExitStack()
    former.callback(setattr, _Session, "units", _Session.units)
    _Session.units = choice
    return former


def _check_readable(key: str, unit: str) -> None:
    """Refuse a text that is no unit at all."""
    try:
        convert_number(1.0, unit, "1", f"display_units: {key} cannot be shown in {unit!r}")
    except UnitError as fault:
        if "of the kind" not in str(fault):
            raise
