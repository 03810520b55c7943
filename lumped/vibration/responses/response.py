"""Complex response to sinusoidal inputs."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Unpack

import numpy as np
import scipy
from numpy.typing import ArrayLike

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, SolverError
from lumped.plots.draw import Canvas, draw
from lumped.points.control_systems import control_response
from lumped.points.linearise import Matrices, finite, growth, linear_matrices
from lumped.points.situation import one_sided, situation
from lumped.points.start import point_or_start
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.support.by_name import ByName, find_place
from lumped.support.display_units import Units, choose_units, display, frequency_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.validity import refuse_point_outside
from lumped.vibration.pictures import frequency_response_picture
from lumped.vibration.responses.amplitudes import Held, refuse_rates, shift_matrix, solve_responses

_STATIC = 1e-4
"""Fraction of the lowest frequency at which a response counts as static."""


@dataclass(frozen=True)
class Resonance:
    """A resonance.

    Attributes
    ----------
    hertz : float
        Frequency, Hz.
    magnitude : float
        Amplitude of the output for each unit of the input.
    """

    hertz: float
    magnitude: float


@dataclass(frozen=True, eq=False)
class FrequencyResponse(ByName, RichHtml):
    """Amplitudes of outputs for each unit of amplitude of inputs; ``response[output, input]``.

    Attributes
    ----------
    system : System
        What responds.
    hertz : ndarray, shape (k,)
        Frequencies, ascending, Hz.
    values : ndarray of complex, shape (k, outputs, inputs)
        Complex amplitudes for ``exp(j w t)``.
    inputs, outputs : tuple of str
        Names.
    point : OperatingPoint
        Where the system was linearised.
    """

    system: System
    hertz: Real
    values: Complex
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    point: OperatingPoint

    @cached_property
    def matrices(self) -> Held:
        """A, B, C and D at any frequency."""
        return Held(self.point, Matrices(self.point, self.inputs, self.outputs))

    @checked
    def __getitem__(self, names: tuple[Name, Name]) -> Complex:
        row, column = self._places(*names)
        return self.values[:, row, column]

    @cached_property
    def residual(self) -> float:
        """Largest backward error of the equations solved, ``|b - M x| / (|M| |x| + |b|)``."""
        worst = 0.0
        for f in self.hertz if len(self.system.state_names) else ():
            A, B, _, _ = self.matrices.at(f)
            M, right = shift_matrix(A, f), B.toarray()
            x = scipy.sparse.linalg.splu(M).solve(right.astype(complex))
            size = abs(M) @ np.abs(x) + np.abs(right)
            missed = np.abs(M @ x - right) / np.where(size > 0, size, 1.0)
            worst = max(worst, float(missed.max(initial=0.0)))
        return worst

    @checked
    def magnitude(self, output: Name, input: Name) -> Real:
        """Amplitude of an output for each unit of an input, shape (k,).

        Raises
        ------
        UnknownNameError
            If the response was not computed for this output and input.
        """
        found: Real = np.abs(self[output, input])
        return found

    @checked
    def phase(self, output: Name, input: Name) -> Real:
        """Phase by which an output leads an input, without jumps of a turn, rad, shape (k,)."""
        return np.unwrap(np.angle(self[output, input]))

    @checked
    def amplification(self, output: Name, input: Name) -> Real:
        """Magnitude relative to the static response, shape (k,).

        For the torque of a shaft this is its amplification factor under a torque that varies.

        Raises
        ------
        OptionError
            If there is no static response, because the output is zero or grows without bound
            towards 0 Hz, as the speed of a free drive does.
        """
        row, column = self._places(output, input)
        low = _STATIC * self.hertz[self.hertz > 0].min(initial=np.inf)
        if not np.isfinite(low):
            raise OptionError("amplification: analyse at least one frequency above 0 Hz.")
        lower, static = np.abs(
            solve_responses(self.matrices, [low / 10, low], self.system)[:, row, column]
        )
        if not static or abs(lower / static - 1) > 1e-3:
            raise OptionError(
                f"{self.system.name}: {self.outputs[row]} has no static response to "
                f"{self.inputs[column]}: it is {lower:.4g} at {low / 10:.3g} Hz and {static:.4g} "
                f"at {low:.3g} Hz. Take an output that settles, such as the torque of a shaft."
            )
        found: Real = np.abs(self.values[:, row, column]) / static
        return found

    @checked
    def peaks(self, output: Name, input: Name) -> tuple[Resonance, ...]:
        """Resonances, ascending; each is located between the frequencies beside it.

        A resonance narrower than the distance of the frequencies may be missed: analyse closer
        frequencies near those of `lumped.modes`.
        """
        row, column = self._places(output, input)
        size = np.abs(self.values[:, row, column])

        def height(hertz: float) -> float:
            return -float(
                np.abs(solve_responses(self.matrices, [hertz], self.system)[0, row, column])
            )

        found = []
        for k in np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1:
            bounds = (self.hertz[k - 1], self.hertz[k + 1])
            top = scipy.optimize.minimize_scalar(
                height, bounds=bounds, method="bounded", options={"xatol": 1e-9 * bounds[1]}
            )
            found.append(Resonance(float(top.x), -float(top.fun)))
        return tuple(found)

    @checked
    def plot(
        self,
        outputs: Iterable[Name] | None = None,
        *,
        decibels: bool = False,
        units: Units = None,
        **canvas: Unpack[Canvas],
    ) -> Any:
        """Magnitude and phase over the frequency, two panels for each output.

        Phases begin between -180 and 180 deg and go on without jumps. An output has panels of its
        own for each unit of the inputs.

        Parameters
        ----------
        outputs : iterable of names or references, optional
            Outputs to draw; default is all.
        decibels : bool
            Whether magnitudes are in dB, ``20 log10(magnitude)``, else on a logarithmic axis.
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        OptionError
            If no output is named.
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        system = self.system
        wanted = self.outputs if outputs is None else [system.key(name) for name in outputs]
        if not wanted:
            raise OptionError(f"{system.name}: name at least one output to draw.")
        choice = choose_units(units, ("frequency", *system.names()))
        drawn: dict[tuple[str, str], dict[str, tuple[Real, Real]]] = {}
        for output in wanted:
            for given in self.inputs:
                unit, factor = shown_response(system, output, given, choice)
                size = self.magnitude(output, given) * factor
                drawn.setdefault((output, unit), {})[given] = size, self.phase(output, given)
        picture = frequency_response_picture(
            system.name, self.hertz, drawn, frequency_unit(choice), decibels=decibels
        )
        return draw(picture, **canvas)

    def to_control(self) -> Any:
        """The same response for python-control; names have a slash for each dot.

        Returns
        -------
        control.FrequencyResponseData
            Its frequencies are in rad/s.

        Raises
        ------
        OptionError
            If a name has a slash, or the package is missing.
        """
        return control_response(
            self.system.name, self.hertz, self.values, self.inputs, self.outputs
        )

    def _names(self) -> list[tuple[str, str]]:
        return [*itertools.product(self.outputs, self.inputs)]

    def _places(self, output: Name, input: Name) -> tuple[int, int]:
        row = find_place(self.system.key(output), self.outputs, "is no output of this response")
        column = find_place(self.system.key(input), self.inputs, "is no input of this response")
        return row, column

    def __repr__(self) -> str:
        frequency = frequency_unit()
        low, high = (frequency.value(self.hertz[i]) for i in (0, -1))
        head = (
            f"{self.system.name}: response at {len(self.hertz)} frequencies from "
            f"{low:g} to {high:g} {frequency.unit}, a factorisation for each; residual "
            f"{self.residual:.1e}{situation(self.point)}"
        )
        if side := one_sided(self.point):
            head += f"\n{side}"
        rows = []
        for output in self.outputs:
            unit = self.system.quantity(output).unit
            for given in self.inputs:
                peaks = self.peaks(output, given)
                highest = max(peaks, key=lambda p: p.magnitude, default=None)
                at: tuple[str, ...] = ("-", "-")
                if highest is not None:
                    size, _ = amounts(output, unit, highest.magnitude, is_change=True)
                    at = number(frequency.value(highest.hertz)), size
                to_show = display(output, unit, is_change=True).unit
                rows.append((f"{output} / {given}", str(len(peaks)), *at, to_show))
        columns = (
            "output / input",
            "peaks",
            f"highest resonance, {frequency.unit}",
            "magnitude",
            "unit",
        )
        return f"{head}\n" + table(columns, rows)


@checked
def frequency_response(
    system: System,
    *,
    inputs: Iterable[Name],
    outputs: Iterable[Name],
    hertz: ArrayLike,
    at: OperatingPoint | None = None,
    parameters: Changes | None = None,
) -> FrequencyResponse:
    """Response of a linearised system to inputs that vary sinusoidally.

    ``C (j w - A)^-1 B + D`` by one sparse factorisation for each frequency.

    Parameters
    ----------
    system : System
        From `assemble`.
    inputs : iterable of names
        Parameters (or inputs given as numbers) that vary, such as a torque.
    outputs : iterable of names
        Quantities to observe.
    hertz : array_like, shape (k,)
        Frequencies, ascending, Hz.
    at : OperatingPoint, optional
        Where to linearise; default is the start point.
    parameters : mapping of name to float, optional
        Parameters to change, if `at` is not given.

    Returns
    -------
    FrequencyResponse

    Raises
    ------
    OptionError
        If frequencies are not ascending, or the rate of an input matters: the model holds
        parameters constant, so a prescribed angle has no speed.
    UnknownNameError
        If an input or output does not exist.
    SolverError
        If equations of a component do not hold at one of the frequencies, the response is
        unbounded there, or the linearisation is unstable (looked at up to 500 states).
    """
    at_hertz = np.asarray(hertz, dtype=float).ravel()
    if not len(at_hertz) or at_hertz[0] < 0 or (np.diff(at_hertz) <= 0).any():
        raise OptionError("frequency_response: hertz must be ascending and not negative.")
    point = finite(point_or_start("frequency_response", system, at, parameters))
    system = point.system
    matrices, given, observed = linear_matrices(system, point, inputs, outputs)
    if not given or not observed:
        raise OptionError("frequency_response: name at least one input and one output.")
    refuse_rates(system, given)
    faster, state = growth(system, point)
    if faster > 0:
        raise SolverError(
            f"{system.name}: the linearisation is unstable: a disturbance grows as "
            f"exp({faster:.4g} t), most in {state}, so no steady response is ever reached. Take a "
            "stable operating point, or add damping or control."
        )
    held = Held(point, matrices)
    for f in at_hertz[[0, -1]]:
        refuse_point_outside(replace(point, theta=held.theta(f)), f"at {f:.6g} Hz")
    values = solve_responses(held, at_hertz, system)
    return FrequencyResponse(system, at_hertz, values, given, observed, point)


def shown_response(system: System, output: str, given: str, units: Units) -> tuple[str, float]:
    """Unit in which a response is shown, that of the output over that of the input, and factor."""
    to_show = display(output, system.quantity(output).unit, units, is_change=True)
    by_input = display(given, system.parameter_unit(given), units, is_change=True)
    unit, by, factor = to_show.unit, by_input.unit, to_show.factor / by_input.factor
    if unit == by:
        return "", factor
    upper, lower = (f"({u})" if "/" in u or "." in u else u or "1" for u in (unit, by))
    return unit if lower == "1" else f"{upper}/{lower}", factor
