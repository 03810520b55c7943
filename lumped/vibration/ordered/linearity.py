"""How far a vibration stays in the ranges in which its linearisation and its equations hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import lcm

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.support.arrays import Complex, Real
from lumped.support.display_units import speed_unit
from lumped.support.made_once import made_once
from lumped.timeloop.plants.many_points import ManyPoints
from lumped.timeloop.results.validity import ranges
from lumped.vibration.ordered.order_solution import OrderSolution
from lumped.vibration.ordered.synthesis import Synthesis
from lumped.vibration.rotating.rotation import Rotation, find_settings
from lumped.vibration.rotating.small_vibrations import SmallVibrations, add_products

_POINTS = 16
"""Points for each period of the highest order."""
_FEWEST, _MOST = 256, 8192
_EVENLY = 8
"""Speeds that are looked at beside those at which quantities vibrate most."""
_TOLD = 0.05
"""Share of an amplitude from which on a note is due."""


@dataclass(frozen=True)
class Linearity:
    """What a vibration leaves out, where that is most.

    Attributes
    ----------
    speed : float
        Speed of the shaft, rad/s.
    of : str
        The quantity.
    order : float
        The order that changes most.
    share : float
        By how much of the largest amplitude of the quantity, if the equations are taken along the
        vibration as they are: one more step of the perturbation.
    states : tuple of str
        States whose vibration adds most to that, the largest first.
    released : dict of str to float
        Components that are taken to stick, be closed or rest against a stop, and would not along
        the vibration or in its mean, and the first speed, rad/s, at which.
    """

    speed: float
    of: str
    order: float
    share: float
    states: tuple[str, ...]
    released: dict[str, float]

    @property
    def note(self) -> str:
        """What to say of it; empty if it is small."""
        parts, speed = [], speed_unit()
        if self.share > _TOLD:
            parts.append(
                f"not linear: order {self.order:g} of {self.of} is wrong by about "
                f"{min(self.share, 9.99):.0%} at {speed.value(self.speed):.5g} {speed.unit}, as "
                f"{' and '.join(self.states)} vibrate{'s' * (len(self.states) == 1)} too far"
            )
        if self.released:
            told = ", ".join(
                f"{name} (from {speed.value(w):.5g} {speed.unit})"
                for name, w in self.released.items()
            )
            parts.append(f"what is held in the mean changes along the vibration: {told}")
        return "; ".join(parts)


def linearity(
    small: SmallVibrations,
    solution_at: Callable[[int], OrderSolution],
    speeds: Real,
    orders: Real,
    values: Complex,
) -> Linearity | None:
    """Take the equations along a vibration as they are, at the speeds where it is largest.

    None if they are linear, or the orders have no common cycle.

    Parameters
    ----------
    solution_at : callable
        Gives the solution at one of the speeds, by its number.
    values : ndarray of complex, shape (k, o, outputs)
        Amplitudes of the outputs.
    """
    system = small.system
    x = system.inputs[0]
    bent = any(ca.jacobian_sparsity(small.expressions[i], x).nnz() for i in (2, 4))
    if not bent and not system.switching.names:
        return None
    both = Synthesis("", "", speeds, orders, values[:, :, 0])
    if not both.has_cycle:
        return None
    cycle = lcm(solution_at(0).steady.turns, both.turns)
    count = len(speeds)
    chosen = set(np.linspace(0, count - 1, min(_EVENLY, count)).astype(int).tolist())
    chosen |= set(np.abs(values).sum(axis=1).argmax(axis=0).tolist())
    worst, shares, released = None, np.full((1, 1), -1.0), dict[str, float]()
    for k in sorted(chosen):
        here = _Along(solution_at(k), cycle)
        found = here.find_missing_shares()
        for name in here.find_released():
            released.setdefault(name, float(speeds[k]))
        if found.max() > shares.max():
            worst, shares = here, found
    assert worst is not None
    share = float(shares.max())
    order, output = (int(i) for i in np.unravel_index(int(shares.argmax()), shares.shape))
    return Linearity(
        float(worst.steady.speeds[0]),
        small.outputs[output],
        float(orders[order]),
        share,
        worst.causes(output, order) if share > _TOLD else (),
        released,
    )


class _Along:
    """The equations along a vibration at one speed."""

    def __init__(self, solved: OrderSolution, cycle: int) -> None:
        self.small, self.steady, self.orders = solved.small, solved.steady, solved.orders
        self.solved, steady, orders = solved, solved.steady, solved.orders
        samples = int(np.clip(_POINTS * cycle * orders.max(), _FEWEST, _MOST))
        self.angle = 2 * np.pi * cycle * np.arange(samples) / samples
        self.mean = steady.x[0] + self.angle[:, None] * steady.turning
        waves = np.exp(1j * self.angle[:, None] * orders)
        self.vibration: Real = (waves @ solved.x[0]).real
        self.slopes: Real = (waves @ (1j * solved.w[0][:, None] * solved.x[0])).real
        self.inputs: Real = (waves @ solved.u[0]).real
        self.waves = waves.conj() * (2 / samples)
        self.settings = self._settings_at(self.mean)
        self.rates, self.outputs, _ = self._at(self.mean)
        held = self.settings if steady.turns_matter else steady.settings
        mean = self.mean if steady.turns_matter else steady.x
        parts = solved.small(mean, steady.theta[0], held, steady.time)
        self.numbers = [part.mean(axis=0) for part in parts[2:]]

    def _settings_at(self, x: Real) -> Real:
        steady = self.steady
        given = steady.theta[0], steady.settings[0], steady.time
        return find_settings(steady.system, x, *given)

    def _at(self, x: Real) -> tuple[Real, Real, Real]:
        steady = self.steady
        found = self.small(x, steady.theta[0], self._settings_at(x), steady.time)
        return found.rates, found.outputs, found.M

    def _find_left_out(self, vibration: Real, slopes: Real) -> Complex:
        """Amplitudes of the outputs that a vibration has beside those that were computed."""
        rates, outputs, M = self._at(self.mean + vibration)
        rates, outputs = rates - self.rates, outputs - self.outputs
        a, _, c, _, m = self.small.patterns
        add_products(rates, m, self.numbers[4] - M, slopes)
        add_products(rates, a, -self.numbers[0], vibration)
        add_products(outputs, c, -self.numbers[2], vibration)
        missing = (self.waves.T @ rates)[..., None]
        moved = np.linalg.solve(self.solved.shifted_matrices()[0], missing)[..., 0]
        found: Complex = self.waves.T @ outputs
        add_products(found, c, self.solved.matrices[2][0], moved)
        return found

    def find_missing_shares(self) -> Real:
        """What is left out over the largest amplitude of each quantity, shape (o, outputs)."""
        size = np.abs(self.solved.y[0]).max(axis=0)
        left_out = self._find_left_out(self.vibration, self.slopes)
        return np.abs(left_out) / np.where(size > 0, size, np.inf)

    def causes(self, output: int, order: int) -> tuple[str, ...]:
        """States whose vibration, each alone, leaves out most of an amplitude."""
        parts = []
        for i in range(self.vibration.shape[1]):
            alone, slope = np.zeros_like(self.vibration), np.zeros_like(self.slopes)
            alone[:, i], slope[:, i] = self.vibration[:, i], self.slopes[:, i]
            parts.append(float(np.abs(self._find_left_out(alone, slope)[order, output])))
        names = self.steady.system.state_names
        largest = max(parts)
        return tuple(names[i] for i in np.argsort(parts)[::-1][:2] if parts[i] > 0.3 * largest)

    def find_released(self) -> list[str]:
        """Components whose holds do not last along the vibration."""
        switching = self.steady.system.switching
        if not switching.names:
            return []
        margins, rows = _margins(self.steady.system, self.small.inputs)
        time = np.full(len(self.angle), self.steady.time)
        theta = self.steady.theta[0]
        moved = np.hstack([self.mean + self.vibration, self.inputs])
        lost = (margins(moved, theta, time, self.settings) < 0).any(axis=0)
        return list(dict.fromkeys(switching.names[rows[i]] for i in np.flatnonzero(lost)))


@made_once
def _margins(system: System, inputs: tuple[str, ...]) -> tuple[ManyPoints, list[int]]:
    """What is negative as soon as a hold changes, beyond its tolerance, and which holds.

    Of states, followed by what is added to inputs.
    """
    margins, tolerances = system.switching.margins
    places = [i for i, (kind, _) in enumerate(system.switching.rows) if kind != "relation"]
    rows = [system.switching.rows[i][1] for i in places]
    found = system.structure.in_states((margins + tolerances)[places])
    x, theta, *others = system.inputs
    added = ca.SX.sym("added", len(inputs))
    if inputs:
        own = theta[system.places(inputs)]
        (found,) = ca.substitute([found], [own], [own + added])
    given = [ca.vertcat(x, added), theta, *others]
    return ManyPoints(ca.Function("margins", given, [ca.densify(found)])), rows


def refuse_vibration_outside(
    small: SmallVibrations,
    steady: Rotation,
    orders: Real,
    means: Real,
    amplitudes: Complex,
    at: Real,
) -> None:
    """Stop where equations do not hold.

    At a mean, at an extreme over the cycle, at a frequency, or at an amplitude of a law.

    Parameters
    ----------
    means : ndarray, shape (k, r)
        Means of what must lie in the ranges of the components, the last outputs of `small`.
    amplitudes : ndarray of complex, shape (k, o, r)
        Its amplitudes.
    at : ndarray, shape (k, m)
        Amplitudes at which laws hold.

    Raises
    ------
    SolverError
    """
    found = ranges(steady.system)
    if not found:
        return
    for i, held in enumerate(found):
        both = Synthesis("range", "1", steady.speeds, orders, amplitudes[:, :, i])
        high, low = both.sum, -both.sum  # as if all orders met in phase
        if both.has_cycle:
            (_, high), (_, low) = both.extremes
        for part, what in ((0.0, "in the mean"), (high, "with the vibration"), (low, "")):
            values = means[:, i] + part
            for k in np.flatnonzero(held.outside(values))[:1]:
                where = f"{what or 'with the vibration'} at {steady.speeds[k]:.6g} rad/s"
                raise held.make_error(float(values[k]), where)
    if not small.places:
        return
    time = steady.time
    ends = [(0, orders[0]), (len(steady.speeds) - 1, orders[-1])]
    places = [(int(k), orders[0], "with the vibration at") for k in at.argmax(axis=0)]
    places += [(k, order, f"for order {order:g} at") for k, order in ends]
    for k, order, which in places:
        w = small.at(order * steady.speeds[k : k + 1], at[k : k + 1])
        point = steady.x[k : k + 1], steady.theta[k], steady.settings[k : k + 1]
        values = small(*point, time, w).outputs[0, -len(found) :]
        for held, value in zip(found, values, strict=True):
            if held.outside(np.array([value]))[0]:
                where = f"{which} {steady.speeds[k]:.6g} rad/s"
                raise held.make_error(float(value), where)
