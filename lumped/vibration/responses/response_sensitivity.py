"""How a frequency response changes with parameters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.compiler.structure import Name
from lumped.errors import OptionError, UnknownNameError, nearest
from lumped.points.borders import refuse_kinks
from lumped.points.moved_equilibrium import find_moved_point, places_to, point_matters, still_point
from lumped.support.arguments import checked
from lumped.support.display_units import frequency_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.vibration.responses.response import FrequencyResponse

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class ResponseSensitivity(RichHtml):
    """Derivatives of complex amplitudes; ``found[output, input, parameter]`` is a curve.

    Attributes
    ----------
    response : FrequencyResponse
        What was derived.
    by : tuple of str
        Names.
    derivatives : ndarray of complex, shape (k, outputs, inputs, p)
        Derivatives, for each unit of the parameter.
    moving : bool
        The operating point is an equilibrium that moves with the parameters. If False, it is held.
    """

    response: FrequencyResponse
    by: tuple[str, ...]
    derivatives: Complex
    moving: bool

    @checked
    def __getitem__(self, names: tuple[Name, Name, Name]) -> Complex:
        output, given, parameter = names
        row, column = self.response._places(output, given)
        key = self.response.system.key(parameter)
        if key not in self.by:
            raise UnknownNameError(f"'{key}' was not varied. {nearest(key, self.by)}")
        found: Complex = self.derivatives[:, row, column, self.by.index(key)]
        return found

    @checked
    def magnitude(self, output: Name, input: Name, parameter: Name) -> Real:
        """Derivative of the magnitude, shape (k,)."""
        amplitude = self.response[output, input]
        along: Real = (amplitude.conj() * self[output, input, parameter]).real / np.abs(amplitude)
        return along

    def _magnitudes(self, k: int, row: int, column: int) -> Real:
        """Derivatives of a magnitude at one frequency, shape (p,)."""
        amplitude = self.response.values[k, row, column]
        along: Real = (np.conj(amplitude) * self.derivatives[k, row, column]).real / abs(amplitude)
        return along

    def __repr__(self) -> str:
        point, known = self.response.point, self.response.point.parameters
        theta = np.array([known[name] for name in self.by])
        rows, frequency = [], frequency_unit()
        for i, output in enumerate(self.response.outputs):
            for j, given in enumerate(self.response.inputs):
                curve = np.abs(self.response.values[:, i, j])
                k = int(curve.argmax())
                shares = self._magnitudes(k, i, j) * theta / curve[k] if curve[k] else theta * 0
                order = np.argsort(-np.abs(shares))[:4].tolist()
                text = "; ".join(f"{self.by[n]} {shares[n]:+.4f}" for n in order)
                rows.append(
                    (f"{output} / {given}", number(frequency.value(self.response.hertz[k])), text)
                )
        where = "moves with the parameters" if self.moving else "held, or without effect"
        head = (
            f"{point.system.name}: response by {len(self.by)} parameters, relative; "
            f"operating point: {where}; {len(self.response.hertz)} factorisations, residual "
            f"{self.response.residual:.1e}"
        )
        columns = ("output / input", f"largest at, {frequency.unit}", "magnitude there")
        return f"{head}\n" + table(columns, rows)


@checked
def response_sensitivity(
    response: FrequencyResponse, *, by: Iterable[Name] | None = None
) -> ResponseSensitivity:
    """Exact derivatives of a frequency response by parameters.

    With ``v = (j w - A)^-1 B`` and ``y^T = C (j w - A)^-1``, the derivative of
    ``C (j w - A)^-1 B + D`` is ``y^T (dA v + dB) + dC v + dD``: one reverse sweep for each
    frequency, output and input gives it for all parameters. If the operating point is an
    equilibrium, it moves with the parameters; else the states are held.

    Parameters
    ----------
    response : FrequencyResponse
        From `frequency_response`.
    by : iterable of names, optional
        Parameters; default is all that can be changed.

    Returns
    -------
    ResponseSensitivity

    Raises
    ------
    OptionError
        If `by` is empty.
    UnknownNameError
        If a parameter does not exist.
    SolverError
        If a derivative has two sides, as the point is exactly where a law changes its piece.
    """
    system, point = response.system, response.point
    names, places = places_to(point, by)
    if not names:
        raise OptionError("response_sensitivity: nothing to vary; name parameters in `by`.")
    n, m, q = len(system.state_names), len(response.inputs), len(response.outputs)
    left, right = _vectors(response, n, m, q)
    x, theta, _, _ = system.inputs
    u = theta[system.places(response.inputs)]
    observed = ca.vertcat(system.rates, system.expressions(response.outputs))
    y, v, e = ca.SX.sym("y", n + q), ca.SX.sym("v", n), ca.SX.sym("e", m)
    along = ca.jtimes(observed, x, v) + ca.jtimes(observed, u, e)
    slope = ca.densify(ca.gradient(ca.dot(y, along), ca.vertcat(x, theta)))
    function = ca.Function("contraction", [*system.inputs, y, ca.vertcat(v, e)], [slope])
    count = left.shape[1]
    thetas = [response.matrices.theta(f) for f in response.hertz]
    at = [np.repeat(np.c_[point.x], count, axis=1), np.repeat(np.c_[*thetas], q * m, axis=1)]
    call = function.map(count)

    def contract(a: Real, b: Real, settings: Real) -> Real:
        modes = np.repeat(np.c_[settings], count, axis=1)
        return np.asarray(call(*at, np.full((1, count), point.time), modes, a, b)).T

    def slopes(settings: Real) -> Complex:
        """Derivatives of the amplitudes by states and parameters."""
        real = contract(left.real, right.real, settings)
        real = real - contract(left.imag, right.imag, settings)
        imaginary = contract(left.real, right.imag, settings)
        imaginary = imaginary + contract(left.imag, right.real, settings)
        found = real + 1j * imaginary
        vibrating = [n + place for place in system.structure.parameters.vibrating]
        for place in vibrating:
            found[np.repeat(response.hertz > 0, q * m), place] = 0
        return found

    both = slopes(point.settings)
    moved = find_moved_point(point, places) if point_matters(point, both) else None
    moving = moved is not None
    moved = moved or still_point(point, places)
    refuse_kinks(point, moved, names, slopes)
    values = moved.through(both).reshape(len(response.hertz), q, m, len(places))
    return ResponseSensitivity(response, tuple(names), values, moving)


def _vectors(response: FrequencyResponse, n: int, m: int, q: int) -> tuple[Complex, Complex]:
    """Vectors ``(y, output)`` and ``(v, input)`` for each frequency, output and input."""
    hertz = response.hertz
    left = np.zeros((len(hertz), q, m, n + q), dtype=complex)
    right = np.zeros((len(hertz), q, m, n + m), dtype=complex)
    left[..., n:], right[..., n:] = np.eye(q)[:, None, :], np.eye(m)[None, :, :]
    for k, f in enumerate(hertz if n else ()):
        A, B, C, _ = response.matrices.at(f)
        factors = scipy.sparse.linalg.splu(
            scipy.sparse.csc_array(2j * np.pi * f * scipy.sparse.eye_array(n, format="csc") - A)
        )
        left[k, :, :, :n] = factors.solve(C.toarray().T.astype(complex), trans="T").T[:, None, :]
        right[k, :, :, :n] = factors.solve(B.toarray().astype(complex)).T[None, :, :]
    return left.reshape(-1, n + q).T, right.reshape(-1, n + m).T
