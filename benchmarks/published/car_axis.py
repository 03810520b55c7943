"""Car axis of the test set: two wheels on a bumpy road, index 3."""

import numpy as np

import lumped as lp
from benchmarks.published.problem import ByHand, Problem, accelerate
from lumped.ops import sin, sqrt

MASS = 10.0 * 1e-4 / 2


class CarAxis(lp.Component):
    """Starts where yl and yr must lead; `weight` scales the acceleration of free fall."""

    xl: lp.Var = lp.var("1", "", 0.0)
    yl: lp.Var = lp.var("1", "", 0.5)
    xr: lp.Var = lp.var("1", "", 1.0)
    yr: lp.Var = lp.var("1", "", 0.5)
    ul: lp.Var = lp.var("1", "", -0.5)
    vl: lp.Var = lp.var("1", "", 0.0)
    ur: lp.Var = lp.var("1", "", -0.5)
    vr: lp.Var = lp.var("1", "", 0.0)
    weight: lp.Param = lp.param("1", "", 1.0)
    l1: lp.Var = lp.var("1", "")
    l2: lp.Var = lp.var("1", "")

    def equations(self):
        yb = 0.1 * sin(10.0 * lp.time)
        xb, k, g = sqrt(1.0 - yb**2), MASS, self.weight
        xl, yl, xr, yr, l1, l2 = self.xl, self.yl, self.xr, self.yr, self.l1, self.l2
        left, right = sqrt(xl**2 + yl**2), sqrt((xr - xb) ** 2 + (yr - yb) ** 2)
        for position, speed in ((xl, self.ul), (yl, self.vl), (xr, self.ur), (yr, self.vr)):
            yield lp.der(position) == speed
        yield k * lp.der(self.ul) == (0.5 - left) * xl / left + l1 * xb + 2 * l2 * (xl - xr)
        yield k * lp.der(self.vl) == (0.5 - left) * yl / left + l1 * yb + 2 * l2 * (yl - yr) - k * g
        yield k * lp.der(self.ur) == (0.5 - right) * (xr - xb) / right - 2 * l2 * (xl - xr)
        yield k * lp.der(self.vr) == (0.5 - right) * (yr - yb) / right - 2 * l2 * (yl - yr) - k * g
        yield xb * xl + yb * yl == 0
        yield (xl - xr) ** 2 + (yl - yr) ** 2 == 1.0


def rate(t: float, z: np.ndarray) -> np.ndarray:
    """The same in NumPy: accelerations that keep both constraints."""
    xl, yl, xr, yr, ul, vl, ur, vr = z.tolist()
    yb, vb, ab = 0.1 * np.sin(10 * t), np.cos(10 * t), -10 * np.sin(10 * t)
    xb = np.sqrt(1 - yb**2)
    ub = -yb * vb / xb
    aside = -(ub**2 + vb**2 + yb * ab) / xb
    left, right = np.hypot(xl, yl), np.hypot(xr - xb, yr - yb)
    x, y, u, v = xl - xr, yl - yr, ul - ur, vl - vr
    slope = np.array([[xb, yb, 0.0, 0.0], [2 * x, 2 * y, -2 * x, -2 * y]])
    bent = np.array(
        [aside * xl + ab * yl + 2 * (ub * ul + vb * vl), 2 * (u**2 + v**2)],
    )
    force = np.array(
        [
            (0.5 - left) * xl / left,
            (0.5 - left) * yl / left - MASS,
            (0.5 - right) * (xr - xb) / right,
            (0.5 - right) * (yr - yb) / right - MASS,
        ]
    )
    return np.concatenate([z[4:], accelerate(MASS * np.eye(4), slope, force, bent)])


CAR_AXIS = Problem(
    "car axis",
    "IVP test set, caraxis",
    CarAxis,
    3.0,
    {
        "xl": 0.0493455784275402809122,
        "yl": 0.496989460230171153861,
        "xr": 1.04174252488542151681,
        "yr": 0.373911027265361256927,
    },
    ByHand(rate, (0.0, 0.5, 1.0, 0.5, -0.5, 0.0, -0.5, 0.0), lambda z: z[:4]),
)
