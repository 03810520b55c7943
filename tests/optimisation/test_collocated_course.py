"""Design optimisation of runs with states against closed forms and SciPy."""

import numpy as np
import pytest
from optimised_drives import PERIOD, A, D, J, W, pushed, two_bodies
from rows import in_a_row
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

import lumped as lp
from lumped import functionals as fun
from lumped.components import Brake, Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptionError


def torque_rms(J, d):
    """Of the spring's torque in `two_bodies`, by SciPy's integrator with the square as a state."""

    def rates(t, y, tau):
        w_a, w_b, phi, _ = y
        torque = 100.0 * phi + d * (w_b - w_a)
        return [(tau + torque) / J, (-torque - 0.7 * w_b) / 2.0, w_b - w_a, torque**2]

    y = np.zeros(4)
    for tau in (10.0, 0.0):
        y = solve_ivp(rates, (0, 0.5), y, "DOP853", args=(tau,), rtol=1e-12, atol=1e-13).y[:, -1]
    return np.sqrt(y[3])


@pytest.mark.parametrize("intervals", [5, 20])
def test_the_objective_told_is_that_of_the_run_however_few_the_intervals(intervals):
    run = lp.simulate(two_bodies(), until=1.0)
    found = lp.optimise(
        run,
        vary={"s.d": (0.0, 20.0), "a.J": (0.1, 3.0)},
        minimise=fun.rms("s.tau"),
        intervals=intervals,
    )
    expected = torque_rms(found.parameters["a.J"], found.parameters["s.d"])
    assert found.objective == pytest.approx(expected, rel=1e-9)
    assert found.values[fun.rms("s.tau")] == found.objective
    # what is told is the distance of the programme, scaled by the start, from the run
    y = run["s.tau"]
    mean = np.sqrt(np.mean(y**2))
    promised = found.solution.objective * 0.5 * (np.abs(y).max() ** 2 / mean + mean)
    assert found.error == pytest.approx(abs(promised / expected - 1), rel=1e-3, abs=1e-10)


class TestStates:
    def test_torque_that_reaches_a_speed(self):
        T, speed = 0.7, 4.0
        run = lp.simulate(pushed(1.0), until=T)
        found = lp.optimise(
            run,
            vary={"motor.tau": (0, 100)},
            minimise={"motor.tau": 1.0},
            subject_to=fun.final("body.w") >= speed,
            intervals=20,
        )
        expected = speed * D / (1 - np.exp(-D * T / J))
        assert found.parameters["motor.tau"] == pytest.approx(expected, rel=1e-8)
        assert found.run["body.w"][-1] == pytest.approx(speed, rel=1e-7)
        assert found.error < 1e-7

    def test_parts_between_jumps_of_time(self):
        """The torque acts from 0.3 s on; the mean speed is that of the closed form."""
        T, begin = 1.0, 0.3
        model = in_a_row(
            motor=Torque(tau=lp.ops.where(lp.time >= begin, 6.0, 0.0)),
            body=Inertia(J=J),
            oil=Damper(d=D),
            ground=Fixed(),
        )
        run = lp.simulate(lp.assemble(model), until=T)
        found = lp.optimise(
            run,
            vary={"body.J": (0.01, 50)},
            minimise={"body.J": -1.0},
            subject_to=fun.mean("body.w") >= 0.5,
        )
        t, J_found = T - begin, found.parameters["body.J"]
        way = 6 / D * (t - J_found / D * (1 - np.exp(-D * t / J_found)))
        assert way / T == pytest.approx(0.5, rel=1e-7)

    def test_periodic_run_of_an_oscillator(self):
        """Torque into the ground of a shaken body, from the frequency response."""
        model = in_a_row(
            motor=Torque(tau=A * lp.ops.sin(W * lp.time)),
            body=Inertia(J=J),
            mount=SpringDamper(c=10.0, d=D),
            ground=Fixed(),
        )
        run = lp.simulate(lp.assemble(model), until=PERIOD)
        k = 5e-3  # a stiff mount is wanted too
        found = lp.optimise(
            run,
            vary={"mount.c": (1, 40)},
            minimise={fun.rms("mount.tau"): 1.0, "mount.c": -k},
            periodic=True,
            intervals=40,
        )

        def cost(c):
            mount = c + 1j * D * W
            return A * abs(mount / (mount - J * W**2)) / np.sqrt(2) - k * c

        best = minimize_scalar(cost, bounds=(1, 40), method="bounded", options={"xatol": 1e-9})
        assert 2 < best.x < 39
        assert found.parameters["mount.c"] == pytest.approx(best.x, rel=1e-5)
        assert found.objective == pytest.approx(best.fun, rel=1e-5)
        assert found.run["body.w"][-1] == pytest.approx(found.run["body.w"][0], abs=1e-7)

    def test_runs_with_events_are_refused_by_name(self):
        model = in_a_row(body=Inertia(J=J, w=5.0), brake=Brake(f_max=20.0, u=1.0))
        run = lp.simulate(lp.assemble(model), until=2.0)
        with pytest.raises(OptionError, match=r"brake changes .*single shooting"):
            lp.optimise(run, vary={"body.J": (1, 3)}, minimise=fun.rms("body.w"))

    def test_start_values_that_move_are_refused(self):
        class Flung(lp.Component):
            w_0: lp.Param = lp.param("rad/s", "speed at the start", 3.0)
            body: Inertia = Inertia(J=J, w=2 * w_0)
            oil: Damper = Damper(d=D)
            ground: Fixed = Fixed()

            def connections(self):
                yield from lp.chain(self.body, self.oil, self.ground)

        run = lp.simulate(lp.assemble(Flung()), until=1.0)
        with pytest.raises(OptionError, match=r"start value of body\.w depends on w_0"):
            lp.optimise(run, vary={"w_0": (1, 3)}, minimise=fun.rms("body.w"))
