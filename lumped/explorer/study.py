"""A drive whose parameters are moved, and its analyses for one set of values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import LumpedError, OptionError
from lumped.explorer.sliders import Slider, Wanted, slider, sliders
from lumped.points.start import start_point
from lumped.simulation.simulate import simulate
from lumped.support.units import read_time
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory
from lumped.vibration.natural.eigen_sensitivity import eigen_sensitivity
from lumped.vibration.natural.find_modes import modes
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_amplitudes import OrderAmplitudes
from lumped.vibration.responses.response import FrequencyResponse, frequency_response
from lumped.vibration.rules.limits import Limit
from lumped.vibration.speeds.campbell import Campbell

Values = dict[str, float]
"""Parameters that differ from the model, and those with sliders."""
Start = Changes | Callable[[Values], Changes | OperatingPoint]
"""Start values, or a function of the changed parameters that gives them, or the whole start."""
Analysis = Callable[[Values], Campbell | FrequencyResponse | OrderAmplitudes]
"""A function of the changed parameters that makes an analysis."""

_CURVES = 5
"""States that are shown, if nothing is named."""
_SLIDERS = 10
"""Sliders, if none are named."""
_LOWEST = 3
"""Lowest modes that decide which parameters these are."""
_SHARE = 1e-2
"""By which a parameter is changed to see its effect on the run."""
_GRID = 400
"""Intervals of output of a run."""
_FREQUENCIES = 16
"""Frequencies of a response beside those at the resonances."""
_BESIDE = np.array([-0.05, -0.012, -0.002, 0.002, 0.012, 0.05])
"""Relative distances from each natural frequency of those at its resonance."""


@dataclass(frozen=True)
class Study:
    """What the page shows of which drive.

    Attributes
    ----------
    system : System
        The drive, assembled once.
    base : dict of str to float
        Parameters that differ from the model, beside those with sliders.
    until : float or None
        End of the run, s, if there is one.
    start : mapping, or callable
        Start values, or a function that gives them or an operating point.
    of : tuple of str
        Quantities to show.
    inputs : tuple of str
        Inputs of a frequency response; none if it is empty.
    limits : tuple of Limit
        What quantities may reach.
    analyses : dict of str to callable
        Further analyses by their titles.
    """

    system: System
    base: Values = field(default_factory=dict)
    until: float | None = None
    start: Start = field(default_factory=dict)
    of: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    limits: tuple[Limit, ...] = ()
    analyses: dict[str, Analysis] = field(default_factory=dict)


class Moment:
    """The drive with some values of its parameters; what several pictures share is made once.

    Parameters
    ----------
    study : Study
        What is shown.
    values : dict of str to float
        Parameters that differ from the model.
    """

    def __init__(self, study: Study, values: Values) -> None:
        self.study, self.values = study, values
        self._analyses: dict[str, Campbell | FrequencyResponse | OrderAmplitudes] = {}

    @property
    def start(self) -> Changes:
        """Start values."""
        if isinstance(self._given, OperatingPoint):
            return dict(zip(self._given.system.state_names, self._given.x.tolist(), strict=True))
        return self._given

    @property
    def point(self) -> OperatingPoint:
        """The start, where the drive is linearised."""
        if isinstance(self._begun, Exception):
            raise self._begun
        return self._begun

    @cached_property
    def follows(self) -> Values:
        """Parameters that the start determines; none if there is no start."""
        if isinstance(self._begun, Exception):
            return {}
        names, given = self.study.system.parameters, self.study.system.theta(self.values)
        found = zip(names, given.tolist(), self._begun.theta.tolist(), strict=True)
        return {name: value for name, before, value in found if value != before}

    @property
    def parameters(self) -> Values:
        """The values, and those that the start determines."""
        return self.values | self.follows

    @cached_property
    def _given(self) -> Changes | OperatingPoint:
        start = self.study.start
        return start(dict(self.values)) if callable(start) else start

    @cached_property
    def _begun(self) -> OperatingPoint | Exception:
        """The start, or why there is none, which is not looked for twice."""
        system = self.study.system
        try:
            if not isinstance(self._given, OperatingPoint):
                return start_point(system, parameters=self.values, start=self._given)
            if self._given.system is not system:
                raise OptionError(
                    f"explore: start gave an operating point of {self._given.system.name}, not of "
                    "the system that is explored."
                )
        except Exception as fault:  # functions of the user may raise anything
            return fault
        return self._given

    @cached_property
    def modes(self) -> Modes:
        """Its modes there."""
        return modes(self.study.system, at=self.point)

    @cached_property
    def run(self) -> Trajectory:
        """Its run from the start."""
        assert self.study.until is not None
        return simulate(self.study.system, until=self.study.until, start=self.point, grid=_GRID)

    @cached_property
    def response(self) -> FrequencyResponse:
        """Its response to the inputs, up to above the fifth natural frequency."""
        hertz = self.modes.hertz[:5]
        top = 1.3 * hertz[-1] if len(hertz) else 100.0
        even = np.linspace(top / _FREQUENCIES, top, _FREQUENCIES)
        near = (hertz[:, None] * (1 + _BESIDE)).ravel()
        return frequency_response(
            self.study.system,
            inputs=self.study.inputs,
            outputs=self.study.of,
            hertz=np.unique(np.concatenate([even, near])),
            at=self.point,
        )

    def analysis(self, title: str) -> Campbell | FrequencyResponse | OrderAmplitudes:
        """One of the further analyses.

        Raises
        ------
        OptionError
            If the function gives something else.
        """
        if title in self._analyses:
            return self._analyses[title]
        found = self.study.analyses[title](self.parameters)
        if not isinstance(found, Campbell | FrequencyResponse | OrderAmplitudes):
            raise OptionError(
                f"explore: analyses['{title}'] gave a {type(found).__name__}; a Campbell diagram, "
                "a frequency response or an order response is needed."
            )
        return self._analyses.setdefault(title, found)


def read_end(until: float | str, who: str) -> float:
    """End of a run, s.

    Raises
    ------
    OptionError
        If it is no positive, finite time.
    """
    end = read_time(until, "until")
    if not end > 0:
        raise OptionError(f"{who}: until = {until!r} s: a positive, finite time is needed.")
    return end


def choose_quantities(system: System, wanted: Iterable[Name] | None) -> tuple[str, ...]:
    """Quantities to show; if nothing is named, the first states."""
    return tuple(map(system.key, system.state_names[:_CURVES] if wanted is None else wanted))


def choose_sliders(study: Study, wanted: Wanted | None) -> tuple[Slider, ...]:
    """Sliders that are named, or those of the most effective parameters."""
    if wanted is None:
        return most_effective(study)
    return sliders(study.system, study.system.theta(study.base), wanted)


def most_effective(study: Study) -> tuple[Slider, ...]:
    """Sliders of the parameters that change the lowest modes most, then the run.

    Parameters that are zero are left out: their relative effect is not known.
    """
    system, theta = study.system, study.system.theta(study.base)
    numbers = dict(zip(system.parameters, theta.tolist(), strict=True))
    scores = {name: 0.0 for name, value in numbers.items() if value}
    moment = Moment(study, study.base)
    for name, share in _effects_on_modes(moment).items():
        if name in scores:
            scores[name] = share
    chosen = _first(moment, scores, _SLIDERS)
    if len(chosen) < _SLIDERS and study.until is not None:
        others = [name for name in scores if name not in chosen]
        chosen += _first(moment, effects_on_run(moment, others), _SLIDERS - len(chosen))
    if not chosen:
        chosen = [*scores][:_SLIDERS] or [*numbers][:_SLIDERS]
    if not chosen:
        raise OptionError(f"{system.name}: explore: the model has no parameter to move.")
    order = [name for name in numbers if name in chosen]
    return tuple(slider(system, theta, name) for name in order)


def _first(moment: Moment, effects: Values, most: int) -> list[str]:
    """Parameters with the largest effects, without those that follow from the start."""
    every = moment.study.system.parameter_values(moment.values)
    found: list[str] = []
    for name in sorted(effects, key=lambda name: -effects[name]):
        if len(found) == most or effects[name] <= 1e-6:
            break
        moved = Moment(moment.study, moment.values | {name: every[name] * (1 + _SHARE)})
        if not callable(moment.study.start) or name not in moved.follows:
            found.append(name)
    return found


def _effects_on_modes(moment: Moment) -> Values:
    try:
        slopes = eigen_sensitivity(moment.modes)
    except LumpedError:
        return {}
    size = np.nan_to_num(np.abs(slopes.relative[:_LOWEST]))
    return dict(zip(slopes.by, size.max(axis=0, initial=0.0).tolist(), strict=True))


def effects_on_run(moment: Moment, names: Iterable[str]) -> Values:
    """Relative change of the quantities shown, for each relative change of a parameter.

    Root mean squares over the run; the largest of all quantities counts. Zero where the run with
    the changed parameter fails.
    """
    study = moment.study
    every = study.system.parameter_values(moment.values)
    here = _sample(moment.run, study.of)
    size = np.sqrt(np.mean(here**2, axis=0))
    found = {}
    for name in names:
        changed = Moment(study, moment.values | {name: every[name] * (1 + _SHARE)})
        try:
            off = np.sqrt(np.mean((_sample(changed.run, study.of) - here) ** 2, axis=0))
        except LumpedError:
            found[name] = 0.0
            continue
        found[name] = float((off / np.where(size > 0, size, 1.0)).max(initial=0.0) / _SHARE)
    return found


def _sample(run: Trajectory, names: Sequence[str]) -> np.ndarray:
    """Quantities at evenly spaced times, shape (n, len(names))."""
    times = np.linspace(run.t[0], run.t[-1], _GRID)
    return np.column_stack([np.interp(times, run.t, column) for column in run.table(names).T])
