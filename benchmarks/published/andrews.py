"""Andrews' squeezing mechanism: seven bodies, three loops, index 3."""

from types import ModuleType
from typing import Any

import numpy as np

import lumped as lp
from benchmarks.published.problem import ByHand, Problem, accelerate

M1, M2, M3, M4, M5, M6, M7 = 0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498
I1, I2, I3, I4 = 2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7
I5, I6, I7 = 1.169e-5, 5.667e-7, 1.912e-5
XA, YA, XB, YB, XC, YC = -0.06934, -0.00227, -0.03635, 0.03273, 0.014, 0.072
STIFFNESS, FREE, TORQUE = 4530.0, 0.07785, 0.033
D, DA, E, EA, RR, RA = 0.028, 0.0115, 0.02, 0.01421, 0.007, 0.00092
SS, SA, SB, SC, SD = 0.035, 0.01874, 0.01043, 0.018, 0.02
TA, TB, U, UA, UB, ZF, ZT, FA = 0.02308, 0.00916, 0.04, 0.01228, 0.00449, 0.02, 0.04, 0.01421
START = (
    -0.0617138900142764496,
    0.0,
    0.455279819163070380,
    0.222668390165885884,
    0.487364979543842550,
    -0.222668390165885884,
    1.23054744454982119,
)
END = {
    "q1": 15.81077119629904,
    "q2": -15.75637105984298,
    "q3": 0.04082224013073101,
    "q4": -0.5347301163226948,
    "q5": 0.5244099658805304,
    "q6": 0.5347301163226948,
    "q7": 1.048080741042263,
}

Entries = dict[tuple[int, int], Any]


def terms(q: Any, v: Any, m: ModuleType) -> tuple[Entries, list[Any], Entries]:
    """Lower part of the mass matrix, forces, and slopes of the loops, by functions of a module."""
    sin, cos = m.sin, m.cos
    be, th, ga, ph, de, om, ep = q
    bep, thp, _, php, dep, omp, epp = v
    e, z = E - EA, ZF - FA
    mass = {
        (0, 0): M1 * RA**2 + M2 * (RR**2 - 2 * DA * RR * cos(th) + DA**2) + I1 + I2,
        (1, 0): M2 * (DA**2 - DA * RR * cos(th)) + I2,
        (1, 1): M2 * DA**2 + I2,
        (2, 2): M3 * (SA**2 + SB**2) + I3,
        (3, 3): M4 * e**2 + I4,
        (4, 3): M4 * (e**2 + ZT * e * sin(ph)) + I4,
        (4, 4): M4 * (ZT**2 + 2 * ZT * e * sin(ph) + e**2) + M5 * (TA**2 + TB**2) + I4 + I5,
        (5, 5): M6 * z**2 + I6,
        (6, 5): M6 * (z**2 - U * z * sin(om)) + I6,
        (6, 6): M6 * (z**2 - 2 * U * z * sin(om) + U**2) + M7 * (UA**2 + UB**2) + I6 + I7,
    }
    x = SD * cos(ga) + SC * sin(ga) + XB - XC
    y = SD * sin(ga) - SC * cos(ga) + YB - YC
    length = m.sqrt(x**2 + y**2)
    pull = -STIFFNESS * (length - FREE) / length
    arm_x, arm_y = SC * cos(ga) - SD * sin(ga), SD * cos(ga) + SC * sin(ga)
    force = [
        TORQUE - M2 * DA * RR * thp * (thp + 2 * bep) * sin(th),
        M2 * DA * RR * bep**2 * sin(th),
        pull * (x * arm_x + y * arm_y),
        M4 * ZT * e * dep**2 * cos(ph),
        -M4 * ZT * e * php * (php + 2 * dep) * cos(ph),
        -M6 * U * z * epp**2 * cos(om),
        M6 * U * z * omp * (omp + 2 * epp) * cos(om),
    ]
    slope: Entries = {
        (0, 2): -SS * cos(ga),
        (1, 2): -SS * sin(ga),
        (2, 3): -E * cos(ph + de),
        (2, 4): -E * cos(ph + de) + ZT * sin(de),
        (3, 3): -E * sin(ph + de),
        (3, 4): -E * sin(ph + de) - ZT * cos(de),
        (4, 5): ZF * sin(om + ep),
        (4, 6): ZF * sin(om + ep) - U * cos(ep),
        (5, 5): -ZF * cos(om + ep),
        (5, 6): -ZF * cos(om + ep) - U * sin(ep),
    }
    for row in (0, 2, 4):
        slope[row, 0] = -RR * sin(be) + D * sin(be + th)
        slope[row, 1] = D * sin(be + th)
        slope[row + 1, 0] = RR * cos(be) - D * cos(be + th)
        slope[row + 1, 1] = -D * cos(be + th)
    return mass, force, slope


class Andrews(lp.Component):
    """Angles and speeds of seven bodies, and the forces that close the loops."""

    for _i in range(7):
        locals()[f"q{_i + 1}"] = lp.var("rad", "", START[_i])
        locals()[f"v{_i + 1}"] = lp.var("rad/s", "", 0.0)
    for _i in range(6):
        locals()[f"l{_i + 1}"] = lp.var("N", "")

    def equations(self):
        q, v = ([getattr(self, f"{name}{i}") for i in range(1, 8)] for name in "qv")
        joint = [getattr(self, f"l{i}") for i in range(1, 7)]
        mass, force, slope = terms(q, v, lp.ops)
        left = [0.0] * 7
        for (i, k), value in mass.items():
            left[i] += value * lp.der(v[k])
            if i != k:
                left[k] += value * lp.der(v[i])
        for (k, i), value in slope.items():
            left[i] += value * joint[k]
        for i in range(7):
            yield lp.der(q[i]) == v[i]
            yield left[i] == force[i]
        sin, cos = lp.ops.sin, lp.ops.cos
        be, th, ga, ph, de, om, ep = q
        x, y = RR * cos(be) - D * cos(be + th), RR * sin(be) - D * sin(be + th)
        yield x - SS * sin(ga) == XB
        yield y + SS * cos(ga) == YB
        yield x - E * sin(ph + de) - ZT * cos(de) == XA
        yield y + E * cos(ph + de) - ZT * sin(de) == YA
        yield x - ZF * cos(om + ep) - U * sin(ep) == XA
        yield y - ZF * sin(om + ep) + U * cos(ep) == YA


def rate(_: float, z: np.ndarray) -> np.ndarray:
    """The same in NumPy: accelerations that keep the loops closed."""
    be, th, ga, ph, de, om, ep = q = z[:7].tolist()
    bep, thp, gap, php, dep, omp, epp = v = z[7:].tolist()
    entries, force, sloped = terms(q, v, np)
    mass, slope = np.zeros((7, 7)), np.zeros((6, 7))
    for (i, k), value in entries.items():
        mass[i, k] = mass[k, i] = value
    for place, value in sloped.items():
        slope[place] = value
    sin, cos = np.sin, np.cos
    x = -RR * cos(be) * bep**2 + D * cos(be + th) * (bep + thp) ** 2
    y = -RR * sin(be) * bep**2 + D * sin(be + th) * (bep + thp) ** 2
    f, o = (php + dep) ** 2, (omp + epp) ** 2
    bent = [
        x + SS * sin(ga) * gap**2,
        y - SS * cos(ga) * gap**2,
        x + E * sin(ph + de) * f + ZT * cos(de) * dep**2,
        y - E * cos(ph + de) * f + ZT * sin(de) * dep**2,
        x + ZF * cos(om + ep) * o + U * sin(ep) * epp**2,
        y + ZF * sin(om + ep) * o - U * cos(ep) * epp**2,
    ]
    return np.concatenate([z[7:], accelerate(mass, slope, np.array(force), np.array(bent))])


ANDREWS = Problem(
    "Andrews' mechanism",
    "IVP test set, andrews",
    Andrews,
    0.03,
    END,
    ByHand(rate, (*START, *[0.0] * 7), lambda z: z[:7]),
    digits=3e-10,
)
