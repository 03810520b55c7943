"""The reversing mill by hand: chains of bodies and springs in kgf, m and s, in closed form.

The files in tests/data/reversing_mill were computed apart from this project, in closed form or by
modal sums, from the parameters printed in the source; their header lines name the columns.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
from references import columns
from scipy.linalg import expm
from scipy.optimize import brentq

data = partial(columns, "reversing_mill", named=False)

J1, J3, JR = 3.01, 2.45, 0.16 + 0.0001
C1, C2 = 2.62e4, 0.918e4

# Bodies and springs of the closed gap: upper motor, upper gearbox, all rolls, lower motor and
# gearbox. A spring's first body leads when its torque is positive.
CLOSED = ((J1, J3, 2 * JR, J1 + J3), ((0, 1, C1), (1, 2, C2), (3, 2, C2)))
# The same with the rolls apart: the lower rolls come last.
OPEN = ((J1, J3, JR, J1 + J3, JR), ((0, 1, C1), (1, 2, C2), (3, 4, C2)))


def chain(bodies: Sequence[float], springs: Sequence[tuple[int, int, float]]):
    """Square roots of J and C, and singular value decomposition of M^-1/2 B C^1/2."""
    root_J = np.sqrt(bodies)
    root_C = np.sqrt([c for _, _, c in springs])
    B = np.zeros((len(bodies), len(springs)))
    for k, (leading, following, _) in enumerate(springs):
        B[leading, k], B[following, k] = 1, -1
    return root_J, root_C, np.linalg.svd(B / root_J[:, None] * root_C, full_matrices=False)


def hertz(bodies: Sequence[float], springs: Sequence[tuple[int, int, float]]) -> np.ndarray:
    return np.sort(chain(bodies, springs)[2][1]) / (2 * np.pi)


def amplitudes(bodies, springs, torques) -> tuple[np.ndarray, np.ndarray]:
    """Circular frequencies, and torque amplitudes (spring, mode) of a step from rest.

    The torque of a spring is the sum over the modes of amplitude * (1 - cos(omega t)).
    """
    root_J, root_C, (U, omega, V) = chain(bodies, springs)
    return omega, root_C[:, None] * V.T * (U.T @ (torques / root_J) / omega)


def step_torques(bodies, springs, torques, times: np.ndarray) -> np.ndarray:
    omega, parts = amplitudes(bodies, springs, np.asarray(torques, dtype=float))
    return (1 - np.cos(np.outer(times, omega))) @ parts.T


def relative(received, expected) -> float:
    error = float(np.max(np.abs(np.asarray(received) / np.asarray(expected) - 1)))
    print(f"largest relative error {error:.2e}")
    return error


def course(bodies, springs, torques, speeds, times: np.ndarray) -> np.ndarray:
    """Torques of the springs under constant outer torques, from given speeds and no twist.

    Matrix exponentials of twists, speeds and a constant.
    """
    n, m = len(bodies), len(springs)
    A = np.zeros((m + n + 1, m + n + 1))
    for k, (leading, following, c) in enumerate(springs):
        A[k, m + leading], A[k, m + following] = 1, -1
        A[m + leading, k], A[m + following, k] = -c / bodies[leading], c / bodies[following]
    A[m : m + n, -1] = np.divide(torques, bodies)
    begin = np.concatenate([np.zeros(m), speeds, [1.0]])
    stiffness = np.array([c for _, _, c in springs])
    return np.array([stiffness * (expm(A * t) @ begin)[:m] for t in times])


def changes(run) -> list[tuple[float, str]]:
    """Instants at which the gap changes its mode, and the mode after each."""
    modes = {"stuck", "forward", "backward", "free"}
    return [(event.time, event.after) for event in run.events if event.after in modes]


def bar_hertz(low: float, high: float, *parts: tuple[float, ...]) -> float:
    """Natural frequency between two others of bodies (J,) and continuous shafts (C, J) in a row.

    The torque at the free end, by the matrices of the parts, is zero.
    """

    def torque(w):
        state = np.array([1.0, 0.0])
        for part in parts:
            if len(part) == 1:
                state = np.array([[1, 0], [-part[0] * w**2, 1]]) @ state
            else:
                C, J = part
                b = w * np.sqrt(J / C)
                turn = [[np.cos(b), np.sin(b) / (C * b)], [-C * b * np.sin(b), np.cos(b)]]
                state = turn @ state
        return state[1]

    span = 2 * np.pi * low, 2 * np.pi * high
    return brentq(torque, *span, xtol=1e-13, rtol=1e-14) / (2 * np.pi)


# Motors, gearbox and rolls one by one: twists of B1, B2, B3 by rows.
BODIES = np.array([J1, J3, JR, J1 + J3, JR])
TWISTS = np.array([[1.0, -1, 0, 0, 0], [0, 1, -1, 0, 0], [0, 0, 0, 1, -1]])
STIFFNESS = np.array([C1, C2, C2])
SLIP = np.array([0.0, 0, 1, 0, -1])


def harmonic_torques(f: float, K_s: float, stuck: bool = False) -> np.ndarray:
    """Complex torques of the shafts under a harmonic load of 1 on each pair of rolls."""
    join = np.vstack([np.eye(4), [0, 0, 1, 0]]) if stuck else np.eye(5)
    w = 2 * np.pi * f
    springs = TWISTS.T @ (STIFFNESS[:, None] * TWISTS)
    dynamic = springs - w**2 * np.diag(BODIES) + 0.5j * w * K_s * np.outer(SLIP, SLIP)
    load = np.array([0.0, 0, -1, 0, -1])
    angles = join @ np.linalg.solve(join.T @ dynamic @ join, join.T @ load)
    return STIFFNESS * (TWISTS @ angles)


def creeping(K_s: float) -> np.ndarray:
    """Rates of three twists and five speeds without load, as a matrix."""
    A = np.zeros((8, 8))
    A[:3, 3:] = TWISTS
    A[3:, :3] = -(TWISTS.T * STIFFNESS) / BODIES[:, None]
    A[3:, 3:] = -K_s / 2 * np.outer(SLIP, SLIP) / BODIES[:, None]
    return A


def creep_as_printed(K_s: float, load: float) -> tuple[np.ndarray, np.ndarray]:
    """Rates of (54), (55) as printed, and the row of M_u.

    Twists of B1, B2, B3, speeds of both motors' ends and the gearbox, J_v w_v + J_n w_n, and 1;
    motors and rolls take the same step of the load.
    """
    p, q, s, w1, w3, w2, total, one = np.eye(8)
    slip = C2 * (q - s) / K_s
    w_v, w_n = total / (2 * JR) + slip / 2, total / (2 * JR) - slip / 2
    rates = [w1 - w3, w3 - w_v, w2 - w_n, (load * one - C1 * p) / J1, (C1 * p - C2 * q) / J3]
    rates += [(load * one - C2 * s) / (J1 + J3), C2 * (q + s) - 2 * load * one, 0 * one]
    return np.array(rates), K_s / 2 * slip


def greatest(A: np.ndarray, row: np.ndarray, until: float, count: int) -> float:
    """Greatest absolute value of a row of linear states that begin at 0 with a last one of 1."""
    step, state = expm(A * until / count), np.eye(len(A))[-1]
    found = [abs(row @ state)]
    for _ in range(count):
        state = step @ state
        found.append(abs(row @ state))
    return max(found)
