"""The reversing mill by hand: chains of bodies and springs in kgf, m and s, in closed form.

The files in tests/data/reversing_mill were computed apart from this project, in closed form or by
modal sums, from the parameters printed in the source; their header lines name the columns.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
from references import columns
from scipy.linalg import expm

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
