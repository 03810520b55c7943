"""Parameters of a model, and what is out of range in one set of values or in many."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.errors import OptionError, ParameterError, UnknownNameError, nearest
from lumped.language.quantity import GREATER, Param, beyond, within
from lumped.support.array_function import ArrayFunction
from lumped.support.units import amount, plain

_RUNS = 10_000
"""Runs whose parameters are looked at together; the more, the more memory."""


class _Rules(NamedTuple):
    """What parameters must keep to, by arrays.

    Attributes
    ----------
    rows : ndarray of int, shape (k,)
        Numbers of the rules, ascending: those of `numbers`, then of `ordered`.
    numbers : ndarray of int, shape (r,)
        Parameters.
    least, most, nonzero : ndarray, shape (r,)
        Their ranges, and which must not be zero.
    ordered : ndarray of int, shape (k - r,)
        Numbers of lower limits that are expressions.
    highs, higher : ndarray of int, shape (k - r,)
        Parameters with these limits, and their places in `numbers`.
    strict : ndarray of bool, shape (k - r,)
        Whether the limit itself is out of range.
    """

    rows: np.ndarray
    numbers: np.ndarray
    least: np.ndarray
    most: np.ndarray
    nonzero: np.ndarray
    ordered: np.ndarray
    highs: np.ndarray
    higher: np.ndarray
    strict: np.ndarray


@dataclass(frozen=True, eq=False)
class Parameters:
    """Parameters of a flat model.

    Attributes
    ----------
    free : list of int
        Numbers of the parameters that have a value of their own (the others are bound).
    theta : SX, shape (free, 1)
        Their symbols.
    defaults : ndarray, shape (free,)
        Their values in the model.
    values : SX, shape (all, 1)
        Every parameter as an expression of `theta`.
    declared : list of Param
        Their declarations.
    names : list of str
        Their dotted names.
    ordered : list of (int, SX, str, (str, str))
        A parameter, its lower limit as an expression of `theta`, what that is called, and what
        follows its value in a text.
    """

    free: list[int]
    theta: ca.SX
    defaults: np.ndarray
    values: ca.SX
    declared: list[Param]
    names: list[str]
    ordered: list[tuple[int, ca.SX, str, tuple[str, str]]]

    @cached_property
    def numbers(self) -> np.ndarray:
        """Value of every parameter in the model, shape (all,)."""
        return self.all(self.defaults)

    @cached_property
    def _ruled(self) -> ca.SX:
        """Every parameter, then the lower limits in `ordered`."""
        return ca.vertcat(self.values, *(least for _, least, *_ in self.ordered))

    @cached_property
    def _ruled_function(self) -> ArrayFunction:
        return ArrayFunction(ca.Function("ruled", [self.theta], [ca.densify(self._ruled)]))

    @cached_property
    def free_names(self) -> list[str]:
        """Names of those that are free, in the order of `theta`."""
        return [self.names[number] for number in self.free]

    @cached_property
    def _places(self) -> dict[int, int]:
        return {number: i for i, number in enumerate(self.free)}

    @cached_property
    def _apart(self) -> set[int]:
        """Places in `theta` of parameters on which no other and no limit depends."""
        _, places = ca.jacobian_sparsity(self._ruled, self.theta).get_triplet()
        count = np.bincount(places, minlength=len(self.free))
        limited = {number for number, *_ in self.ordered}
        return {i for i, n in enumerate(self.free) if count[i] == 1 and n not in limited}

    @cached_property
    def _every_rule(self) -> _Rules:
        return self._rules(np.arange(len(self.declared) + len(self.ordered)))

    def _rules(self, rows: np.ndarray) -> _Rules:
        """Those of some rows of `_ruled`, ascending."""
        count = int(rows.searchsorted(len(self.declared)))
        numbers, ordered = rows[:count], rows[count:] - len(self.declared)
        own = [self.declared[i] for i in numbers]
        highs = self._highs[ordered]
        return _Rules(
            rows,
            numbers,
            np.array([quantity.least for quantity in own]),
            np.array([quantity.most for quantity in own]),
            np.array([quantity.nonzero for quantity in own], dtype=bool),
            ordered,
            highs,
            numbers.searchsorted(highs),
            np.array([self.declared[high].lower == GREATER for high in highs], dtype=bool),
        )

    @cached_property
    def _highs(self) -> np.ndarray:
        """Parameters whose lower limit is an expression."""
        return np.array([high for high, *_ in self.ordered], dtype=int)

    @cached_property
    def vibrating(self) -> list[int]:
        """Places in `theta` of the frequencies of vibration at which laws hold.

        Raises
        ------
        OptionError
            If one is bound to more than another parameter.
        """
        found = set[int]()
        for number, quantity in enumerate(self.declared):
            if not quantity.vibrates:
                continue
            value = self.values[number]
            if not value.is_symbolic():
                raise OptionError(
                    f"{self.names[number]} is the frequency of a vibration and bound to an "
                    "expression; bind it to a parameter alone, or give it a number."
                )
            found |= set(ca.jacobian_sparsity(value, self.theta).get_triplet()[1])
        return sorted(found)

    @cached_property
    def amplitudes(self) -> dict[int, str]:
        """Places in `theta` of amplitudes at which laws hold, and the quantities that have them.

        Raises
        ------
        OptionError
            If one is bound.
        """
        found = {}
        for number, quantity in enumerate(self.declared):
            if not quantity.amplitude_of:
                continue
            name = self.names[number]
            if number not in self._places:
                raise OptionError(
                    f"{name} is the amplitude of a vibration and bound to an expression; each "
                    "component has its own: give it a number."
                )
            path = name.rpartition(".")[0]
            found[self._places[number]] = f"{path}.{quantity.amplitude_of}".lstrip(".")
        return found

    def all(self, theta: np.ndarray) -> np.ndarray:
        """Every parameter, shape (all,), if those with a value of their own are `theta`."""
        return self._ruled_function(theta)[0][: len(self.declared)]

    def places(self, numbers: Iterable[int]) -> list[int]:
        """Places in `theta` of parameters that have a value of their own.

        Raises
        ------
        UnknownNameError
            If one is bound.
        """
        found = []
        for number in numbers:
            if number not in self._places:
                raise UnknownNameError(
                    f"'{self.names[number]}' is bound to an expression of other parameters and "
                    f"cannot be set. {nearest(self.names[number], self.free_names)}"
                )
            found.append(self._places[number])
        return found

    def change_values(self, changes: Mapping[int, float], model: str) -> np.ndarray:
        """Values of `theta` with some changed, by their places, and checked.

        Raises
        ------
        ParameterError
            If one is no number, or out of range.
        """
        theta, fits = self.defaults.copy(), True
        for place, value in changes.items():
            number = self.free[place]
            theta[place] = given = self.number(number, value)
            fits &= place in self._apart and self.declared[number].fault(given) is None
        if not fits:
            self.check(theta, model)
        return theta

    def number(self, number: int, value: object) -> float:
        """A value for a parameter, with a unit or without, as a number in its unit.

        Raises
        ------
        UnitError
            If its unit is of another dimension.
        ParameterError
            If it is no number.
        """
        unit, name = self.declared[number].unit, self.names[number]
        return plain(value, unit, f"{name} =", ParameterError)

    def check(self, theta: np.ndarray, model: str) -> None:
        """Refuse values out of range, all in one error.

        Raises
        ------
        ParameterError
            With path, value and unit of each.
        """
        found = self._ruled_function(theta)[0]
        faults = self._faults(found[None], self._every_rule)
        refuse_faults(model, [text for _, text, _ in faults])

    def outside(
        self, theta: np.ndarray, places: list[int], values: np.ndarray
    ) -> list[tuple[str, np.ndarray]]:
        """What is out of range in which of many runs, of all that depends on what varies.

        Parameters
        ----------
        theta : ndarray, shape (free,)
            Parameters of all runs, unless they vary.
        places : list of int
            Places in `theta` of those that vary, each once.
        values : ndarray, shape (n, len(places))
            Their values in each run.

        Returns
        -------
        list of (str, ndarray of int)
            What is wrong in the first of some runs, and the numbers of these runs.
        """
        varied = self.theta[places]
        touched = np.flatnonzero(ca.which_depends(self._ruled, varied, 1, True))
        highs, limits = self._highs, len(self.declared) + np.arange(len(self.ordered))
        both = np.isin(highs, touched) | np.isin(limits, touched)
        rules = self._rules(np.unique(np.concatenate([touched, highs[both], limits[both]])))
        mixed = ca.SX(ca.DM(theta))
        mixed[places] = varied
        asked = ca.substitute(self._ruled[rules.rows.tolist()], self.theta, mixed)
        one = ca.Function("one", [varied], [ca.densify(asked)])
        found: dict[int, tuple[str, list[np.ndarray]]] = {}
        for first in range(0, len(values), _RUNS):
            part = values[first : first + _RUNS]
            ruled = ArrayFunction(one.map(len(part)))(part.ravel())[0].reshape(len(part), -1)
            for rule, text, runs in self._faults(ruled, rules):
                found.setdefault(rule, (text, []))[1].append(first + runs)
        return [(found[rule][0], np.concatenate(found[rule][1])) for rule in sorted(found)]

    def _faults(self, ruled: np.ndarray, rules: _Rules) -> list[tuple[int, str, np.ndarray]]:
        """What is out of range: row, text of the first run, and the runs.

        Parameters
        ----------
        ruled : ndarray, shape (runs, rules)
            Values of these rows in each run.
        """
        count = len(rules.numbers)
        values, limits = ruled[:, :count], ruled[:, count:]
        fits = (values >= rules.least) & (values <= rules.most) & ~(rules.nonzero & (values == 0))
        if not within(values):
            fits &= np.reshape([beyond(v) is None for v in values.flat], values.shape)
        higher = values[:, rules.higher]
        low = (higher < limits) | (rules.strict & (higher == limits))
        if fits.all() and not low.any():
            return []
        wrong = np.hstack([~fits, low])
        self._leave_out_followers(wrong, rules)
        found = []
        for j in np.flatnonzero(wrong.any(axis=0)).tolist():
            runs = np.flatnonzero(wrong[:, j])
            if j < count:
                number = int(rules.numbers[j])
                text = self.fault(number, float(values[runs[0], j])) or ""
            else:
                text = self._order(
                    int(rules.ordered[j - count]),
                    *(float(part[runs[0], j - count]) for part in (higher, limits)),
                )
            found.append((int(rules.rows[j]), text, runs))
        return found

    def _leave_out_followers(self, wrong: np.ndarray, rules: _Rules) -> None:
        """Take out bound parameters that are out of range only as others are in the same run."""
        every = np.append(rules.numbers, rules.highs).tolist()
        for j in np.flatnonzero(wrong[:, : len(rules.numbers)].any(axis=0)).tolist():
            number = every[j]
            if number in self._places:
                continue
            for k in np.flatnonzero((wrong & wrong[:, [j]]).any(axis=0)).tolist():
                cause = self._places.get(every[k])
                if cause is not None and ca.depends_on(self.values[number], self.theta[cause]):
                    wrong[:, j] &= ~wrong[:, k]

    def _order(self, rule: int, high: float, limit: float) -> str:
        """Text that says that a value is below its limit."""
        number, _, name, (unit, text) = self.ordered[rule]
        quantity = self.declared[number]
        value = amount(high, quantity.unit)
        return (
            f"{self.names[number]} = {value} ({quantity.text}) must be {quantity.lower.words} "
            f"{name} = {amount(limit, unit)}{text}"
        )

    def fault(self, number: int, value: float) -> str | None:
        """Text that says why a value is out of range, or None if it is not."""
        quantity = self.declared[number]
        why = quantity.fault(value)
        if why is None:
            return None
        return f"{self.names[number]} = {amount(value, quantity.unit)} ({quantity.text}) {why}"


def refuse_faults(model: str, faults: list[str]) -> None:
    """Refuse the parameters of a model, with all that is wrong in one error."""
    if faults:
        count = "1 parameter fault" if len(faults) == 1 else f"{len(faults)} parameter faults"
        raise ParameterError(f"{model}: {count}:\n  " + "\n  ".join(faults))
