"""Controllers, filters and limiters for drives.

Signals carry the unit of the quantity they are connected to; their declared unit is "1".
Controllers compare `wanted` with `measured`, blocks turn `u` into `y`. When a limiter begins or
ceases to act, the run stops and notes an event: the kink is exact, and one sees when a drive was at
its limit.

Sources: Astrom and Hagglund, Advanced PID Control, 2006, ch. 3.5 (anti-windup) and 13 (sampling);
Leonhard, Control of Electrical Drives, 3rd ed., ch. 15 (position control).
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import (
    Component,
    Connection,
    Equation,
    Expr,
    Input,
    Output,
    Param,
    Var,
    connect,
    der,
    param,
    time,
    var,
)
from lumped.ops import maximum, minimum, sign, smooth, sqrt, where

__all__ = [
    "CascadeControl",
    "CurrentController",
    "FedPI",
    "Filter",
    "Gain",
    "Integrator",
    "LimitedPI",
    "Limiter",
    "LoadShare",
    "PController",
    "PIController",
    "PointToPoint",
    "RateLimiter",
    "SquareRootController",
    "Sum",
]


def limit_between(u: Expr, low: Expr, high: Expr) -> Expr:
    """`u` between two limits; the run stops where it meets one."""
    return where(u > high, high, where(u < low, low, u))


class Gain(Component):
    """Proportional block: ``y = k u``."""

    symbol = "gain"
    u: Input = Input("1", "signal")
    k: Param = param("1", "gain")
    y = Output("1", "signal")

    def equations(self) -> Iterator[Equation]:
        yield self.y == self.k * self.u


class Sum(Component):
    """Weighted sum of two signals: ``y = k_a a + k_b b``."""

    symbol = "sum"
    a: Input = Input("1", "first signal")
    b: Input = Input("1", "second signal")
    k_a: Param = param("1", "weight of the first signal", 1.0)
    k_b: Param = param("1", "weight of the second signal", 1.0)
    y = Output("1", "signal")

    def equations(self) -> Iterator[Equation]:
        yield self.y == self.k_a * self.a + self.k_b * self.b


class Integrator(Component):
    """Integral: ``der(x) = k u``, ``y = x``; it begins at 0 unless `x` is given."""

    symbol = "integral"
    u: Input = Input("1", "signal")
    k: Param = param("1/s", "gain", 1.0)
    x: Var = var("1", "integral", state="prefer")
    y = Output("1", "integral")

    def equations(self) -> Iterator[Equation]:
        yield der(self.x) == self.k * self.u
        yield self.y == self.x


class Filter(Component):
    """First-order low pass: ``T der(x) = u - x``, ``y = x``."""

    symbol = "lag"
    u: Input = Input("1", "signal")
    T: Param = param("s", "time constant", above=0)
    x: Var = var("1", "filtered signal", state="prefer")
    y = Output("1", "filtered signal")

    def equations(self) -> Iterator[Equation]:
        yield self.T * der(self.x) == self.u - self.x
        yield self.y == self.x


class Limiter(Component):
    """Limiter: ``y = min(max(u, y_min), y_max)``."""

    symbol = "limiter"
    u: Input = Input("1", "signal")
    y_min: Param = param("1", "least output")
    y_max: Param = param("1", "greatest output", above=y_min)
    y = Output("1", "limited signal")

    def equations(self) -> Iterator[Equation]:
        yield self.y == limit_between(self.u, self.y_min, self.y_max)


class RateLimiter(Component):
    """Ramp limiter: ``der(x) = clip((u - x) / T, +-rate)``, ``y = x``.

    Follows a slower signal with the lag `T`, which should be short for the driven part. The kinks
    are not located: a signal that stays at the limit would meet it again and again.
    """

    symbol = "ramp"
    u: Input = Input("1", "signal")
    rate: Param = param("1/s", "greatest rate of change, both ways", above=0)
    T: Param = param("s", "time constant of following", above=0)
    x: Var = var("1", "output", state="prefer")
    y = Output("1", "signal of limited rate")

    def equations(self) -> Iterator[Equation]:
        rate = (self.u - self.x) / self.T
        yield der(self.x) == smooth(minimum(maximum(rate, -self.rate), self.rate))
        yield self.y == self.x


class PController(Component):
    """Proportional controller: ``y = k (wanted - measured)``."""

    symbol = "proportional"
    wanted: Input = Input("1", "wanted value")
    measured: Input = Input("1", "measured value")
    k: Param = param("1", "gain", above=0)
    y = Output("1", "controller output")

    def equations(self) -> Iterator[Equation]:
        yield self.y == self.k * (self.wanted - self.measured)


class PIController(Component):
    """PI controller: ``e = wanted - measured``, ``T_i der(x) = e``, ``y = k (e + x)``."""

    symbol = "controller"
    wanted: Input = Input("1", "wanted value")
    measured: Input = Input("1", "measured value")
    k: Param = param("1", "gain", above=0)
    T_i: Param = param("s", "integral time", above=0)
    x: Var = var("1", "integral part over the gain", state="prefer")
    y = Output("1", "controller output")

    def equations(self) -> Iterator[Equation]:
        e = self.wanted - self.measured
        yield self.T_i * der(self.x) == e
        yield self.y == self.k * (e + self.x)


class LimitedPI(Component):
    """PI controller with limits and anti-windup by back calculation.

    ``e = wanted - measured``, ``u = k (e + x)``, ``y = clip(u, y_min, y_max)`` and
    ``T_i der(x) = e + (y - u) / (k N_i)``: beyond a limit the integral part is led back with the
    time constant ``N_i T_i``.
    """

    symbol = "controller"
    wanted: Input = Input("1", "wanted value")
    measured: Input = Input("1", "measured value")
    k: Param = param("1", "gain", above=0)
    T_i: Param = param("s", "integral time", above=0)
    N_i: Param = param("1", "time of back calculation over integral time", 1.0, above=0)
    y_min: Param = param("1", "least output")
    y_max: Param = param("1", "greatest output", above=y_min)
    x: Var = var("1", "integral part over the gain", state="prefer")
    u: Var = var("1", "output without limits")
    y = Output("1", "controller output")

    def equations(self) -> Iterator[Equation]:
        e = self.wanted - self.measured
        yield self.u == self.k * (e + self.x)
        yield self.y == limit_between(self.u, self.y_min, self.y_max)
        yield self.T_i * der(self.x) == e + (self.y - self.u) / (self.k * self.N_i)


class FedPI(Component):
    """PI controller with a feed-forward and a limit that are signals, with anti-windup.

    ``e = wanted - measured``, ``u = k (e + x) + feed``, ``y = clip(u, +-limit)`` and
    ``T_i der(x) = e + (y - u) / k``.
    """

    symbol = "controller"
    wanted: Input = Input("1", "wanted value")
    measured: Input = Input("1", "measured value")
    feed: Input = Input("1", "feed-forward, added to the output")
    limit: Input = Input("1", "greatest output, both ways")
    k: Param = param("1", "gain", above=0)
    T_i: Param = param("s", "integral time", above=0)
    x: Var = var("1", "integral part over the gain", state="prefer")
    u: Var = var("1", "output without limits")
    y = Output("1", "controller output")

    def equations(self) -> Iterator[Equation]:
        e = self.wanted - self.measured
        yield self.u == self.k * (e + self.x) + self.feed
        yield self.y == limit_between(self.u, -self.limit, self.limit)
        yield self.T_i * der(self.x) == e + (self.y - self.u) / self.k


class CurrentController(FedPI):
    """PI controller of a motor current: the induced voltage is fed forward, the limit is a signal.

    The law is that of `FedPI`: ``u = k (e + x) + feed``. For a first-order lag of the converter and
    its measurement with sum `T`, ``k = L / (2 T)`` and ``T_i = L / R`` (optimum by magnitude;
    Leonhard, ch. 7).
    """

    wanted: Input = Input("A", "wanted current")
    measured: Input = Input("A", "measured current")
    feed: Input = Input("V", "induced voltage")
    limit: Input = Input("V", "greatest voltage, both ways")
    k: Param = param("Ohm", "gain", above=0)
    x: Var = var("A", "integral part over the gain", state="prefer")
    u: Var = var("V", "voltage without limits")
    y = Output("V", "wanted voltage")


class SquareRootController(Component):
    """Position controller that brakes with `a`: ``y = sqrt(2 a (e - e_0/2))`` for ``e > e_0``.

    Near the aim ``y = K e``; both meet without a kink at ``e_0 = a / K^2``. Odd in
    ``e = wanted - measured``; `y` is the wanted speed.
    """

    symbol = "root"
    wanted: Input = Input("1", "wanted position")
    measured: Input = Input("1", "measured position")
    K: Param = param("1/s", "gain near the aim", above=0)
    a: Param = param("1/s2", "deceleration", above=0)
    y = Output("1/s", "wanted speed")

    def equations(self) -> Iterator[Equation]:
        e, e_0 = self.wanted - self.measured, self.a / self.K**2
        far = maximum(maximum(e, -e), e_0)
        yield self.y == e / far * sqrt(2 * self.a * (far - e_0 / 2))


class CascadeControl(Component):
    """Position and speed control of a drive in cascade, with feed-forward and limits.

    The wanted speed is ``v = clip(K e + v_feed, +-v_max)`` with ``e = wanted - measured``; beyond
    ``e = a / K^2`` it brakes with `a` as `SquareRootController` does. The torque or force is
    ``y = clip(k (v - v_measured + x) + f_feed, +-f_max)``, ``T_i der(x) = v - v_measured`` with
    anti-windup as in `FedPI`. With ``v_feed = der(wanted)`` and ``f_feed = J der(v_feed)`` a rigid
    drive follows without error.
    """

    symbol = "controller"
    wanted: Input = Input("1", "wanted position")
    measured: Input = Input("1", "measured position")
    v_measured: Input = Input("1/s", "measured speed")
    v_feed: Input = Input("1/s", "feed-forward of the speed")
    f_feed: Input = Input("1", "feed-forward of the torque or force")
    K: Param = param("1/s", "gain of the position control", above=0)
    a: Param = param("1/s2", "deceleration far from the aim; 1e30: K e throughout", 1e30, above=0)
    v_max: Param = param("1/s", "greatest wanted speed, both ways", above=0)
    k: Param = param("1", "gain of the speed control", above=0)
    T_i: Param = param("s", "integral time of the speed control", above=0)
    f_max: Param = param("1", "greatest torque or force, both ways", above=0)
    y = Output("1", "wanted torque or force")
    position: SquareRootController = SquareRootController(K=K, a=a)
    fed: Sum = Sum()
    most: Limiter = Limiter(y_min=-v_max, y_max=v_max)
    speed: FedPI = FedPI(k=k, T_i=T_i, limit=f_max)

    def connections(self) -> Iterator[Connection]:
        yield connect(self.wanted, self.position.wanted)
        yield connect(self.measured, self.position.measured)
        yield connect(self.position.y, self.fed.a)
        yield connect(self.v_feed, self.fed.b)
        yield connect(self.fed.y, self.most.u)
        yield connect(self.most.y, self.speed.wanted)
        yield connect(self.v_measured, self.speed.measured)
        yield connect(self.f_feed, self.speed.feed)
        yield connect(self.speed.y, self.y)


class LoadShare(Component):
    """Load-share trim: a limited PI controller that brings ``own = share (own + other)``.

    `y` is added to the wanted speed of the own drive: ``e = share (own + other) - own``,
    ``u = k (e + x)``, ``y = clip(u, +-y_max)``, ``T_i der(x) = e + (y - u) / k``.
    """

    symbol = "controller"
    own: Input = Input("N.m", "torque of the own drive")
    other: Input = Input("N.m", "torque of the other drive")
    share: Param = param("1", "part of the own drive", 0.5, min=0, max=1)
    k: Param = param("rad/(s.N.m)", "gain", above=0)
    T_i: Param = param("s", "integral time", above=0)
    y_max: Param = param("rad/s", "greatest correction", above=0)
    x: Var = var("N.m", "integral part over the gain", state="prefer")
    u: Var = var("rad/s", "correction without limits")
    y = Output("rad/s", "correction of the wanted speed")

    def equations(self) -> Iterator[Equation]:
        e = self.share * (self.own + self.other) - self.own
        yield self.u == self.k * (e + self.x)
        yield self.y == limit_between(self.u, -self.y_max, self.y_max)
        yield self.T_i * der(self.x) == e + (self.y - self.u) / self.k


class PointToPoint(Component):
    """Quickest move by `distance` within limits of speed and acceleration, from `start_time` on.

    Acceleration `a`, speed ``v`` (a trapezoid, or a triangle where the way is short) and position
    ``s``: ``der(s) = v``, ``der(v) = a``. All have the units of the distance.
    """

    symbol = "ramp"
    distance: Param = param("1", "way of the move, either sign")
    v_max: Param = param("1/s", "greatest speed", above=0)
    a_max: Param = param("1/s2", "greatest acceleration and deceleration", above=0)
    start_time: Param = param("s", "begin of the move", 0.0)
    a = Output("1/s2", "acceleration")
    v = Output("1/s", "speed")
    s = Output("1", "way since the begin")

    def equations(self) -> Iterator[Equation]:
        way = maximum(self.distance, -self.distance)
        up = minimum(self.v_max / self.a_max, sqrt(way / self.a_max))
        down = maximum(way / self.v_max, up)
        begin, a = self.start_time, sign(self.distance) * self.a_max

        def pulse(since: Expr) -> tuple[Expr, Expr, Expr]:
            """One acceleration for the time `up`, and its first and second integral."""
            on = where(time >= since + up, 0, where(time >= since, 1, 0))
            run = where(time >= since + up, up, where(time >= since, time - since, 0))
            after = where(time >= since + up, time - since - up, 0)
            return on, run, run**2 / 2 + up * after

        rise, fall = pulse(begin), pulse(begin + down)
        for output, first, second in zip((self.a, self.v, self.s), rise, fall, strict=True):
            yield output == a * (first - second)
