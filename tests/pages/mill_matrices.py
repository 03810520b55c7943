"""The reversing mill as five masses in N, m and s, for the pages that use it."""

import numpy as np
from mill_by_hand import C1, C2, J1, J3, JR
from scipy.linalg import eig

G = 9.80665
J = np.array([J1, J3, JR, JR, J1 + J3]) * G  # motor, gearbox, rolls, rolls, lower motor
C = np.array([C1, C2, C2]) * G
TWIST = np.array([[1.0, -1, 0, 0, 0], [0, 1, -1, 0, 0], [0, 0, 0, 1, -1]])
SLIP = np.array([[0.0, 0, 1, -1, 0]])
K = TWIST.T @ np.diag(C) @ TWIST


def eigenvalues(creep):
    """Of the mill with a creep coefficient of its gap."""
    D, zero, one = creep / 2 * SLIP.T @ SLIP, np.zeros((5, 5)), np.eye(5)
    return eig(np.block([[zero, one], [-K, -D]]), np.block([[one, zero], [zero, np.diag(J)]]))[0]


def oscillating(creep):
    """Absolute eigenvalues of what oscillates, rad/s."""
    found = eigenvalues(creep)
    return np.sort(np.abs(found[found.imag > 1.0]))
