"""Choice of a coupling by hand."""

import pytest

from lumped.errors import OptionError
from lumped.life import Coupling, choose_coupling

SIZES = [
    Coupling("C", "100 kN.m", "1500 rpm"),
    Coupling("A", "40 kN.m", "3000 rpm"),
    Coupling("B", "63 kN.m", "2000 rpm"),
]
RPM = 3.141592653589793 / 30


def test_the_least_that_carries_the_torque_with_its_service_factor():
    """9550 x 1000 kW / 300 rpm = 31.83 kN.m; times 1.5 it is 47.75 kN.m, which is beyond A."""
    found = choose_coupling(SIZES, torque=1e6 / (300 * RPM), speed=300 * RPM, service=1.5)
    assert found.coupling.name == "B"
    assert found.needed == pytest.approx(9.5493 * 1e6 / 300 * 1.5, rel=1e-5)
    assert found.margin == pytest.approx(63e3 / 47.7465e3, rel=1e-5)
    assert "63000" in repr(found)


def test_the_correction_of_the_speed_may_ask_for_the_next_size():
    """At half the permitted speed K_n is halfway between 1 and 0.8: 0.9 x 63 kN.m = 56.7 kN.m."""
    given = {"speed": 1000 * RPM, "correction": [(0.0, 1.0), (1.0, 0.8)]}
    assert choose_coupling(SIZES, torque=56e3, **given).permitted == pytest.approx(56.7e3)
    assert choose_coupling(SIZES, torque=57e3, **given).coupling.name == "C"


def test_a_coupling_that_turns_too_fast_is_passed_over():
    assert choose_coupling(SIZES, torque=10e3, speed=1800 * RPM).coupling.name == "A"
    with pytest.raises(OptionError, match="no coupling carries 80000 N"):
        choose_coupling(SIZES, torque=80e3, speed=1800 * RPM)


def test_what_makes_no_sense_is_refused():
    with pytest.raises(OptionError, match="must be positive"):
        choose_coupling(SIZES, torque=0.0, speed=1.0)
    with pytest.raises(OptionError, match=r"torque = -5 N\.m must be positive"):
        Coupling("X", -5.0, 1.0)
