"""Parameters of each of many runs: listed, in a grid, or drawn from distributions."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NoReturn, get_args

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.ensembles.distributions import Correlated, Paired
from lumped.ensembles.laws import Law, Parameter, law_of
from lumped.ensembles.other_laws import distribution_of, is_distribution
from lumped.errors import OptionError, ParameterError, shown
from lumped.language.quantity import NONZERO, Param
from lumped.support.arrays import Real
from lumped.support.units import amount, has_unit

if TYPE_CHECKING:
    Over = Mapping[Name, Any] | Iterable[Mapping[Name, Any]] | Paired | Correlated
else:
    Over = Any  # looked at here: `checked` takes seconds for the mappings of 100 000 runs
Column = list[Any] | Real
"""Values of one parameter."""
Sampling = Literal["random", "latin", "sobol", "halton"]

_PLAIN = {float, int, np.float64, np.int64}
"""Types of numbers that need no look at each."""
_ENGINES = {"latin": "LatinHypercube", "sobol": "Sobol", "halton": "Halton"}
_STEPS = {"sobol": 2.0**-30}
"""Steps in which points come; those of the others are steps of rounding."""
_RISK = 1e-12
"""Probability of a value out of range that is as good as none."""
_ADVICE = "Cut a distribution off with lumped.distributions.truncated(distribution, low, high)."


@dataclass(frozen=True, eq=False)
class ParameterSets:
    """Parameters of many runs.

    Attributes
    ----------
    names : tuple of str
        What varies.
    values : ndarray, shape (n, len(names))
        Its values in each run, in SI units.
    shape : tuple of int
        That of the grid; ``(n,)`` if there is none.
    """

    names: tuple[str, ...]
    values: Real
    shape: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Marginals:
    """Distributions of parameters in numbers, and how they depend on each other.

    Attributes
    ----------
    names : tuple of str
        Of the d parameters.
    laws : tuple of Law
        Of each.
    mixing : ndarray, shape (d, d)
        Dependent standard normal variables from independent ones.
    """

    names: tuple[str, ...]
    laws: tuple[Law, ...]
    mixing: Real

    def values(self, u: Real) -> tuple[Real, Real]:
        """Parameters for independent standard normal numbers, and their derivatives by these.

        Parameters
        ----------
        u : ndarray, shape (n, d)

        Returns
        -------
        ndarray, shapes (n, d) and (n, d, d)
        """
        mixed = u @ self.mixing.T
        pairs = [law.at_score(mixed[:, j]) for j, law in enumerate(self.laws)]
        values = np.column_stack([value for value, _ in pairs])
        slopes = np.column_stack([slope for _, slope in pairs])
        return values, slopes[:, :, None] * self.mixing


def marginals_of(
    system: System, over: Over, *, parameters: Changes | None = None, analysis: str
) -> Marginals:
    """Distributions of what varies, checked as `variants_of` does.

    Raises
    ------
    OptionError
        If `over` has no distribution of each parameter.
    """
    asked = _ParameterReader(system, parameters or {}, analysis)
    given: Any = over.distributions if isinstance(over, Correlated) else over
    if not (isinstance(given, Mapping) and given and asked.is_drawn(given)):
        asked.refuse(
            f"over = {shown(over)}: a distribution of each parameter is needed, such as "
            "{'shaft.c': lumped.normal(100.0, 5.0)}."
        )
    laws = asked.laws(given)
    mixing = over.mixing if isinstance(over, Correlated) else np.eye(len(laws))
    return Marginals(tuple(system.key(name) for name in given), tuple(laws), mixing)


def variants_of(
    system: System,
    over: Over,
    *,
    runs: int | None = None,
    seed: int = 0,
    sampling: Sampling = "random",
    parameters: Changes | None = None,
    analysis: str = "ensemble",
) -> ParameterSets:
    """Parameters of each run, all checked.

    Drawn values are quantiles of probabilities ``u``, shape (runs, k), of the k parameters in
    their order. For ``"random"`` these are ``numpy.random.default_rng(seed).random((runs, k))``.

    Parameters
    ----------
    system : System
        From `assemble`.
    over : mapping, iterable of mappings, or what `paired` and `correlated` give
        What varies. Sequences of values for each parameter make a grid, of which the last varies
        fastest; from a distribution for each parameter, or `correlated` ones, runs are drawn;
        mappings and `paired` sequences give the parameters of each run. Values are numbers in SI
        units or texts such as ``"2 deg"``.
    runs : int, optional
        How many runs are drawn.
    seed : int
        Of the numbers drawn; the same seed gives the same numbers.
    sampling : {"random", "latin", "sobol", "halton"}
        Independent numbers, Latin hypercube, scrambled Sobol or scrambled Halton points. The last
        three fill the ranges more evenly; with correlation only that of the first parameter.
    parameters : mapping of name to float, optional
        Changes that hold in all runs, unless varied.
    analysis : str
        With which errors begin.

    Returns
    -------
    ParameterSets

    Raises
    ------
    OptionError
        If there is nothing to vary, the runs do not follow from what is given, or a distribution
        is none.
    UnknownNameError
        If a parameter does not exist.
    UnitError
        If a value has a unit of another dimension.
    ParameterError
        If a value is no number or out of range, or a distribution is out of range with a
        probability above 1e-12.
    """
    asked = _ParameterReader(system, parameters or {}, analysis)
    if isinstance(over, Correlated) or (isinstance(over, Mapping) and asked.is_drawn(over)):
        given = over.distributions if isinstance(over, Correlated) else over
        laws = asked.laws(given)
        u = probabilities(runs, len(laws), seed, sampling, analysis)
        if isinstance(over, Correlated):
            u = over.couple(u)
        columns = [law.quantile(u[:, j]) for j, law in enumerate(laws)]
        return asked.variants(given, columns, advice=_ADVICE)
    if runs is not None or sampling != "random":
        option = f"sampling = {shown(sampling)}" if runs is None else f"runs = {shown(runs)}"
        asked.refuse(f"{option} is for distributions, but over gives the values of all runs.")
    if isinstance(over, Mapping):
        axes = asked.columns({name: _flat(values) for name, values in over.items()})
        columns = [part.ravel() for part in np.meshgrid(*axes, indexing="ij")]
        return asked.variants(over, columns, shape=tuple(len(axis) for axis in axes))
    columns_given = asked.pairs(over.values) if isinstance(over, Paired) else asked.rows(over)
    return asked.variants(columns_given, asked.columns(columns_given))


class _ParameterReader:
    """Makes numbers of what is given for one system, and checks them.

    Parameters
    ----------
    system, parameters, analysis
        See `variants_of`.
    """

    def __init__(self, system: System, parameters: Changes, analysis: str) -> None:
        self.system, self.analysis = system, analysis
        self.parameters = system.structure.parameters
        self.theta = fill_parameters(system, parameters)

    def refuse(self, text: str) -> NoReturn:
        raise OptionError(f"{self.analysis}: {text}")

    def refuse_values(self, faults: Sequence[str], advice: str) -> None:
        if faults:
            count = "1 parameter fault" if len(faults) == 1 else f"{len(faults)} parameter faults"
            lines = [f"{self.analysis}: {count}:", *faults, *([advice] if advice else [])]
            raise ParameterError("\n  ".join(lines))

    def places(self, names: Iterable[Name]) -> list[int]:
        """Places of parameters that are named, each once."""
        keys, places = [self.system.key(name) for name in names], self.system.places(names)
        for i, place in enumerate(places):
            if place in places[:i]:
                self.refuse(f"{keys[i]} is named twice in over. Give it once.")
        return places

    def variants(
        self,
        names: Iterable[Name],
        columns: Sequence[Real],
        *,
        shape: tuple[int, ...] | None = None,
        advice: str = "",
    ) -> ParameterSets:
        """Values of parameters, column by column, if they are in range."""
        if not columns or not len(columns[0]):
            self.refuse("there is nothing to vary; give values of at least one parameter.")
        places, values = self.places(names), np.column_stack(columns)
        faults = []
        for text, runs in self.parameters.outside(self.theta, places, values):
            where = f"run {runs[0]}" + (f" and {len(runs) - 1} more" if len(runs) > 1 else "")
            faults.append(f"{text}: {where} of {len(values)} runs")
        self.refuse_values(faults, advice)
        self.theta[places] = values[0]
        self.parameters.check(self.theta, self.system.name)
        keys = tuple(self.system.key(name) for name in names)
        return ParameterSets(keys, values, shape or (len(values),))

    # -- values --------------------------------------------------------------------------------

    def columns(self, given: Mapping[Name, Column]) -> list[Real]:
        """Values of parameters as numbers in SI units."""
        places = zip(self.places(given), given.values(), strict=True)
        return [self._numbers(self.parameters.free[place], values) for place, values in places]

    def _numbers(self, number: int, values: Column) -> Real:
        if isinstance(values, np.ndarray) or _PLAIN.issuperset(map(type, values)):
            with suppress(OverflowError):  # of whole numbers, which is refused below
                return np.array(values, dtype=float)
        return np.array([self.parameters.number(number, value) for value in values])

    def pairs(self, given: Mapping[Name, Any]) -> dict[Name, Column]:
        """Values of parameters, run by run, equally many of each."""
        drawn = [self.system.key(name) for name, value in given.items() if is_distribution(value)]
        if drawn:
            self.refuse(
                f"lumped.distributions.paired takes values, but {drawn[0]} has a distribution. "
                "Give distributions without it, one for each parameter."
            )
        found = {name: _flat(values) for name, values in given.items()}
        if len({len(values) for values in found.values()}) > 1:
            counts = [f"{self.system.key(name)} has {len(v)}" for name, v in found.items()]
            self.refuse(
                f"paired parameters need equally many values, but {', '.join(counts)}. Give what "
                "all runs share as parameters={...}."
            )
        return found

    def rows(self, given: Any) -> dict[Name, Column]:
        """Values of parameters that are given run by run."""
        if isinstance(given, str) or not isinstance(given, Iterable):
            self.refuse(
                f"over = {shown(given)}: what varies is needed, such as "
                "{'shaft.c': [100.0, 200.0]}."
            )
        rows: list[Mapping[Name, Any]] = list(given)
        for i, row in enumerate(rows):
            if not isinstance(row, Mapping):
                self.refuse(
                    f"over[{i}] = {shown(row)}: the parameters of run {i} are needed, such as "
                    "{'shaft.c': 100.0}."
                )
        if any(row.keys() != rows[0].keys() for row in rows):
            keys = [[self.system.key(name) for name in row] for row in rows]
            for i, names in enumerate(keys):
                if {*names} != {*keys[0]} or len(names) != len({*names}):
                    self.refuse(
                        f"each run must name the same parameters, once; run 0 names "
                        f"{', '.join(keys[0])}, run {i} {', '.join(names)}."
                    )
            rows = [dict(zip(n, r.values(), strict=True)) for n, r in zip(keys, rows, strict=True)]
        return {name: [row[name] for row in rows] for name in (rows[0] if rows else {})}

    # -- distributions -------------------------------------------------------------------------

    def is_drawn(self, over: Mapping[Name, Any]) -> bool:
        """Whether a mapping has distributions, for all of its parameters then."""
        drawn, listed = (
            [
                self.system.key(name)
                for name, value in over.items()
                if is_distribution(value) is kind
            ]
            for kind in (True, False)
        )
        if drawn and listed:
            self.refuse(
                f"over has distributions (of {', '.join(drawn)}) and values (of "
                f"{', '.join(listed)}). Give distributions of all, or values of all that belong "
                "together by lumped.distributions.paired."
            )
        return bool(drawn)

    def laws(self, given: Mapping[Name, Any]) -> list[Law]:
        """Distributions in numbers, if their values are in range."""
        laws, faults = [], []
        for place, (name, value) in zip(self.places(given), given.items(), strict=True):
            quantity = self.parameters.declared[self.parameters.free[place]]
            label = f"{self.analysis}: {self.system.key(name)}"
            parameter = Parameter(label, quantity.unit, float(self.theta[place]))
            law = law_of(distribution_of(value, f"{label} ="), parameter)
            risk = law.below(quantity.least) + law.above(quantity.most)
            if not risk <= _RISK:
                faults.append(
                    f"{self.system.key(name)} ({quantity.text}) must be {_range(quantity)}; its "
                    f"distribution has other values with a probability of {risk:.3g}"
                )
            laws.append(law)
        self.refuse_values(faults, _ADVICE)
        return laws


def probabilities(runs: int | None, count: int, seed: int, sampling: str, analysis: str) -> Real:
    """Random numbers between zero and one, both excluded, shape (runs, count).

    Raises
    ------
    OptionError
        If an option makes no sense; the text begins with `analysis`.
    """
    if not isinstance(runs, int | np.integer) or isinstance(runs, bool) or runs < 1:
        raise OptionError(
            f"{analysis}: runs = {shown(runs)}: how many runs to draw is needed, such as runs=1000."
        )
    if not isinstance(seed, int | np.integer) or isinstance(seed, bool) or seed < 0:
        raise OptionError(
            f"{analysis}: seed = {shown(seed)}: a whole number is needed, zero or more."
        )
    if sampling not in get_args(Sampling):
        known = ", ".join(map(repr, get_args(Sampling)))
        raise OptionError(f"{analysis}: sampling = {shown(sampling)}: one of {known} is needed.")
    random = np.random.default_rng(seed)
    if sampling == "random" or not count:
        u = random.random((runs, count))
    else:
        engine = getattr(scipy.stats.qmc, _ENGINES[sampling])
        named = "rng" if "rng" in inspect.signature(engine).parameters else "seed"
        points = engine(count, **{named: random})
        if sampling == "sobol":  # asked for another number, it warns
            u = points.random_base2(int(runs - 1).bit_length())[:runs]
        else:
            u = points.random(runs)
    return np.clip(u, _STEPS.get(sampling, 2.0**-53) / 2, 1 - 2.0**-53)


def _flat(values: Any) -> Column:
    """Values for a parameter as a list or an array of numbers, in the order of their rows."""
    if isinstance(values, str):
        return [values]
    if has_unit(values):
        return list(values.ravel()) if np.ndim(values.magnitude) else [values]
    if isinstance(values, np.ndarray) and values.dtype.kind in "iuf":
        return values.ravel()
    return list(np.ravel(np.asarray(values, dtype=object)))


def _range(quantity: Param) -> str:
    """Range of a parameter, where its ends are numbers."""
    found = [f"{b.words} {amount(b.limit, quantity.unit)}" for b in quantity.bounds if b != NONZERO]
    return " and ".join(found) or "a finite number"


def fill_parameters(system: System, parameters: Changes | None) -> Real:
    """All parameters as they are unless varied; the runs are checked one by one."""
    changes, p = parameters or {}, system.structure.parameters
    theta: Real = p.defaults.copy()
    for place, value in zip(system.places(changes), changes.values(), strict=True):
        theta[place] = p.number(p.free[place], value)
    return theta
