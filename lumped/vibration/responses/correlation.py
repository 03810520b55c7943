"""How well computed responses and shapes agree with measured ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumped.compiler.structure import Name
from lumped.errors import OptionError, shown
from lumped.plots.draw import Canvas, draw
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.support.display_units import Units, choose_units, frequency_unit
from lumped.vibration.pictures import frequency_response_picture
from lumped.vibration.responses.response import (
    FrequencyResponse,
    frequency_response,
    shown_response,
)

Amplitudes = NDArray[Any] | Sequence[Any]
"""Real or complex numbers."""


def _complex(function: str, given: Amplitudes) -> Complex:
    try:
        return np.asarray(given, dtype=complex)
    except (TypeError, ValueError):
        raise OptionError(
            f"{function}: {shown(given)} cannot be read as real or complex numbers."
        ) from None


@checked
def mac(shapes: Amplitudes, others: Amplitudes) -> Real:
    """Modal assurance criterion: 1 for shapes that differ by a factor only, 0 for orthogonal ones.

    ``|a^H b|^2 / ((a^H a) (b^H b))``, for each of the one and each of the other shapes.

    Parameters
    ----------
    shapes, others : array_like, shapes (n, k) and (n, m)
        Amplitudes at the same n places, one shape in each column; (n,) for a single one.

    Returns
    -------
    ndarray, shape (k, m)

    Raises
    ------
    OptionError
        If the places do not match, or a shape is zero or not finite.

    Notes
    -----
    Allemang and Brown, A correlation coefficient for modal vector analysis, IMAC 1, 1982.
    """
    a, b = (_complex("mac", s) for s in (shapes, others))
    a, b = (s[:, None] if s.ndim == 1 else s for s in (a, b))
    if a.ndim != 2 or b.ndim != 2 or len(a) != len(b):
        raise OptionError(
            f"mac: the shapes have the dimensions {a.shape} and {b.shape}; give columns of "
            "amplitudes at the same places."
        )
    sizes = [np.linalg.norm(s, axis=0) for s in (a, b)]
    if not all(np.isfinite(s).all() and (s > 0).all() for s in sizes):
        raise OptionError("mac: a shape is zero or not finite; leave it out.")
    (a, b) = (s / size for s, size in zip((a, b), sizes, strict=True))
    found: Real = np.abs(a.conj().T @ b) ** 2
    return found


@checked
def frac(measured: Amplitudes, computed: Amplitudes) -> float:
    """Frequency response assurance criterion: 1 for responses that differ by a factor only.

    ``|sum(a conj(b))|^2 / (sum|a|^2 sum|b|^2)`` over the frequencies of two curves.

    Parameters
    ----------
    measured, computed : array_like of complex, shape (k,)
        Responses at the same frequencies.

    Returns
    -------
    float

    Raises
    ------
    OptionError
        If the lengths do not match, or a response is zero or not finite.

    Notes
    -----
    Heylen and Lammens, FRAC: a consistent way of comparing frequency response functions, 1996.
    """
    a, b = (_complex("frac", curve) for curve in (measured, computed))
    sizes = [np.linalg.norm(curve) for curve in (a, b)]
    if a.ndim != 1 or a.shape != b.shape or not all(0 < size < np.inf for size in sizes):
        raise OptionError(
            f"frac: curves of {a.shape} and {b.shape} values; give as many finite values in each, "
            "not all zero."
        )
    return float(np.abs(np.vdot(a / sizes[0], b / sizes[1])) ** 2)


@dataclass(frozen=True, eq=False)
class ResponseComparison:
    """A measured and a computed response of an output to an input.

    Attributes
    ----------
    computed : FrequencyResponse
        At the frequencies of the measurement.
    output, input : str
        Names.
    measured : ndarray of complex, shape (k,)
        Measured values, in SI units.
    """

    computed: FrequencyResponse
    output: str
    input: str
    measured: Complex

    @property
    def frac(self) -> float:
        """Frequency response assurance criterion (see `frac`)."""
        return frac(self.measured, self.computed[self.output, self.input])

    def __repr__(self) -> str:
        hertz = self.computed.hertz
        return (
            f"{self.output} / {self.input}: {len(hertz)} frequencies from {hertz[0]:g} to "
            f"{hertz[-1]:g} Hz, FRAC {self.frac:.4f}"
        )

    @checked
    def plot(self, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Both responses over the frequency, magnitude and phase, with their FRAC.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend : {"matplotlib", "plotly"}
            What draws; plotly makes an interactive figure.
        ax : matplotlib Axes, or an array of as many as there are panels, optional
            Where matplotlib draws; default is a new figure, which needs no display.

        Returns
        -------
        matplotlib.figure.Figure or plotly.graph_objects.Figure

        Raises
        ------
        OptionError
            If plotly is not installed, or `ax` does not fit.
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        system = self.computed.system
        choice = choose_units(units, ("frequency", *system.names()))
        unit, factor = shown_response(system, self.output, self.input, choice)
        curves = {"measured": self.measured, "computed": self.computed[self.output, self.input]}
        drawn = {label: (factor * np.abs(y), np.unwrap(np.angle(y))) for label, y in curves.items()}
        picture = frequency_response_picture(
            f"{system.name}: {self.output} / {self.input}, FRAC {self.frac:.4f}",
            self.computed.hertz,
            {(self.output, unit): drawn},
            frequency_unit(choice),
            decibels=False,
        )
        return draw(picture, **canvas)


@checked
def compare_response(
    response: FrequencyResponse,
    *,
    output: Name,
    input: Name,
    hertz: ArrayLike,
    measured: Amplitudes,
) -> ResponseComparison:
    """A measured response beside the computed one, which is computed anew at its frequencies.

    Parameters
    ----------
    response : FrequencyResponse
        From `frequency_response`; its operating point is used.
    output, input : name
        What was measured.
    hertz : array_like, shape (k,)
        Frequencies of the measurement, ascending, Hz.
    measured : array_like of complex, shape (k,)
        Amplitude of the output for each unit of the input, in SI units.

    Returns
    -------
    ResponseComparison

    Raises
    ------
    OptionError
        If the lengths do not match, or the measured response is zero or not finite.
    UnknownNameError
        If an output or input does not exist.
    """
    y = _complex("compare_response", measured)
    system = response.system
    found = frequency_response(
        system, inputs=[input], outputs=[output], hertz=hertz, at=response.point
    )
    compared = ResponseComparison(found, found.outputs[0], found.inputs[0], y)
    if y.shape != found.hertz.shape or not 0 < np.linalg.norm(y) < np.inf:
        raise OptionError(
            f"compare_response: {y.shape} measured values at {len(found.hertz)} frequencies; give "
            "a finite value for each, not all zero."
        )
    return compared
