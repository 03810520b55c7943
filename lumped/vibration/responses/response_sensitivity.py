"""How a frequency response changes with parameters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.points.moved_equilibrium import places_to
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.support.by_name import find_place
from lumped.support.display_units import frequency_unit
from lumped.support.ranking import list_largest
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.vibration.natural.matrix_slopes import contract, contraction, derive_at_point
from lumped.vibration.natural.spectrum import size_slopes
from lumped.vibration.responses.amplitudes import shift_matrix
from lumped.vibration.responses.response import FrequencyResponse


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
        place = find_place(self.response.system.key(parameter), self.by, "was not varied")
        return self.derivatives[:, row, column, place]

    @checked
    def magnitude(self, output: Name, input: Name, parameter: Name) -> Real:
        """Derivative of the magnitude, shape (k,)."""
        return size_slopes(self.response[output, input], self[output, input, parameter])

    def __repr__(self) -> str:
        point = self.response.point
        theta = point.theta[point.system.places(self.by)]
        rows, frequency = [], frequency_unit()
        for i, output in enumerate(self.response.outputs):
            for j, given in enumerate(self.response.inputs):
                amplitudes, hertz = self.response.values[:, i, j], self.response.hertz
                k = int(np.abs(amplitudes).argmax())
                most, shares = amplitudes[k], theta * 0
                if most:
                    shares = size_slopes(most, self.derivatives[k, i, j]) * theta / abs(most)
                text = list_largest(zip(self.by, shares, strict=True))
                rows.append((f"{output} / {given}", number(frequency.value(hertz[k])), text))
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
    m, q = len(response.inputs), len(response.outputs)
    left, right = _vectors(response, len(point.x), m, q)
    held = np.repeat(response.hertz > 0, q * m)
    thetas = np.repeat(np.c_[*map(response.matrices.theta, response.hertz)], q * m, axis=1)
    function = contraction(system, response.inputs, response.outputs)
    of_matrices = contract(function, point, thetas, left, right)

    def slopes(settings: Real) -> Complex:
        """Derivatives of the amplitudes; laws hold at the frequency, whatever parameters state."""
        found = of_matrices(settings)
        for place in system.structure.parameters.vibrating:
            found[held, len(point.x) + place] = 0
        return found

    found, moving = derive_at_point(point, names, places, slopes, np.ones(len(held)))
    values = found.reshape(len(response.hertz), q, m, len(places))
    return ResponseSensitivity(response, tuple(names), values, moving)


def _vectors(response: FrequencyResponse, n: int, m: int, q: int) -> tuple[Complex, Complex]:
    """Vectors ``(y, output)`` and ``(v, input)`` for each frequency, output and input."""
    hertz = response.hertz
    left = np.zeros((len(hertz), q, m, n + q), dtype=complex)
    right = np.zeros((len(hertz), q, m, n + m), dtype=complex)
    left[..., n:], right[..., n:] = np.eye(q)[:, None, :], np.eye(m)[None, :, :]
    for k, f in enumerate(hertz if n else ()):
        A, B, C, _ = response.matrices.at(f)
        factors = scipy.sparse.linalg.splu(shift_matrix(A, f))
        left[k, :, :, :n] = factors.solve(C.toarray().T.astype(complex), trans="T").T[:, None, :]
        right[k, :, :, :n] = factors.solve(B.toarray().astype(complex)).T[None, :, :]
    return left.reshape(-1, n + q).T, right.reshape(-1, n + m).T
