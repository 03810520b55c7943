"""Bodies whose periodic motions are known by hand or by a calculation of their own."""

import numpy as np
from rows import assemble_one
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import lumped as lp
from lumped.ops import cos, sin

TURN = {"phi": 2 * np.pi}
X = {"x": lp.var("m", "position"), "v": lp.var("m/s", "velocity")}
G, W = 9.81, 2 * np.pi


def driven(d=0.3, c=2.0, cubic=0.0, pumped=0.0, F=1.5, T=2 * np.pi / 1.1):
    """``x'' + d x' + (c + pumped cos(w t)) x + cubic x^3 = F cos(w t)``, its loss; w = 2 pi / T."""

    def equations(self):
        wave = cos(2 * np.pi / self.T * lp.time)
        yield lp.der(self.x) == self.v
        stiffness = self.c + self.pumped * wave
        force = self.F * wave - self.d * self.v - self.cubic * self.x**3
        yield lp.der(self.v) == force - stiffness * self.x
        yield lp.der(self.E) == self.d * self.v**2

    values = {"d": d, "c": c, "cubic": cubic, "pumped": pumped, "F": F}
    parameters = {name: lp.param("1", name, value) for name, value in values.items()}
    period = lp.param("s", "period", T)
    return assemble_one(equations, **parameters, T=period, **X, E=lp.var("J", "loss"))


class Rotor(lp.Component):
    """Eccentric rotor under a constant torque: ``J w' = tau - d w - G sin(phi)``."""

    phi: lp.Var = lp.var("rad", "angle")
    w: lp.Var = lp.var("rad/s", "speed", start=12.0)
    back: lp.Var = lp.var("rad", "angle behind a gear that turns it round")
    J: lp.Param = lp.param("kg.m2", "inertia", 1.0)
    d: lp.Param = lp.param("N.m.s/rad", "damping", 0.5)
    G: lp.Param = lp.param("N.m", "weight times eccentricity", 2.0)
    tau: lp.Param = lp.param("N.m", "torque", 5.0)
    ratio: lp.Param = lp.param("1", "of the gear", -2.0)

    def equations(self):
        yield lp.der(self.phi) == self.w
        yield self.J * lp.der(self.w) == self.tau - self.d * self.w - self.G * sin(self.phi)
        yield self.back == self.ratio * self.phi


ROTOR = lp.assemble(Rotor())


def turn(w, tau=5.0, J=1.0, d=0.5, G=2.0, **options):
    """One turn over the angle from a speed: speed and time as functions of the angle."""

    def rates(phi, y):
        return [(tau - d * y[0] - G * np.sin(phi)) / (J * y[0]), 1 / y[0]]

    return solve_ivp(rates, (0, 2 * np.pi), [w, 0.0], "DOP853", rtol=1e-12, atol=1e-13, **options)


def orbit_of(**values):
    """The turn that repeats."""
    w = brentq(lambda w: turn(w, **values).y[0, -1] - w, 5.0, 40.0, xtol=1e-13)
    return turn(w, **values, dense_output=True)


def swing_of(found):
    """Greatest less least speed of a turn."""
    return np.ptp(found.sol(np.linspace(0, 2 * np.pi, 20_001))[0])


def torque_for(period, **values):
    """The torque with which a turn takes a time, by Newton's method with differences."""
    return start_and_torque(period, **values)[1]


def start_and_torque(period, **values):
    """The speed at the angle zero, too."""

    def missed(z):
        w, passed = turn(z[0], tau=z[1], **values).y[:, -1]
        return np.array([w - z[0], passed - period])

    z = np.array([2 * np.pi / period, 0.5 * 2 * np.pi / period])
    for _ in range(8):
        slopes = np.column_stack([(missed(z + h) - missed(z - h)) / 2e-4 for h in 1e-4 * np.eye(2)])
        z = z - np.linalg.solve(slopes, missed(z))
    assert np.abs(missed(z)).max() < 1e-11
    return z


class Slider(lp.Component):
    """Mass on a spring, a damper and a belt of speed u: friction, greater while it sticks."""

    s: lp.Var = lp.var("m", "position")
    v: lp.Var = lp.var("m/s", "velocity")
    slip: lp.Var = lp.var("m/s", "velocity less that of the belt", state="always")
    f: lp.Var = lp.var("N", "friction")
    c: lp.Param = lp.param("N/m", "stiffness", 9.0)
    d: lp.Param = lp.param("N.s/m", "damping", 0.0)
    m: lp.Param = lp.param("kg", "mass", 2.0)
    u: lp.Param = lp.param("m/s", "speed of the belt", 0.4)
    kinetic: lp.Param = lp.param("N", "friction while it slides", 3.0)
    static: lp.Param = lp.param("N", "greatest friction while it sticks", 5.0)

    def equations(self):
        yield self.v == lp.der(self.s)
        yield self.slip == self.v - self.u
        yield self.m * lp.der(self.v) == -self.c * self.s - self.d * self.v - self.f
        yield lp.hold(
            self.f,
            self.slip,
            forward=self.kinetic,
            backward=-self.kinetic,
            upper=self.static,
            lower=-self.static,
        )


class Ball(lp.Component):
    """Ball above a plate at ``A cos(W t)``."""

    h: lp.Var = lp.var("m", "gap")
    v: lp.Var = lp.var("m/s", "its rate", state="prefer")
    f: lp.Var = lp.var("N", "reaction of the plate, downwards")
    A: lp.Param = lp.param("m", "amplitude of the plate", 0.3)
    e: lp.Param = lp.param("1", "restitution", 0.6)

    def equations(self):
        yield self.v == lp.der(self.h)
        yield lp.der(self.v) == -G + self.A * W**2 * cos(W * lp.time) - self.f
        yield lp.hold(self.f, self.v, gap=self.h, restitution=self.e)


def one_bounce(cosine=1):
    """Phase of the plate at the only bounce in a second, and the start, by hand.

    The ball leaves with g / 2 and is back after a second (Guckenheimer and Holmes, 1983, 2.4).
    """
    e, A, up = 0.6, 0.3, G / 2
    phase = np.arcsin(-up * (1 - e) / (1 + e) / (A * W))
    phase = phase if cosine > 0 else np.pi - phase
    flown = 1.0 - (phase / W) % 1.0
    return phase, {"h": A * np.cos(phase) + up * flown - G / 2 * flown**2 - A, "v": up - G * flown}
