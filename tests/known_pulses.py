"""Pulses of time with closed forms: where they reach a level, and their areas."""

import numpy as np
from scipy.optimize import brentq
from scipy.special import erf

from lumped.ops import exp, interpolate, tanh


class Shape:
    """A pulse of height one; `u` is the time from its middle over its length.

    `law` is the expression of `lumped`, `area` the integral from the far left, `whole` all of it,
    `reached` the distance from its middle at which the pulse is so many times as low.
    """

    def stops(self, times, begin):
        """When what it moves from `begin` on, against a friction so many times as low, stops."""

        def momentum(u):
            return times * (self.area(u) - self.area(begin)) - (u - begin)

        return brentq(momentum, -begin, -begin + times * self.whole + 1, xtol=1e-14, rtol=1e-14)


class Gaussian(Shape):
    whole = np.sqrt(np.pi)

    def law(self, u):
        return exp(-(u**2))

    def area(self, u):
        return np.sqrt(np.pi) / 2 * (1 + erf(u))

    def reached(self, times):
        return np.sqrt(np.log(times))


class Lorentzian(Shape):
    whole = np.pi

    def law(self, u):
        return 1 / (1 + u**2)

    def area(self, u):
        return np.pi / 2 + np.arctan(u)

    def reached(self, times):
        return np.sqrt(times - 1)


class Triangle(Shape):
    whole = 1.0

    def law(self, u):
        return interpolate(u, [-2.0, -1.0, 0.0, 1.0, 2.0], [0.0, 0.0, 1.0, 0.0, 0.0])

    def area(self, u):
        x = np.clip(u, -1.0, 1.0)
        return 0.5 + x - x * np.abs(x) / 2

    def reached(self, times):
        return 1 - 1 / times


class Product(Shape):
    """``(1 + tanh u) (1 - tanh u)``."""

    whole = 2.0

    def law(self, u):
        return (1 + tanh(u)) * (1 - tanh(u))

    def area(self, u):
        return 1 + np.tanh(u)

    def reached(self, times):
        return np.arccosh(np.sqrt(times))


PULSES = Gaussian(), Lorentzian(), Triangle(), Product()
