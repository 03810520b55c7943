"""What the published numbers of the pilger mill LG90 tell: bounds on its speed, what they fix."""

from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq, linprog, minimize

import lumped as lp
from lumped.components import Position
from lumped.models.pilger_mill import stand
from lumped.models.pilger_mill.stand import AsPrinted, Mill

IDLE = 1 - stand.IDLE
L, L1 = stand.ROD, stand.ROD_1


@cache
def per_mass(step: float = 1.0) -> np.ndarray:
    """Inertia torque over w^2 for 1 kg of stand, counterweight, rod of either; crank angles."""
    w = stand.SPEED["P"]
    system = stand.turn_mill(stand.mill("P"), w * lp.time)
    run = stand.revolution(system, w, np.arange(0.0, 360.0, step))
    v, v1, turn, turn1 = (
        run[f"mill.{part}.{rate}"] * run[f"mill.{part}.{course}"] / w**3
        for rate, course in (("v", "a"), ("w_rod", "a_rod"))
        for part in ("stand", "weight")
    )
    return np.array([v, v1, 2 * stand.SLENDER * L**2 * turn, 2 * stand.SLENDER * L1**2 * turn1])


RANGES = [(0, None), (7142, None), (0, 3000), (0, 3000)]
"""kg: any stand, the published counterweight, rods of up to 3 t."""


def rpm(w: float) -> float:
    return w * 30 / np.pi


class TestBounds:
    """Whatever the masses, and whatever rolling torque acts against the motion."""

    def test_greatest_and_swinging_torque_bound_the_speed(self):
        """The least of both over w^2 for any stand."""
        columns = per_mass(0.25)
        ones, none = np.ones(columns.shape[1]), np.zeros(columns.shape[1])
        above, below = np.vstack([columns, -ones, none]), np.vstack([-columns, none, ones])
        bounds = [*RANGES, (None, None), (None, None)]
        swings = linprog(
            [0, 0, 0, 0, 1, -1], np.hstack([above, below]).T, [*none, *none], bounds=bounds
        )
        peaks = linprog([0, 0, 0, 0, 1, 0], above.T, none, bounds=bounds)
        assert abs(rpm(np.cbrt(510e3 * IDLE / peaks.fun)) - 90.0) < 0.11
        assert abs(rpm(np.sqrt(84439.48 * IDLE / swings.fun)) - 75.1) < 0.15

    def test_rms_power_bounds_the_speed_from_above(self):
        """B3: the load that helps most takes what the inertia gives back, and nothing else."""
        columns = per_mass()

        def mean_square(masses):
            driving = np.maximum(masses @ columns, 0.0)
            return (driving**2).mean() / 1e4, 2 * (columns * driving).mean(1) / 1e4

        start = np.array([9000.0, 8000.0, 1000.0, 1000.0])
        found = minimize(
            mean_square, start, jac=True, bounds=RANGES, options={"ftol": 1e-15, "gtol": 1e-9}
        )
        received = rpm(np.cbrt(510e3 * IDLE / np.sqrt(1e4 * found.fun)))
        assert abs(received - 121.6) < 0.1

    def test_swing_and_mean_power_bound_the_speed_from_above(self):
        """B4: the greatest torque is that of the inertia at least, mean and swing at most."""
        columns = per_mass()
        n = columns.shape[1]
        peak = linprog(
            [0, 0, 0, 0, 1],
            A_ub=np.hstack([columns.T, -np.ones((n, 1))]),
            b_ub=np.zeros(n),
            bounds=[*RANGES, (None, None)],
        ).fun
        # peak w^2 / IDLE = 510e3 / w + 84439.48
        w = max(np.roots([peak / IDLE, 0.0, -84439.48, -510e3]).real)
        received = rpm(w)
        assert abs(received - 134.3) < 0.1
        # a load that fills the valleys of the torque costs mean power, so that less is possible
        columns = columns[:, ::2]
        n = columns.shape[1]

        def least_power(w):
            """Mean power of the best masses and load for the published swing, W."""
            inertia = w**2 / 1e3 * columns.T
            # masses, load at each angle, greatest torque; torques in kN.m
            rows = np.hstack([inertia, np.eye(n), -np.ones((n, 1))])
            found = linprog(
                np.concatenate([inertia.mean(0), np.full(n, 1 / n), [0.0]]),
                A_ub=np.vstack([rows, -rows]),
                b_ub=np.concatenate([np.zeros(n), np.full(n, 84.43948 * IDLE)]),
                bounds=[*RANGES, *[(0, None)] * n, (None, None)],
            )
            return found.fun * 1e3 * w / IDLE

        sharper = rpm(brentq(lambda w: least_power(w) - 510e3, 8.0, 20.0, xtol=1e-4))
        assert 75.1 < sharper < received

    def test_drop_of_the_power_bounds_the_speed_from_below(self):
        """B5: 86 kg more on the counterweight change the power by 9 kW at most so slowly."""
        change = 86 * per_mass(0.25)[1] / IDLE
        received = rpm(np.cbrt(9e3 / np.abs(change).max()))
        assert abs(received - 75.6) < 0.06
        received = rpm(np.cbrt(9e3 / np.sqrt((change**2).mean())))
        assert abs(received - 88.1) < 0.06


class Turned(lp.Component):
    """A mill at even speed."""

    w: lp.Param = lp.param("rad/s", "speed of the crank", 1.0)
    mill: Mill = stand.mill("P")
    turn: Position = Position(phi=w * lp.time)

    def connections(self):
        yield lp.connect(self.turn.flange, self.mill.crank)


def outputs(name, systems, factors):
    """F1 and F2 of both designs and the power before, for parameters times `factors`."""
    degrees = np.arange(0.0, 360.0, 0.25)
    w = stand.SPEED[name] * factors.get("w", 1.0)
    found = []
    for design in stand.DESIGNS.values():
        given = {f"mill.{k}": v * factors.get(k, 1.0) for k, v in stand.SETS[name].items()}
        given |= {f"mill.{k}": v for k, v in design.items()} | {"w": w}
        force, torque = (stand.revolution(s, w, degrees, given) for s in systems)
        found.append((stand.shaking_force(force), stand.crank_torque(torque, stand.IDLE)))
    power = found[0][1] * w
    return np.array(
        [np.hypot(*force.T).max() for force, _ in found]
        + [np.ptp(torque) / stand.RATIO[name] / factors.get("i", 1.0) for _, torque in found]
        + [power.max() if name == "P" else power.mean()]
    )


def singular_values(name, step, central):
    """Of the derivatives of log outputs by log parameters."""
    systems = [lp.assemble(Turned(mill=stand.mill(name, kind=kind))) for kind in (Mill, AsPrinted)]
    unknowns = [
        "w",
        *(k for k, v in stand.SETS[name].items() if v),
        *(["i"] if name == "F" else []),
    ]
    assert len(unknowns) == 10
    rows = []
    for key in unknowns:
        ends = (1.0, -1.0) if central else (1.0, 0.0)
        up, down = (np.log(outputs(name, systems, {key: np.exp(s * step)})) for s in ends)
        rows.append((up - down) / (step * (ends[0] - ends[1])))
    return np.linalg.svd(np.array(rows), compute_uv=False)


class TestIdentifiability:
    """Five published numbers and ten unknowns: half of the latter stay free."""

    @pytest.mark.parametrize(
        ("name", "expected"),
        [("P", (4.0, 3.3, 1.1, 0.69, 0.15)), ("F", (5.2, 3.3, 1.3, 1.1, 0.56))],
    )
    def test_singular_values_are_those_of_the_reference(self, name, expected):
        """By steps of a thousandth, as there: in set P they pass over kinks of F1 and F2."""
        received = singular_values(name, 1e-3, central=False)
        for value, digits in zip(received, expected, strict=True):
            assert abs(value - digits) < (0.051 if digits > 1 else 0.0051)

    def test_kinks_of_the_goals_hide_how_little_the_smallest_is(self):
        """The derivative proper of set P is smaller still; by two steps, as no kink is passed."""
        received = singular_values("P", 1e-5, central=True)
        assert np.allclose(received, singular_values("P", 1e-6, central=True), rtol=1e-6)
        assert received[-1] < 0.14
