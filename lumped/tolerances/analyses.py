"""Functionals of runs, modes and order responses at many values of parameters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from lumped.compiler.system import System
from lumped.ensembles.ensemble import RunsAt
from lumped.errors import LumpedError, OptionError, SolverError, UnknownNameError
from lumped.functionals import Functional
from lumped.functionals.readings import (
    Clearance,
    Damping,
    Frequency,
    OrderPeak,
    Reading,
    Separation,
)
from lumped.gradients.gradient_ensemble import gradients_at
from lumped.support.arrays import Real
from lumped.timeloop.run_options import RunPlan
from lumped.tolerances.evaluated import Evaluated, Evaluation, OfReadings
from lumped.vibration.natural.eigen_sensitivity import eigen_sensitivity
from lumped.vibration.natural.find_modes import modes
from lumped.vibration.natural.mode_designs import ManyModes, ModeDesigns, ModesOfMany
from lumped.vibration.natural.modes import Modes
from lumped.vibration.natural.spectrum import damping_slopes, hertz_slopes, second_derivatives
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.ordered.order_sensitivity import slope_of
from lumped.vibration.speeds.mean_campbell import critical_sensitivity
from lumped.vibration.speeds.mean_spectrum import MeanSpectrum
from lumped.vibration.speeds.order_designs import OrderDesigns


class OfOrders(OfReadings):
    """Functionals of order responses (see `Evaluated`).

    Parameters
    ----------
    begin : OrderResponse
        That of the nominal drive.
    names : tuple of str
        What varies.
    of : mapping of str to functional
    analysis : str
        With which errors begin.
    """

    def __init__(
        self,
        begin: OrderResponse,
        names: tuple[str, ...],
        of: Mapping[str, Functional],
        analysis: str,
    ) -> None:
        super().__init__(begin.system, names, of)
        self._base = begin.rotation.points[0].parameters
        self._designs = OrderDesigns(begin, analysis)
        self._designs.refuse_balancing(list(names), "over")
        self._own = begin.system.places(names)
        peaks = [reading for reading in self._readings if isinstance(reading, OrderPeak)]
        tops = [self._designs.top(reading, begin)[1].speeds for reading in peaks]
        notes = begin.tell_notes(np.concatenate(tops)) if tops else ()
        self.notes = tuple(f"nominal design: {note}" for note in notes)

    def _read_alone(self, row: Real, with_slopes: bool) -> tuple[Real, Real]:
        values = dict(zip(self._names, row.tolist(), strict=True))
        found = self._designs.response(self._base | values)
        pairs = [self._value(reading, found, with_slopes) for reading in self._readings]
        slopes = np.array([slope for _, slope in pairs])
        return np.array([value for value, _ in pairs]), slopes[:, : None if with_slopes else 0]

    def _value(self, wanted: Reading, found: OrderResponse, with_slope: bool) -> tuple[float, Real]:
        none = np.zeros(len(self._names))
        if isinstance(wanted, OrderPeak):
            value, top = self._designs.top(wanted, found)
            if not with_slope:
                return value, none
            by = slope_of(top, self._system.key(wanted.name), 0, wanted.measure)
            return value, by[self._own]
        if isinstance(wanted, Separation):
            away, critical = self._designs.nearest(wanted, found)
            if not with_slope or critical is None or not away:
                return away, none
            low, high = wanted.between
            side = -1 / low if critical.speed < low else 1 / high
            by = critical_sensitivity(found, critical, by=self._names).derivatives
            return away, side * by
        spectrum = MeanSpectrum(found.small, found.rotation.at(0), found.orders)
        value = value_of_modes(wanted, spectrum.hertz, spectrum.damping)
        if not with_slope:
            return value, none
        chosen, side = slope_of_modes(wanted, spectrum.hertz)
        slope = spectrum.damping_by if isinstance(wanted, Damping) else spectrum.hertz_by
        return value, side * slope(chosen)[self._own]


class OfModes(OfReadings):
    """Functionals of modes (see `Evaluated`).

    Parameters
    ----------
    begin : Modes
        Those of the nominal drive.
    names : tuple of str
        What varies.
    of : mapping of str to functional
    analysis : str
        With which errors begin.
    """

    def __init__(
        self, begin: Modes, names: tuple[str, ...], of: Mapping[str, Functional], analysis: str
    ) -> None:
        super().__init__(begin.system, names, of)
        self._count, self._base = len(begin.hertz), begin.point.parameters
        self._designs = ModeDesigns(begin)
        self._many = ModesOfMany(self._designs, names)
        for reading in self._readings:
            if isinstance(reading, Frequency | Damping) and not 0 <= reading.mode < self._count:
                raise OptionError(
                    f"{analysis}: {reading}: the modes are 0 to {self._count - 1}, counted from "
                    "the lowest."
                )
            if isinstance(reading, Clearance) and not (
                reading.excitations and min(reading.excitations) > 0
            ):
                raise OptionError(f"{analysis}: {reading}: give positive frequencies in Hz.")

    def _read_together(self, x: Real, found: Evaluation) -> None:
        if not self._many.applies:
            return
        many = self._many.modes(x)
        for k, wanted in enumerate(self._readings):
            found.values[:, k] = _values(wanted, many.hertz, many.damping)
            if not found.slopes.shape[2]:
                continue
            mode, side = _mode_of(wanted, many.hertz)
            for own in np.unique(mode):
                mine = mode == own
                part = ManyModes(many.eigenvalues[mine])
                slopes = self._many.slopes(x[mine], part, [int(own)])
                through = damping_slopes if isinstance(wanted, Damping) else hertz_slopes
                slope = through(part.eigenvalues[:, [own]], slopes)[:, 0]
                found.slopes[mine, k] = side[mine, None] * slope

    def _curvatures(self, x: Real) -> Real | None:
        """Second derivatives of modes whose state matrix depends on parameters alone."""
        if not self._many.applies:
            return None
        found, hertz = [], self._many.modes(x[None]).hertz[0]
        for wanted in self._readings:
            mode, side = slope_of_modes(wanted, hertz)
            own = self._many.curvatures(x, mode)
            if own is None:
                return None
            found.append(side * second_derivatives(*own, of_damping=isinstance(wanted, Damping)))
        return np.array(found)

    def _read_alone(self, row: Real, with_slopes: bool) -> tuple[Real, Real]:
        found = self._modes(row)
        values = [value_of_modes(f, found.hertz, found.damping) for f in self._readings]
        if not with_slopes:
            return np.array(values), np.zeros((len(values), 0))
        by = eigen_sensitivity(found, by=self._names)
        slopes = []
        for wanted in self._readings:
            mode, side = slope_of_modes(wanted, found.hertz)
            if mode in by.repeated:
                raise SolverError(
                    f"{self._system.name}: mode {mode} ({found.hertz[mode]:.6g} Hz) coincides with "
                    "another and has no derivative.",
                    None,
                )
            own = by.damping if isinstance(wanted, Damping) else by.hertz
            slopes.append(side * own[mode])
        return np.array(values), np.array(slopes)

    def _modes(self, row: Real) -> Modes:
        values = self._base | dict(zip(self._names, row.tolist(), strict=True))
        found = modes(self._system, at=self._designs.point(values))
        if len(found.hertz) != self._count:
            raise SolverError(
                f"{self._system.name}: there are {len(found.hertz)} oscillating modes instead of "
                f"{self._count}: one became a decay or the reverse.",
                None,
            )
        return found


def value_of_modes(wanted: Reading, hertz: Real, damping: Real) -> float:
    """A functional of natural frequencies, Hz, and damping ratios, both of shape (m,)."""
    return float(_values(wanted, hertz[None], damping[None])[0])


def slope_of_modes(wanted: Reading, hertz: Real) -> tuple[int, float]:
    """The mode by whose frequency, or damping ratio, a functional changes, and how fast."""
    mode, side = _mode_of(wanted, hertz[None])
    return int(mode[0]), float(side[0])


def _values(wanted: Reading, hertz: Real, damping: Real) -> Real:
    """A functional of many designs, whose modes have the shape (n, m)."""
    if isinstance(wanted, Clearance):
        found: Real = np.abs(_away(wanted, hertz)).min(axis=(1, 2))
        return found
    assert isinstance(wanted, Frequency | Damping)
    return (hertz if isinstance(wanted, Frequency) else damping)[:, wanted.mode]


def _mode_of(wanted: Reading, hertz: Real) -> tuple[NDArray[np.intp], Real]:
    """The mode by which a functional changes, and how fast, of many designs."""
    n = len(hertz)
    if isinstance(wanted, Frequency | Damping):
        return np.full(n, wanted.mode), np.ones(n)
    assert isinstance(wanted, Clearance)
    away = _away(wanted, hertz).reshape(n, -1)
    nearest = np.abs(away).argmin(axis=1)
    mode, number = np.divmod(nearest, len(wanted.excitations))
    return mode, np.sign(away[np.arange(n), nearest]) / np.array(wanted.excitations)[number]


def _away(wanted: Clearance, hertz: Real) -> Real:
    """Relative distances of modes from excitations, shape (n, modes, excitations)."""
    found: Real = hertz[:, :, None] / np.array(wanted.excitations) - 1
    return found


class OfRuns(Evaluated):
    """Functionals of runs, in the time loop and on all cores (see `Evaluated`).

    Parameters
    ----------
    system : System
    names : tuple of str
        What varies.
    of : mapping of str to functional
    plan : RunPlan
        Options of each run.
    workers : int or None
    analysis : str
        With which errors begin.
    """

    def __init__(
        self,
        system: System,
        names: tuple[str, ...],
        of: Mapping[str, Functional],
        plan: RunPlan,
        workers: int | None,
        analysis: str,
    ) -> None:
        super().__init__(system, names, of)
        self._plan, self._workers, self._analysis = plan, workers, analysis
        self.error = plan.rtol
        self._runs = RunsAt(system, names, of, plan, workers)

    def evaluate(self, x: Real, with_slopes: bool) -> Evaluation:
        """Functionals of all runs, and derivatives by the adjoint if they are asked for.

        Raises
        ------
        OptionError
            If a functional has no derivative.
        """
        unknown = Evaluation.unknown(len(x), len(self._of), with_slopes * x.shape[1])
        if not with_slopes:
            values, failures = self._runs(x)
            return unknown._replace(values=values, failures=failures)
        for label, wanted in self._of.items():
            if not all(reading.smooth for reading in wanted.readings):
                raise OptionError(
                    f"{self._analysis}: {label} has no derivative: numbers of events jump. Take a "
                    "method of samples."
                )
        of, plan = tuple(self._of.values()), self._plan
        try:
            found = gradients_at(self._system, self._names, x, of, self._names, plan, self._workers)
        except (OptionError, UnknownNameError):
            raise
        except LumpedError as error:
            return unknown._replace(failures=dict.fromkeys(range(len(x)), str(error)))
        return Evaluation(found.values, found.derivatives, found.failures)
