"""Damage by the incomplete gamma function, and by quadrature.

At one slope m, with ``L = ln n``: ``(S/S_k)^m / N_k (1 + n L^(-m/k) gamma(1 + m/k, L))``, the first
1 being the largest cycle.
"""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import gamma, gammainc

from lumped.errors import OptionError
from lumped.life import SNCurve, goodman, weibull_cycles


@pytest.mark.parametrize("shape", [0.75, 1.0, 1.4])
@pytest.mark.parametrize("slope", [3.0, 5.0, 8.0])
def test_damage_is_the_incomplete_gamma_function(shape, slope):
    n, largest = 6e6, 250e6
    curve = SNCurve(knee=100e6, cycles=2e6, slope=slope, below="elementary")
    length, power = np.log(n), slope / shape
    tail = gammainc(1 + power, length) * gamma(1 + power) / length**power
    wanted = (largest / 100e6) ** slope / 2e6 * (1 + n * tail)
    found = weibull_cycles(largest, cycles=n, shape=shape)
    assert found.damage(curve) == pytest.approx(wanted, rel=2e-5)
    assert found.total == pytest.approx(n, rel=1e-12)


def test_an_amplitude_is_reached_as_often_as_the_distribution_says():
    """With the shape 1 half of the largest amplitude is reached ``sqrt(n)`` times."""
    found = weibull_cycles(80.0, cycles=1e6)
    assert found.ranges.max() == 160.0
    assert found.counts[found.ranges > 80.0].sum() == pytest.approx(1e3, rel=1e-12)
    steep = weibull_cycles(80.0, cycles=1e6, shape=2.0)
    reached = steep.counts[steep.ranges > 80.0 * np.sqrt(2.0)].sum()
    assert reached == pytest.approx(1e3, rel=1e-12)


def test_two_slopes_and_means_count_as_in_the_integral():
    """Against quadrature over ``ln N``: Haibach below the knee, Goodman with a mean of 20 MPa."""
    n, largest, mean, ultimate = 1e6, 300e6, 20e6, 600e6
    curve = SNCurve(knee=90e6, cycles=1e6, slope=4.0, below="haibach")

    def share(amplitude):
        equal = amplitude / (1 - mean / ultimate) / 90e6
        return equal ** (4.0 if equal >= 1 else 7.0) / 1e6

    def of_log(u):
        return np.exp(u) * share(largest * (1 - u / np.log(n)))

    knee = np.log(n) * (1 - 90e6 * (1 - mean / ultimate) / largest)
    whole = quad(of_log, 0, knee, epsrel=1e-12)[0] + quad(of_log, knee, np.log(n), epsrel=1e-12)[0]
    found = weibull_cycles(largest, cycles=n, mean=mean)
    damage = found.damage(curve, mean_stress=goodman(ultimate))
    assert damage == pytest.approx(share(largest) + whole, rel=1e-4)


def test_a_load_without_history_has_no_turning_points():
    assert repr(weibull_cycles(80.0, cycles=1e6)).startswith("1e+06 cycles\n")


@pytest.mark.parametrize(
    ("largest", "options"),
    [(-1.0, {"cycles": 1e6}), (1.0, {"cycles": 1.0}), (1.0, {"cycles": 1e6, "shape": 0.0})],
)
def test_slips_are_named(largest, options):
    with pytest.raises(OptionError, match=r"must be positive, and cycles = .* above 1\."):
        weibull_cycles(largest, **options)
