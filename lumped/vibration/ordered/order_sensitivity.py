"""How the vibration of a drive that turns changes with parameters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.points.moved_equilibrium import places_to
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.support.by_name import ByName, find_place
from lumped.support.display_units import display, speed_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.vibration.ordered.order_amplitudes import OrderAmplitudes
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.ordered.order_solution import OrderSolution, synthesis_of
from lumped.vibration.ordered.synthesis import Synthesis
from lumped.vibration.rotating.harmonics import derive_by_parameters, sweep_turns
from lumped.vibration.rotating.small_vibrations import Parts
from lumped.vibration.rotating.turns import turns_of

OrderMeasure = Literal["maximum", "half range", "sum"] | float
"""Of a synthesis, or the order whose amplitude is meant."""


@dataclass(frozen=True, eq=False)
class OrderSensitivity(ByName, RichHtml):
    """Derivatives of a measure of a vibration by parameters; ``found[parameter]``.

    Attributes
    ----------
    of, measure : str
        What was derived.
    unit : str
        Its unit.
    speed : float
        Where, rad/s.
    value : float
        The measure there.
    by : tuple of str
        Names.
    derivatives : ndarray, shape (p,)
        Derivatives, for each unit of the parameter.
    relative : ndarray, shape (p,)
        Relative change of the measure for a relative change of the parameter.
    """

    of: str
    measure: str
    unit: str
    speed: float
    value: float
    by: tuple[str, ...]
    derivatives: Real
    relative: Real

    @checked
    def __getitem__(self, parameter: str) -> float:
        return float(self.derivatives[find_place(parameter, self.by, "was not varied")])

    def _names(self) -> tuple[str, ...]:
        return self.by

    def __repr__(self) -> str:
        to_show, speed = display(self.of, self.unit, is_change=True), speed_unit()
        head = (
            f"{self.measure} of {self.of} at {speed.value(self.speed):.6g} {speed.unit}: "
            f"{to_show.value(self.value):.6g} {to_show.unit}; by {len(self.by)} parameters"
        )
        order = np.argsort(-np.abs(self.relative), kind="stable")[:20].tolist()
        rows = [
            (self.by[i], number(to_show.value(self.derivatives[i])), f"{self.relative[i]:+.4f}")
            for i in order
        ]
        columns = ("parameter", f"derivative, {to_show.unit} for each unit", "relative")
        return f"{head}\n" + table(columns, rows)


@checked
def order_sensitivity(
    response: OrderResponse,
    of: Name,
    *,
    measure: OrderMeasure = "half range",
    speed: float | None = None,
    by: Iterable[Name] | None = None,
) -> OrderSensitivity:
    """Exact derivatives of a vibration by parameters.

    One solution with the transposed matrices for each order, and one reverse sweep over the turns,
    give the derivatives by all parameters: those of excitations that follow from the model, of the
    matrices, and of the steady rotation itself where parameters move it.

    Parameters
    ----------
    response : OrderResponse
        From `order_response`.
    of : name
        A quantity that it observes.
    measure : {"maximum", "half range", "sum"} or float
        Of the synthesis, or the order whose amplitude is meant.
    speed : float, optional
        One of the speeds of the response, rad/s; default is where the measure is largest.
    by : iterable of names, optional
        Parameters; default is all that can be changed.

    Returns
    -------
    OrderSensitivity

    Raises
    ------
    OptionError
        If the speed was not computed, or the measure has no derivative, as it is zero.
    UnknownNameError
        If a name does not exist.
    """
    refuse_ratio(response, "order_sensitivity")
    row = response._place(of)
    key = response.of[row]
    sizes = sizes_of(response, key, measure)
    k = int(sizes.argmax()) if speed is None else response.number_of(speed, "order_sensitivity")
    names, places = find_varied_places(response, by)
    slope = slope_of(response, key, k, measure)[places]
    value, theta = float(sizes[k]), response.rotation.theta[k, places]
    return OrderSensitivity(
        key,
        measure if isinstance(measure, str) else f"order {measure:g}",
        response.system.quantity(key).unit,
        float(response.speeds[k]),
        value,
        tuple(names),
        slope,
        slope * theta / value,
    )


def find_varied_places(
    response: OrderResponse, by: Iterable[Name] | None
) -> tuple[list[str], list[int]]:
    """Names and places of parameters by which to derive; default is all that do not follow.

    Raises
    ------
    OptionError
        If one balances the mean torques.
    """
    names, places = places_to(response.rotation.points[0], by)
    balancing = response.rotation.balancing
    if by is None and balancing is not None:
        places.pop(names.index(balancing))
        names.remove(balancing)
    if balancing in names:
        raise OptionError(
            f"{response.system.name}: {balancing} is free and follows from the "
            "others; leave it out of `by`."
        )
    return names, places


def refuse_ratio(response: OrderResponse, caller: str) -> None:
    """Refuse damping of which no parameter of the drive knows."""
    if response.damping_ratio:
        raise OptionError(
            f"{caller}: a damping ratio of all modes is no parameter of the drive; give its parts "
            "their dampers or loss factors."
        )


def sizes_of(response: OrderAmplitudes, of: str, measure: OrderMeasure) -> Real:
    """The measure at each speed."""
    if isinstance(measure, str):
        return response.synthesis(of).measure(measure)
    return response.magnitude(of, measure)


def _weights(both: Synthesis, k: int, measure: OrderMeasure) -> Complex:
    """Weights of the amplitudes in the measure: its change is ``Re sum(weight change)``."""
    y, orders = both.amplitudes[k], both.orders
    if isinstance(measure, str) and measure != "sum":
        (high, top), (low, bottom) = both.extremes
        peaks = [np.exp(1j * orders * at) for at in (high[k], low[k])]
        upper = measure == "half range" or top[k] >= -bottom[k]
        lower = measure == "half range" or not upper
        weights: Complex = upper * peaks[0] - lower * peaks[1]
        return 0.5 * weights if measure == "half range" else weights
    size = np.abs(y)
    found = np.where(size > 0, y.conj() / np.where(size > 0, size, 1.0), 0)
    if not isinstance(measure, str):
        chosen = np.isclose(orders, measure, rtol=1e-12, atol=0)
        if not size[chosen].any():
            raise OptionError(
                f"order_sensitivity: order {measure:g} of {both.name} is zero at "
                f"{both.speeds[k]:g} rad/s; its amplitude has no derivative there."
            )
        found[~chosen] = 0
    return found


def slope_of(response: OrderResponse, of: str, k: int, measure: OrderMeasure) -> Real:
    """Derivatives of the measure at a speed by all parameters, shape (p,).

    Where laws hold at amplitudes A that follow from the vibration, ``A = h(A, p)``, the measure
    ``m(A, p)`` changes by ``m_p + m_A (1 - h_A)^-1 h_p``.
    """
    at_speed = _AtSpeed(response, k)
    weights = _weights(response.synthesis(of), k, measure)
    slope, by_amplitude = at_speed.slopes(response._place(of), weights)
    if not len(by_amplitude):
        return slope
    rows = [at_speed.law_slopes(i) for i in range(len(by_amplitude))]
    follow, own = (np.array(part) for part in zip(*rows, strict=True))
    return slope + by_amplitude @ np.linalg.solve(np.eye(len(own)) - own, follow)


class _AtSpeed:
    """Derivatives of the vibration at one speed, with laws at amplitudes that stay."""

    def __init__(self, response: OrderResponse, k: int) -> None:
        self.solved = response.solution_at(k)
        self.amplitudes = response._laws_at[k : k + 1]
        self.first = len(response.of)

    def law_slopes(self, number: int) -> tuple[Real, Real]:
        """Derivatives of the amplitude that counts for a law."""
        row = self.first + number
        both, measure = synthesis_of(self.solved, row)
        return self.slopes(row, _weights(both, 0, measure))

    def slopes(self, row: int, weights: Complex) -> tuple[Real, Real]:
        """Derivatives of a weighted sum of the amplitudes of a quantity.

        By all parameters, shape (p,), and by the amplitudes of laws, (m,).
        """
        solved, small, orders = self.solved, self.solved.small, self.solved.orders
        steady, x, u, w = solved.steady, solved.x[0], solved.u[0], solved.w[0]
        count = len(orders)
        left = weights[:, None] * _adjoint(solved, row)
        direct = np.zeros((count, len(small.outputs)), dtype=complex)
        direct[:, row] = weights
        by_order = [
            (side[:, rows] * given[:, columns]).real
            for side, given, (rows, columns) in zip(
                (left, left, direct, direct, left),
                (x, u, x, u, -1j * w[:, None] * x),
                small.patterns,
                strict=True,
            )
        ]
        turns = turns_of(small, steady, 0, orders)
        turning = np.zeros((len(turns.x), count), dtype=complex)
        if steady.turns_matter:
            whole = np.abs(orders * steady.turns - np.rint(orders * steady.turns)) <= 1e-9
            turning[:, whole] = turns.waves(orders[whole]).T
        own = [(turning @ left).real, (turning @ direct).real]
        slope_x, slope = sweep_turns(
            small, steady, turns, own, [part.sum(axis=0) for part in by_order]
        )
        by_amplitude = np.zeros(self.amplitudes.shape[1])
        if small.places:
            still = [np.zeros(left.shape), np.zeros(direct.shape)]
            again = [np.repeat(part, count, axis=0) for part in (steady.x, steady.settings)]
            theta, time = steady.theta[0], steady.time
            at = small.at(w, np.repeat(self.amplitudes, count, axis=0))
            for sign, vibration in ((1.0, at), (-1.0, None)):
                part = Parts(*still, *(sign * numbers for numbers in by_order))
                more = small.slopes(part, again[0], theta, again[1], time, vibration)
                slope_x, slope = slope_x + more[0].sum(axis=0), slope + more[1].sum(axis=0)
                by_amplitude = by_amplitude + more[2].sum(axis=0)
        return slope + derive_by_parameters(steady, slope_x), by_amplitude


def _adjoint(solved: OrderSolution, row: int) -> Complex:
    """Solutions of ``(j w M - A)^T y = C[row]`` at each order of one speed, shape (o, n)."""
    rows, columns = solved.small.patterns[2]
    chosen = rows == row
    right = np.zeros(solved.x[0].shape, dtype=complex)
    right[:, columns[chosen]] = solved.matrices[2][0][:, chosen]
    matrices = solved.shifted_matrices()[0].swapaxes(1, 2)
    return np.linalg.solve(matrices, right[..., None])[..., 0]
