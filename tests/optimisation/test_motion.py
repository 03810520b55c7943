"""Optimal motions against the calculus of variations."""

import numpy as np
import pytest
from rows import assemble_row, in_a_row

import lumped as lp
from lumped.components import Damper, Fixed, Inertia, SpringDamper, SwingingMass, Torque
from lumped.errors import OptimisationError, OptionError, UnknownNameError

J, D, H, T = 0.5, 0.8, 1.5, 0.7


def rig(d=0.0, keep=("load.phi",)):
    parts = {"motor": Torque(tau=0), "load": Inertia(J=J)}
    if d:
        parts |= {"oil": Damper(d=d), "housing": Fixed()}
    return lp.start_point(assemble_row(**parts, keep=keep))


def least(point, functional=lp.functionals.rms, **options):
    given = {"stations": {"load.phi": (0, H)}, "duration": T, "drive": "motor.tau"} | options
    return lp.optimisation.motion(point, minimise=functional("motor.tau"), **given)


class TestClosedForm:
    def test_inertia_takes_a_parabola_of_speed(self):
        found = least(rig())
        t = found.t
        assert np.abs(found["load.w"] - 6 * H * t * (T - t) / T**3).max() < 1e-10 * H / T
        assert found.objective == pytest.approx(np.sqrt(12) * J * H / T**2, rel=1e-10)
        assert found.solution.residual < 1e-8

    def test_oil_makes_it_a_hyperbolic_cosine(self):
        """``J^2 w'' - d^2 w`` is constant (Euler and Lagrange), w is zero at both ends."""
        found, k = least(rig(D), intervals=30), D / J
        shape = 1 - np.cosh(k * (found.t - T / 2)) / np.cosh(k * T / 2)
        way = T - 2 * np.tanh(k * T / 2) / k
        assert np.abs(found["load.w"] - H / way * shape).max() < 1e-7 * H / T

    def test_limit_of_speed(self):
        """Acceleration falls evenly to zero where the speed reaches its limit."""
        V = 2.6
        found = least(rig(), limits={"load.w": (None, V)}, intervals=200)
        ramp = 1.5 * (T - H / V)
        t = np.minimum(found.t, T - found.t)
        speed = np.where(t < ramp, V * (1 - (1 - t / ramp) ** 2), V)
        assert np.abs(found["load.w"] - speed).max() < 1e-4 * V
        expected = J * np.sqrt(8 * V**2 / (3 * ramp) / T)
        assert found.objective == pytest.approx(expected, rel=1e-5)
        assert found["load.w"].max() <= V * (1 + 1e-8)
        assert found.limits == ("load.w",)

    def test_least_peak_is_bang_bang(self):
        found = least(rig(), lp.functionals.peak)
        assert found.objective == pytest.approx(4 * J * H / T**2, rel=1e-6)

    def test_limit_of_torque_just_allows_it(self):
        least_peak = 4 * J * H / T**2
        found = least(rig(), limits={"motor.tau": (-1.02 * least_peak, 1.02 * least_peak)})
        assert np.abs(found["motor.tau"]).max() <= 1.02 * least_peak * (1 + 1e-9)
        with pytest.raises(OptimisationError, match="Worst violated: "):
            least(rig(), limits={"motor.tau": (-0.9 * least_peak, 0.9 * least_peak)})

    def test_gravity_is_carried(self):
        """A horizontal weight that shall stay: to first order no swing changes its moment."""
        model = in_a_row(motor=Torque(tau=0), arm=SwingingMass(m=2.0, R=0.5, J=0.1, g=9.81))
        point = lp.start_point(lp.assemble(model, keep=["arm.phi"]))
        found = least(point, stations={"arm.phi": (0.0, 0.0)}, intervals=5)
        assert found.objective == pytest.approx(2.0 * 0.5 * 9.81, rel=1e-9)

    def test_two_phases_share_the_time(self):
        """Double inertia in the second half: each phase is a cubic, times are found by search."""
        point = rig()
        heavy = lp.start_point(point.system, parameters={"load.J": 2 * J})
        found = least([point, heavy], stations={"load.phi": (0, H / 2, H)}, intervals=20)

        def cost(t, v):
            """Integral of tau^2 for a rest-to-v and a v-to-rest move of H/2 each."""

            def move(J_, T_, v0, v1):
                a0, a1 = (
                    6 * H / 2 / T_**2 - (4 * v0 + 2 * v1) / T_,
                    -6 * H / 2 / T_**2 + (2 * v0 + 4 * v1) / T_,
                )
                return J_**2 * T_ * (a0**2 + a0 * a1 + a1**2) / 3

            return move(J, t, 0, v) + move(2 * J, T - t, v, 0)

        t, v = np.meshgrid(np.linspace(0.2, 0.5, 601), np.linspace(0.5, 6, 1101))
        best = np.sqrt(cost(t, v).min() / T)
        assert found.objective == pytest.approx(best, rel=1e-5)
        assert found.stations[1] == pytest.approx(t.ravel()[cost(t, v).argmin()], abs=1e-3)


def test_profile_goes_into_inverse():
    point = rig()
    found = least(point)
    run = lp.inverse(
        point.system,
        motion={"load.w": found.profile("load.w")},
        drive="motor.tau",
        until=T,
        grid=2000,
    )
    square = np.trapezoid(run["motor.tau"] ** 2, run.t) / T
    assert np.sqrt(square) == pytest.approx(found.objective, rel=1e-4)
    assert run["load.phi"][-1] - run["load.phi"][0] == pytest.approx(H, rel=1e-4)


def test_elastic_drive_comes_to_rest_without_swinging_on():
    model = in_a_row(
        motor=Torque(tau=0),
        rotor=Inertia(J=0.1),
        shaft=SpringDamper(c=40.0, d=0.0),
        load=Inertia(J=0.3),
    )
    point = lp.start_point(lp.assemble(model, keep=["load.phi"]))
    found = least(point, intervals=40)
    for name in ("rotor.w", "load.w", "shaft.phi_rel"):
        assert abs(found[name][0]) < 1e-8
        assert abs(found[name][-1]) < 1e-8
    # the rigid drive of the same inertia has the least mean square of all
    rigid = np.sqrt(12) * 0.4 * H / T**2
    assert found.objective > rigid * (1 - 1e-9)
    assert found.objective < 1.5 * rigid


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"drive": "load.w"}, OptionError, "no input that is given"),
        ({"stations": {"load.phi": (0, 1, 2)}}, OptionError, "3 stations of load.phi, 1 phases"),
        ({"stations": {}}, OptionError, "one position"),
        ({"duration": -1.0}, OptionError, "must be positive"),
        ({"limits": {"load.w": (2, 1)}}, OptionError, r"bounds of load\.w"),
        ({"limits": {"load.v": (2, 3)}}, UnknownNameError, "load"),
        ({"limits": {"load.w": (None, 2.0)}}, OptimisationError, "Worst violated"),
    ],
)
def test_bad_input_is_named(options, error, text):
    with pytest.raises(error, match=text):
        least(rig(), **options)


def test_position_left_out_is_asked_for():
    with pytest.raises(UnknownNameError, match="Ask for it"):
        least(rig(keep=()))


@pytest.mark.parametrize(
    ("points", "options", "text"),
    [([], {}, "an operating point for each phase"), (None, {"intervals": 0}, "intervals = 0")],
)
def test_a_motion_of_nothing_is_refused(points, options, text):
    with pytest.raises(OptionError, match=text):
        least(rig() if points is None else points, **options)
