"""Wind: gusts, turbulence of a spectrum, and the torque of a wind turbine's rotor.

Source: IEC 61400-1:2005 (extreme operating gust, Kaimal's spectrum); Kaimal et al., Quarterly
Journal of the Royal Meteorological Society 98 (1972) 563.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Input, Param, Var, der, param, time, var
from lumped.components.rows import check_ascending, check_rows
from lumped.errors import OptionError
from lumped.language.validity import Range
from lumped.language.value_types import Rows
from lumped.ops import cos, interpolate, maximum, pi, sin, where
from lumped.support.arguments import checked

__all__ = ["WindRotor", "extreme_gust", "operating_gust", "turbulence"]


class WindRotor(Component):
    """Torque of the wind on the rotor of a turbine: ``tau = rho/2 pi R^3 v^2 c_p(x) / x``.

    ``x = w R / v`` is the tip speed ratio. `coefficients` are rows of it, from above zero up, and
    the power coefficient c_p. Between them the torque coefficient ``c_p / x`` follows straight
    lines, and below the first row it stays. A run that leaves the last row, as one without wind
    does, ends with an error.
    """

    symbol = "load"
    flange = Flange()
    support = Flange(grounded=True)
    coefficients: Rows = ()
    R: Param = param("m", "radius of the rotor", above=0)
    rho: Param = param("kg/m3", "density of the air", 1.225, min=0)
    v: Input = Input("m/s", "speed of the wind, above zero", min=0)
    w: Var = var("rad/s", "speed relative to the support")
    x: Var = var("1", "tip speed ratio")
    tau: Var = var("N.m", "driving torque")

    def equations(self) -> Iterator[Equation]:
        rows = self._rows()
        yield self.w == der(self.flange.phi - self.support.phi)
        yield self.x == self.w * self.R / self.v
        ratios, values = [x for x, _ in rows], [c_p / x for x, c_p in rows]
        c_q = interpolate(maximum(self.x, ratios[0]), ratios, values)
        yield self.tau == self.rho / 2 * pi * self.R**3 * self.v**2 * c_q
        yield self.flange.tau == -self.tau
        yield self.support.tau == self.tau

    def valid(self) -> Iterator[Range]:
        last = self._rows()[-1][0]
        most = float("inf")
        hint = "Give a speed above zero, along the axis"
        yield Range(self.v, 0.0, most, "m/s", "speed of the wind", hint)
        hint = "Give more rows of coefficients, or wind above zero"
        yield Range(self.x, -most, last, "1", "tip speed ratio", hint)

    def _rows(self) -> list[tuple[float, ...]]:
        what = "tip speed ratio and power coefficient"
        rows = check_rows("coefficients", self.coefficients, what, "((4, 0.2), (7, 0.45))")
        check_ascending("coefficients", "tip speed ratios from zero", [0.0, *(x for x, _ in rows)])
        return rows


@checked
def operating_gust(v: float, v_gust: float, begin: float = 0.0, duration: float = 10.5) -> Expr:
    """Wind with one gust: ``v - 0.37 v_gust sin(3 pi t / T) (1 - cos(2 pi t / T))``.

    The wind falls, rises and falls again, and is `v` before and after it (IEC 61400-1, extreme
    operating gust).

    Parameters
    ----------
    v : float
        Steady speed at the hub, m/s.
    v_gust : float
        Size of the gust, m/s; by class from `extreme_gust`.
    begin, duration : float
        Of the gust, s.

    Returns
    -------
    Expr
        Over `lumped.time`, m/s.
    """
    _positive(v=v, v_gust=v_gust, duration=duration)
    t = time - begin
    dip = 0.37 * v_gust * sin(3 * pi / duration * t) * (1 - cos(2 * pi / duration * t))
    return v - where(t > 0, where(t < duration, dip, 0.0), 0.0)


@checked
def extreme_gust(v: float, V_ref: float, I_ref: float, D: float, z: float) -> float:
    """Size of the extreme operating gust of IEC 61400-1, m/s.

    ``min(1.35 (0.8 1.4 V_ref - v), 3.3 sigma / (1 + 0.1 D / Lambda))`` with
    ``sigma = I_ref (0.75 v + 5.6)`` and ``Lambda = 0.7 z``, at most 42 m.

    Parameters
    ----------
    v : float
        Steady speed at the hub, m/s.
    V_ref, I_ref : float
        Reference wind speed, m/s, and turbulence intensity of the class, such as 50 and 0.16.
    D, z : float
        Diameter of the rotor and height of the hub, m.

    Returns
    -------
    float
    """
    _positive(v=v, V_ref=V_ref, I_ref=I_ref, D=D, z=z)
    if v >= 0.8 * 1.4 * V_ref:
        raise OptionError(
            f"v = {v:g} m/s: gusts are given below the extreme speed of a year, 0.8 1.4 V_ref = "
            f"{0.8 * 1.4 * V_ref:g} m/s."
        )
    sigma = I_ref * (0.75 * v + 5.6)
    return min(1.35 * (0.8 * 1.4 * V_ref - v), 3.3 * sigma / (1 + 0.1 * D / _scale(z)))


@checked
def turbulence(
    v: float, sigma: float, z: float, duration: float, step: float, seed: int = 0
) -> tuple[list[float], list[float]]:
    """Times and speeds of a turbulent wind, to be given to `Table`.

    The sum of harmonics of ``1 / duration`` with the amplitudes ``sqrt(2 S df)`` of Kaimal's
    spectrum, ``S = 4 sigma^2 L / v / (1 + 6 f L / v)^(5/3)``, with ``L = 8.1 0.7 z`` and at most
    60 m for z, and random phases (Shinozuka and Jan, J. Sound Vib. 25 (1972) 111). Its mean is
    `v`, its variance the sum of ``S df``: a little less than ``sigma^2``, whose rest lies below and
    above these frequencies. It repeats after `duration`.

    Parameters
    ----------
    v, sigma : float
        Mean and standard deviation of the speed, m/s.
    z : float
        Height of the hub, m.
    duration, step : float
        Of the series, s; the duration is an even multiple of the step.
    seed : int
        Of the phases.

    Returns
    -------
    tuple of list of float
        ``duration / step + 1`` times, s, and speeds, m/s.
    """
    from lumped.numerics.harmonics import make_series

    _positive(v=v, sigma=sigma, z=z, duration=duration, step=step)
    n = round(duration / step)
    if n < 4 or n % 2 or abs(n * step - duration) > 1e-9 * duration:
        raise OptionError(
            f"turbulence: duration = {duration:g} s must be an even multiple, 4 at least, of the "
            f"step of {step:g} s."
        )
    L, df = 8.1 * _scale(z), 1 / duration
    amplitudes = []
    for i in range(1, n // 2):
        S = 4 * sigma**2 * L / v / (1 + 6 * i * df * L / v) ** (5 / 3)
        amplitudes.append((2 * S * df) ** 0.5)
    speeds = [v + part for part in make_series(amplitudes, n, seed)]
    return [i * step for i in range(n + 1)], [*speeds, speeds[0]]


def _scale(z: float) -> float:
    """Longitudinal scale of turbulence, m."""
    return 0.7 * min(z, 60.0)


def _positive(**values: float) -> None:
    for name, value in values.items():
        if not 0 < value < float("inf"):
            raise OptionError(f"{name} = {value:g}: a positive, finite number is needed.")
