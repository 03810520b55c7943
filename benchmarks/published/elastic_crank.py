"""Slider crank with an elastic rod, index 3, of the Test Set for IVP Solvers (Mazzia, Bari).

Simeon, Mathematical Modelling of Systems 2 (1996) 1; here with a linear stiffness and without
damping. The published start is declared, nothing is said about states.
"""

import numpy as np

import lumped as lp
from benchmarks.published.problem import ByHand, Problem, accelerate
from lumped.ops import cos, sin

POSITIONS = (0.0, 0.0, 0.450016933, 0.0, 0.0, 0.103339863e-4, 0.169327969e-4)
SPEEDS = (150.0, -74.9957670, -0.268938672e-5)
SPEEDS += (0.444896105, 0.463434311e-2, -0.178591076e-5, -0.268938672e-5)
END = {
    "p2": -0.3311734988256260,
    "p3": 0.1697373328427860,
    "p4": 1.893192899613509e-4,
    "p5": 2.375751249879174e-5,
    "p6": -5.323896770569702e-6,
    "p7": -8.363313279112129e-6,
}
"""Published reference at t = 0.1; it keeps the constraint of the speeds only, to 3e-8 in p4, p5."""

M2, M3, L1, L2, J1, J2, PI, RHO = (
    0.151104,
    0.075552,
    0.15,
    0.3,
    0.002727,
    0.0045339259,
    3.1415927,
    7870.0,
)
SECTION = 0.008 * 0.008
MASS, STIFF, SHAPE = RHO * SECTION * L2, 0.2e12 * SECTION / L2, SECTION * L2
M = MASS * np.array([[0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 8, 1], [0, 0, 1, 2]])
K = np.zeros((4, 4))
K[0, 0], K[1, 1] = (STIFF * PI**4 * f * (0.008 / L2) ** 2 for f in (1 / 24, 2 / 3))
K[2:, 2:] = STIFF / 3 * np.array([[16, -8], [-8, 7]])
B = np.zeros((4, 4))
B[0, 2], B[0, 3], B[1, 3] = -16 / PI**3, 8 / PI**3 - 1 / PI, 0.5 / PI
B = SHAPE * (B - B.T)
C1, C2 = SHAPE * np.array([0, 0, 2 / 3, 1 / 6]), SHAPE * np.array([2 / PI, 0, 0, 0])
C12, C21 = L2 * SHAPE * np.array([0, 0, 1 / 3, 1 / 6]), L2 * SHAPE / PI * np.array([1, -0.5, 0, 0])


def _dot(numbers, values):
    return sum((v * float(n) for n, v in zip(numbers, values, strict=True) if n), 0.0)


class ElasticCrank(lp.Component):
    """Positions p, speeds v, accelerations w, and the forces of three constraints."""

    for _i in range(7):
        locals()[f"p{_i + 1}"] = lp.var("1", "", POSITIONS[_i])
        locals()[f"v{_i + 1}"] = lp.var("1", "", SPEEDS[_i])
        locals()[f"w{_i + 1}"] = lp.var("1", "")
    for _i in range(3):
        locals()[f"l{_i + 1}"] = lp.var("N", "")

    def equations(self):
        p, v, w = ([getattr(self, f"{name}{i}") for i in range(1, 8)] for name in "pvw")
        force = [self.l1, self.l2, self.l3]
        q, qd = p[3:], v[3:]
        c, s = cos(p[0] - p[1]), sin(p[0] - p[1])
        c1q, c2q, c12q = _dot(C1, q), _dot(C2, q), _dot(C12, q)
        c1d, c2d, c12d = _dot(C1, qd), _dot(C2, qd), _dot(C12, qd)
        mq, kq = [_dot(row, q) for row in M], [_dot(row, q) for row in K]
        bq, bd = [_dot(row, q) for row in B.T], [_dot(row, qd) for row in B]
        qmq = sum(a * b for a, b in zip(q, mq, strict=True))
        qmd = sum(a * b for a, b in zip(qd, mq, strict=True))
        qbd = sum(a * b for a, b in zip(qd, bd, strict=True))
        first = [RHO * L1 * (c * float(C2[i]) - s * float(C1[i])) for i in range(4)]
        second = [RHO * (float(C21[i]) + bq[i]) for i in range(4)]
        mixed = 0.5 * L1 * L2 * M2 * c + RHO * L1 * (s * c2q + c * c1q)
        long, slow, fast = L2 + q[3], v[1] ** 2, v[0] ** 2
        left = [
            (J1 + M2 * L1**2) * w[0]
            + mixed * w[1]
            + sum(a * b for a, b in zip(first, w[3:], strict=True)),
            mixed * w[0]
            + (J2 + qmq + 2 * RHO * c12q) * w[1]
            + sum(a * b for a, b in zip(second, w[3:], strict=True)),
            M3 * w[2],
        ]
        left += [first[i] * w[0] + second[i] * w[1] + _dot(M[i], w[3:]) for i in range(4)]
        left[0] += L1 * cos(p[0]) * force[0] + L1 * sin(p[0]) * force[1] + force[2]
        left[1] += long * cos(p[1]) * force[0] + long * sin(p[1]) * force[1]
        left[2] += force[1]
        left[6] += sin(p[1]) * force[0] - cos(p[1]) * force[1]
        turned = 0.5 * L1 * L2 * M2 * s
        right = [
            RHO * L1 * slow * (c * c2q - s * c1q)
            - turned * slow
            - 2 * RHO * L1 * v[1] * (c * c1d + s * c2d),
            turned * fast
            + RHO * L1 * fast * (s * c1q - c * c2q)
            - 2 * RHO * v[1] * c12d
            - 2 * v[1] * qmd
            - RHO * qbd,
            0.0,
        ]
        for i in range(4):
            pull = slow * float(C12[i]) + L1 * fast * (c * float(C1[i]) + s * float(C2[i]))
            right.append(slow * mq[i] + RHO * (pull + 2 * v[1] * bd[i]) - kq[i])
        for i in range(7):
            yield lp.der(p[i]) == v[i]
            yield lp.der(v[i]) == w[i]
            yield left[i] == right[i]
        yield L1 * sin(p[0]) + long * sin(p[1]) == 0
        yield p[2] == L1 * cos(p[0]) + long * cos(p[1])
        yield p[0] == 150.0 * lp.time


def rate(_: float, z: np.ndarray) -> np.ndarray:
    """The same in NumPy: accelerations that keep the constraints."""
    q, qd, one, two = z[3:7], z[10:], z[7], z[8]
    c, s = np.cos(z[0] - z[1]), np.sin(z[0] - z[1])
    along, across, arm = c * C1 + s * C2, c * C2 - s * C1, L1 * RHO
    mass = np.zeros((7, 7))
    mass[0, 0] = J1 + M2 * L1**2
    mass[0, 1] = mass[1, 0] = 0.5 * L1 * L2 * M2 * c + arm * (along @ q)
    mass[1, 1], mass[2, 2] = J2 + q @ M @ q + 2 * RHO * (C12 @ q), M3
    mass[0, 3:] = mass[3:, 0] = arm * across
    mass[1, 3:] = mass[3:, 1] = RHO * (C21 + q @ B)
    mass[3:, 3:] = M
    long, turned = L2 + q[3], 0.5 * L1 * L2 * M2 * s
    c1, s1, c2, s2 = np.cos(z[0]), np.sin(z[0]), np.cos(z[1]), np.sin(z[1])
    slope = np.zeros((3, 7))
    slope[0, [0, 1, 6]] = L1 * c1, long * c2, s2
    slope[1, [0, 1, 2, 6]] = L1 * s1, long * s2, 1.0, -c2
    slope[2, 0] = 1.0
    force = np.zeros(7)
    force[0] = two**2 * (arm * (across @ q) - turned) - 2 * arm * two * (along @ qd)
    force[1] = one**2 * (turned - arm * (across @ q))
    force[1] -= 2 * two * (RHO * (C12 @ qd) + qd @ M @ q) + RHO * (qd @ B @ qd)
    force[3:] = two**2 * (M @ q + RHO * C12) + arm * one**2 * along + 2 * RHO * two * (B @ qd)
    force[3:] -= K @ q
    bent = [
        -L1 * s1 * one**2 - long * s2 * two**2 + 2 * two * c2 * qd[3],
        L1 * c1 * one**2 + long * c2 * two**2 + 2 * two * s2 * qd[3],
        0.0,
    ]
    return np.concatenate([z[7:], accelerate(mass, slope, force, np.array(bent))])


ELASTIC_CRANK = Problem(
    "slider crank, elastic rod",
    "IVP test set, crank",
    ElasticCrank,
    0.1,
    END,
    ByHand(rate, (*POSITIONS, *SPEEDS), lambda z: z[1:7]),
    digits=3e-8,
)
