"""What does the steady vibration of an engine over its speed cost?

Chains of inertias and springs with a loss factor, excited at six of them by 24 orders at 1 000
speeds: all amplitudes of two shaft torques by `order_response`, against numpy written by hand for
this drive, whose batched solver takes the complex matrices of all points at once, and against one
tridiagonal elimination for all points, which no branched drive has. Least of several calls,
alternating, processor time; the difference is relative to the largest amplitude. Nine inertias are
those of a six-cylinder crankshaft (`models/diesel_genset`).

The second table is that whole genset, whose pressures follow the angle: all shafts and the coupling
at 1 000 speeds, with operating points that are given at each speed, with one for all, and with the
load that balances the mean torques. There the difference is that from some speeds taken one by one.

    python -m benchmarks.order_response
"""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import lumped as lp
from benchmarks.harness import in_turn, publish, time_action
from lumped.components import Damper, Fixed, Inertia, LossSpring, Torque
from lumped.models.diesel_genset.drive import RPM, SHAFTS, Genset, load

SIZES, SPEEDS, ORDERS, ROUNDS = (9, 18, 36), np.linspace(100.0, 270.0, 1000), 24, 5
ETA, D = 0.035, 2.0
HEAD = (
    "inertias",
    "first call, s",
    "order response, ms",
    "over batched solver",
    "over tridiagonal",
    "difference",
)

GENSET_SPEEDS = np.linspace(420.0, 2400.0, 1000) * RPM
LOOKED_AT = slice(0, 1000, 111)
GENSET_HEAD = ("operating points", "speeds", "first call, s", "order response, s", "difference")

Solved = Callable[[], np.ndarray]


def drive(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inertias, stiffnesses, and complex amplitudes at the first six of them, (six, orders)."""
    random = np.random.default_rng(n)
    J = random.uniform(0.01, 0.06, n)
    J[-1] = 2.0
    k = random.uniform(1e6, 2e6, n - 1)
    T = random.normal(size=(6, ORDERS)) + 1j * random.normal(size=(6, ORDERS))
    return J, k, 100.0 * T


def by_lumped(J: np.ndarray, k: np.ndarray, T: np.ndarray) -> Solved:
    """Amplitudes of the first and the last shaft's torque, shape (speeds, orders, 2)."""
    n = len(J)
    system = lp.assemble(
        lp.compose(
            mass=[Inertia(J=value) for value in J],
            shaft=[LossSpring(c=value, eta=ETA, w_loss=1000.0) for value in k],
            oil=[Damper(d=D) for _ in range(6)],
            ground=Fixed(),
            gas=[Torque(tau=0.0) for _ in range(6)],
            connections=lambda m: [
                *(c for i in range(n - 1) for c in lp.chain(m.mass[i], m.shaft[i], m.mass[i + 1])),
                *(c for i in range(6) for c in lp.chain(m.ground, m.oil[i], m.mass[i])),
                *(lp.connect(m.gas[i].flange, m.mass[i].flange_a) for i in range(6)),
            ],
        )
    )
    orders = (np.arange(ORDERS) + 1) / 2
    given = {f"gas[{i}].tau": dict(zip(orders.tolist(), T[i], strict=True)) for i in range(6)}
    names = ["shaft[0].tau_c", f"shaft[{n - 2}].tau_c"]

    def solve() -> np.ndarray:
        return lp.vibration.order_response(
            system, speeds=SPEEDS, of=names, excitations=given
        ).values

    return solve


def by_hand(J: np.ndarray, k: np.ndarray, T: np.ndarray) -> tuple[Solved, Solved]:
    """The same by a batched dense solver, and by one tridiagonal elimination."""
    n = len(J)
    w = (SPEEDS[:, None] * (np.arange(ORDERS) + 1) / 2).ravel()
    stiff = k * (1 + 1j * ETA)
    damped = np.where(np.arange(n) < 6, D, 0.0)
    right = np.zeros((len(SPEEDS), ORDERS, n), dtype=complex)
    right[:, :, :6] = T.T
    right = right.reshape(-1, n)
    diagonal = np.append(stiff, 0) + np.insert(stiff, 0, 0)

    def torques(phi: np.ndarray) -> np.ndarray:
        # tau_c is the elastic part, so k without the loss
        found = k[[0, -1]] * (phi[:, [1, -1]] - phi[:, [0, -2]])
        return found.reshape(len(SPEEDS), ORDERS, 2)

    def dense() -> np.ndarray:
        K = np.diag(diagonal) - np.diag(stiff, 1) - np.diag(stiff, -1)
        M = K + 1j * w[:, None, None] * np.diag(damped) - (w**2)[:, None, None] * np.diag(J)
        return torques(np.linalg.solve(M, right[..., None])[..., 0])

    def tridiagonal() -> np.ndarray:
        own = diagonal + 1j * w[:, None] * damped - (w**2)[:, None] * J
        phi = right.copy()
        for i in range(1, n):
            factor = stiff[i - 1] / own[:, i - 1]
            own[:, i] -= factor * stiff[i - 1]
            phi[:, i] += factor * phi[:, i - 1]
        phi[:, -1] /= own[:, -1]
        for i in range(n - 2, -1, -1):
            phi[:, i] = (phi[:, i] + stiff[i] * phi[:, i + 1]) / own[:, i]
        return torques(phi)

    return dense, tridiagonal


def genset_rows() -> list[tuple[str, ...]]:
    """The table of the whole genset."""
    system = lp.assemble(Genset())

    def at(w: float) -> lp.OperatingPoint:
        turning = {"flywheel.w": w, "damper.w": w}
        own = {"engine.load": load(w)}
        return lp.start_point(system, parameters=own, start=turning, together=True)

    ways: dict[str, dict[str, Any]] = {
        "at each speed": {"at": at},
        "one": {"at": at(157.0)},
        "load balances": {"free": "electric.tau"},
    }
    rows = []
    for name, way in ways.items():
        respond = partial(
            lp.vibration.order_response,
            system,
            of=[*SHAFTS, "coupling.tau"],
            shaft="flywheel.phi",
            turns=2,
            **way,
        )
        every = partial(respond, speeds=GENSET_SPEEDS)
        found = time_action(every, ROUNDS, time.process_time)
        alone = np.array([respond(speeds=[w]).values[0] for w in GENSET_SPEEDS[LOOKED_AT]])
        error = np.abs(found.result.values[LOOKED_AT] - alone).max() / np.abs(alone).max()
        times = (f"{found.first:.2f}", f"{found.seconds:.2f}")
        rows.append((name, str(len(GENSET_SPEEDS)), *times, f"{error:.0e}"))
    return rows


def main() -> None:
    """Print the tables and write them to the results."""
    rows = []
    for n in SIZES:
        ways = [by_lumped(*drive(n)), *by_hand(*drive(n))]
        own, *others = in_turn(*ways, rounds=ROUNDS, clock=time.process_time)
        missed = max(np.abs(own.result - other.result).max() for other in others)
        ratios = [f"{own.seconds / other.seconds:.2f}" for other in others]
        error = missed / np.abs(others[0].result).max()
        times = (f"{own.first:.2f}", f"{own.seconds * 1e3:.0f}")
        rows.append((str(n), *times, *ratios, f"{error:.0e}"))
    publish("order_response", HEAD, rows)
    publish("order_response_genset", GENSET_HEAD, genset_rows())


if __name__ == "__main__":
    main()
