"""Design optimisation against closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

import lumped as lp
from lumped import functionals as fun
from lumped.components import (
    Brake,
    Damper,
    Fixed,
    IdealGear,
    Inertia,
    Position,
    Speed,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.errors import OptimisationError, OptionError, UnknownNameError

J, D, A, W = 2.0, 3.0, 0.4, 5.0
PERIOD = 2 * np.pi / W


def shaken(c=10.0):
    """Body, spring and damper to ground that a drive shakes: ``tau = J phi'' + d phi' + c phi``."""
    model = lp.compose(
        drive=Position(phi=A * lp.ops.sin(W * lp.time)),
        body=Inertia(J=J),
        spring=Spring(c=c),
        oil=Damper(d=D),
        ground=Fixed(),
        connections=lambda m: [
            lp.connect(m.drive.flange, m.body.flange_a, m.spring.flange_a, m.oil.flange_a),
            lp.connect(m.spring.flange_b, m.oil.flange_b, m.ground.flange),
        ],
    )
    return lp.simulate(lp.assemble(model), until=PERIOD, grid=400)


TAU = "drive.flange.tau"
BEST = J * W**2  # the spring that cancels the inertia
LEAST = A * D * W  # amplitude that is left for the damper


class TestPrescribedMotion:
    @pytest.mark.parametrize(
        ("functional", "factor", "grid"),
        [(fun.rms, np.sqrt(0.5), 1e-7), (fun.peak, 1.0, 5e-5), (fun.swing, 2.0, 5e-5)],
    )
    def test_spring_cancels_the_inertia(self, functional, factor, grid):
        """A crest between two of the 400 instants is missed by ``(w dt)^2 / 8`` at most."""
        found = lp.optimise(shaken(), vary={"spring.c": (1, 1000)}, minimise=functional(TAU))
        # the design is where two such crests are equal: that error over the slope, d w / c
        assert found.parameters["spring.c"] == pytest.approx(BEST, rel=20 * grid)
        assert found.objective == pytest.approx(factor * LEAST, rel=grid)
        assert found.objective == found.values[functional(TAU)]
        # values are those at the instants; how far they are from those between is told
        true = factor * A * np.hypot(found.parameters["spring.c"] - BEST, D * W)
        assert found.error == pytest.approx(abs(found.objective / true - 1), rel=1e-2, abs=1e-9)
        assert found.solution.residual < 1e-7
        assert found.error < grid
        assert found.active == ()

    def test_weighted_sum_of_torque_and_stiffness(self):
        """``d/dc (rms + k c) == 0`` with rms = A/sqrt(2) sqrt((c - J w^2)^2 + (d w)^2)."""
        k = 0.1
        slope = k / (A / np.sqrt(2))
        expected = BEST - D * W * slope / np.sqrt(1 - slope**2)
        found = lp.optimise(
            shaken(),
            vary={"spring.c": (1, 1000)},
            minimise={fun.rms(TAU): 1.0, "spring.c": k},
        )
        assert found.parameters["spring.c"] == pytest.approx(expected, rel=1e-6)

    def test_bound_of_a_quantity_holds_at_all_instants(self):
        """The spring's torque has the amplitude ``c A``."""
        found = lp.optimise(
            shaken(),
            vary={"spring.c": (1, 1000)},
            minimise=fun.rms(TAU),
            subject_to={"spring.tau": (-8.0, None)},
        )
        assert found.parameters["spring.c"] == pytest.approx(8.0 / A, rel=1e-6)
        assert found.active == ("spring.tau",)

    def test_bound_of_a_parameter_and_of_a_functional(self):
        low = lp.optimise(shaken(), vary={"spring.c": (1, 30)}, minimise=fun.rms(TAU))
        assert low.parameters["spring.c"] == pytest.approx(30, rel=1e-8)
        assert low.active == ("spring.c at its upper bound",)
        bound = 1.5 * LEAST
        soft = lp.optimise(
            shaken(),
            vary={"spring.c": (1, 1000)},
            minimise={"spring.c": 1.0},
            subject_to={fun.peak(TAU): (None, bound)},
        )
        expected = BEST - np.sqrt((bound / A) ** 2 - (D * W) ** 2)
        assert soft.parameters["spring.c"] == pytest.approx(expected, rel=1e-4)  # crests, see above
        assert soft.active == ("peak(drive.flange.tau)",)

    def test_all_torque_can_vanish(self):
        """The root mean square has a kink where it is zero."""
        found = lp.optimise(
            shaken(),
            vary={"spring.c": (1, 1000), "oil.d": (0, 10)},
            minimise=fun.rms(TAU),
        )
        assert found.parameters["spring.c"] == pytest.approx(BEST, rel=1e-5)
        assert found.objective < 1e-5 * LEAST

    def test_inverse_dynamics(self):
        """Least mean square of ``J_a i^2 a + J_b a``'s motor torque over the ratio of a gear."""
        J_a, J_b = 0.02, 3.0
        rig = lp.compose(
            motor=Torque(tau=0),
            rotor=Inertia(J=J_a),
            gear=IdealGear(ratio=4),
            table=Inertia(J=J_b),
            connections=lambda m: lp.chain(m.motor, m.rotor, m.gear, m.table),
        )
        move = lp.profiles.polynomial5(distance=1.0, duration=0.5)
        run = lp.inverse(
            lp.assemble(rig),
            motion={"table.phi": lp.profiles.path(move)},
            drive="motor.tau",
            until=0.5,
        )
        found = lp.optimise(run, vary={"gear.ratio": (1, 100)}, minimise=fun.rms("motor.tau"))
        assert found.parameters["gear.ratio"] == pytest.approx(np.sqrt(J_b / J_a), rel=1e-6)


class TestPareto:
    def test_front_is_the_closed_form_and_falls(self):
        """Torque against stiffness: ``rms = A/sqrt(2) sqrt((c - J w^2)^2 + (d w)^2)``."""
        front = lp.optimisation.pareto(
            shaken(30.0),
            vary={"spring.c": (20, 1000)},
            minimise=(fun.rms(TAU), fun.peak("spring.tau")),
            count=7,
        )
        rms, torque = front.values.T
        assert np.all(np.diff(rms) > 0)
        assert np.all(np.diff(torque) < 0)
        c = torque / A
        expected = A / np.sqrt(2) * np.hypot(c - BEST, D * W)
        assert np.abs(rms / expected - 1).max() < 1e-6
        assert c[0] == pytest.approx(BEST, rel=1e-3)
        assert c[-1] == pytest.approx(20, rel=1e-6)
        assert np.abs(np.diff(torque, 2)).max() < 1e-6 * torque[0]

    def test_it_needs_two(self):
        with pytest.raises(OptionError, match="two different functionals"):
            lp.optimisation.pareto(
                shaken(),
                vary={"spring.c": (1, 99)},
                minimise=(fun.rms(TAU), fun.rms(TAU)),
            )
        with pytest.raises(OptionError, match="at least two designs"):
            lp.optimisation.pareto(
                shaken(),
                vary={"spring.c": (1, 99)},
                minimise=(fun.rms(TAU), fun.peak(TAU)),
                count=1,
            )

    def test_aims_that_agree_have_one_design(self, capfd):
        """Both least at the largest inertia: ``w(T) = tau / d (1 - exp(-d T / J))``."""
        T = 0.7
        run = lp.simulate(pushed(1.0), until=T)
        front = lp.optimisation.pareto(
            run,
            vary={"body.J": (0.5, 5.0)},
            minimise=(fun.final("body.w"), fun.mean("body.w")),
            intervals=20,
        )
        (design,) = front.designs
        assert design.parameters["body.J"] == pytest.approx(5.0, rel=1e-6)
        decay = 1 - np.exp(-D * T / 5.0)
        expected = [decay / D, (T - 5.0 / D * decay) / D / T]
        assert front.values[0] == pytest.approx(expected, rel=1e-6)
        assert "both are least in one design" in repr(front)
        # nothing of the libraries below, as of a matrix that is singular
        assert capfd.readouterr().err == ""

    def test_a_search_that_fails_from_the_design_before_begins_at_the_other_end(self):
        """Two masses of which the first shall be slow, though the second is pulled by it."""
        run = lp.simulate(two_bodies(), until=1.0)
        front = lp.optimisation.pareto(
            run,
            vary={"s.d": (0.0, 20.0), "a.J": (0.1, 3.0)},
            minimise=(fun.final("b.w"), fun.final("a.w")),
            intervals=10,
            count=4,
        )
        first, second = front.values.T
        assert (np.diff(first) > 0).all()
        assert (np.diff(second) < 0).all()


def two_bodies():
    """A torque that ends at 0.5 s on two bodies joined by a spring, in oil."""
    return lp.assemble(
        lp.compose(
            t=Torque(tau=10 * lp.ops.where(lp.time >= 0.5, 0.0, 1.0)),
            a=Inertia(J=0.5),
            s=SpringDamper(c=100.0, d=0.2),
            b=Inertia(J=2.0),
            oil=Damper(d=0.7),
            wall=Fixed(),
            connections=lambda m: lp.chain(m.t, m.a, m.s, m.b, m.oil, m.wall),
        )
    )


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
    print(f"{found.objective / expected - 1:.1e}, told of the programme: {found.error:.1e}")
    assert found.objective == pytest.approx(expected, rel=1e-9)
    assert found.values[fun.rms("s.tau")] == found.objective
    # what is told is the distance of the programme, scaled by the start, from the run
    promised = found.solution.objective * np.abs(run["s.tau"]).max()
    assert found.error == pytest.approx(abs(promised / expected - 1), rel=1e-3, abs=1e-10)


def pushed(torque, **body):
    """Body in oil under a torque: ``J w' + d w == tau``."""
    model = lp.compose(
        motor=Torque(tau=torque),
        body=Inertia(J=J, **body),
        oil=Damper(d=D),
        ground=Fixed(),
        connections=lambda m: lp.chain(m.motor, m.body, m.oil, m.ground),
    )
    return lp.assemble(model)


class TestStates:
    def test_torque_that_reaches_a_speed(self):
        T, speed = 0.7, 4.0
        run = lp.simulate(pushed(1.0), until=T)
        found = lp.optimise(
            run,
            vary={"motor.tau": (0, 100)},
            minimise={"motor.tau": 1.0},
            subject_to={fun.final("body.w"): (speed, None)},
            intervals=20,
        )
        expected = speed * D / (1 - np.exp(-D * T / J))
        assert found.parameters["motor.tau"] == pytest.approx(expected, rel=1e-8)
        assert found.run["body.w"][-1] == pytest.approx(speed, rel=1e-7)
        assert found.error < 1e-7

    def test_parts_between_jumps_of_time(self):
        """The torque acts from 0.3 s on; the mean speed is that of the closed form."""
        T, begin = 1.0, 0.3
        model = lp.compose(
            motor=Torque(tau=lp.ops.where(lp.time >= begin, 6.0, 0.0)),
            body=Inertia(J=J),
            oil=Damper(d=D),
            ground=Fixed(),
            connections=lambda m: lp.chain(m.motor, m.body, m.oil, m.ground),
        )
        run = lp.simulate(lp.assemble(model), until=T)
        found = lp.optimise(
            run,
            vary={"body.J": (0.01, 50)},
            minimise={"body.J": -1.0},
            subject_to={fun.mean("body.w"): (0.5, None)},
        )
        t, J_found = T - begin, found.parameters["body.J"]
        way = 6 / D * (t - J_found / D * (1 - np.exp(-D * t / J_found)))
        assert way / T == pytest.approx(0.5, rel=1e-7)

    def test_periodic_run_of_an_oscillator(self):
        """Torque into the ground of a shaken body, from the frequency response."""
        model = lp.compose(
            motor=Torque(tau=A * lp.ops.sin(W * lp.time)),
            body=Inertia(J=J),
            mount=SpringDamper(c=10.0, d=D),
            ground=Fixed(),
            connections=lambda m: lp.chain(m.motor, m.body, m.mount, m.ground),
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
        model = lp.compose(
            body=Inertia(J=J, w=5.0),
            brake=Brake(f_max=20.0, u=1.0),
            connections=lambda m: lp.chain(m.body, m.brake),
        )
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


class TestModes:
    @staticmethod
    def drive(c_1=4000.0, c_2=9000.0, d=1.0):
        return lp.assemble(
            lp.compose(
                a=Inertia(J=1.0),
                one=SpringDamper(c=c_1, d=d),
                b=Inertia(J=0.5),
                two=SpringDamper(c=c_2, d=d),
                c=Inertia(J=2.0),
                connections=lambda m: lp.chain(m.a, m.one, m.b, m.two, m.c),
            )
        )

    @staticmethod
    def hertz(J, c):
        """Frequencies of the free chain of three from its characteristic polynomial."""
        J_a, J_b, J_c = J
        c_1, c_2 = c
        p = c_1 * (1 / J_a + 1 / J_b) + c_2 * (1 / J_b + 1 / J_c)
        q = c_1 * c_2 * (J_a + J_b + J_c) / (J_a * J_b * J_c)
        root = np.sqrt(p**2 / 4 - q)
        return np.sqrt(np.array([p / 2 - root, p / 2 + root])) / (2 * np.pi)

    def test_two_frequencies_are_put_where_they_are_wanted(self):
        wanted = (11.0, 30.0)
        found = lp.optimise(
            lp.modes(self.drive(d=0.0)),
            vary={"one.c": (1e3, 1e5), "two.c": (1e3, 1e5)},
            minimise={"one.c": 1.0},
            subject_to={fun.frequency(i): (f, f) for i, f in enumerate(wanted)},
        )
        received = self.hertz((1.0, 0.5, 2.0), found.parameters.values())
        assert np.abs(received / wanted - 1).max() < 1e-8

    def test_lightest_flywheels_for_a_lowest_frequency(self):
        names = ("a.J", "b.J", "c.J")
        found = lp.optimise(
            lp.modes(self.drive(d=0.0)),
            vary=dict.fromkeys(names, (0.1, 5.0)),
            minimise=dict.fromkeys(names, 1.0),
            subject_to={fun.frequency(0): (None, 10.0)},
        )
        J = np.array([found.parameters[name] for name in names])
        assert self.hertz(J, (4000, 9000))[0] == pytest.approx(10, rel=1e-9)
        # no lighter design nearby, along the curve of equal frequency
        rng = np.random.default_rng(2)
        for _ in range(200):
            other = np.clip(J * (1 + 0.02 * rng.standard_normal(3)), 0.1, 5)
            if self.hertz(other, (4000, 9000))[0] <= 10:
                assert other.sum() > J.sum() - 1e-9
        assert found.solution.residual < 1e-6

    def test_clearance_is_the_same_on_both_sides(self):
        """One free parameter between two excitations: equal relative distance from both."""
        pair = lp.assemble(
            lp.compose(
                a=Inertia(J=1.0),
                shaft=Spring(c=4000.0),
                b=Inertia(J=0.5),
                connections=lambda m: lp.chain(m.a, m.shaft, m.b),
            )
        )
        low, high = 15.0, 25.0
        found = lp.optimise(
            lp.modes(pair),
            vary={"shaft.c": (3000, 6000)},
            minimise={fun.clearance((low, high)): -1.0},
        )
        f = 2 * low * high / (low + high)  # f / low - 1 == 1 - f / high
        assert found.run.hertz[0] == pytest.approx(f, rel=1e-8)
        assert found.parameters["shaft.c"] == pytest.approx((2 * np.pi * f) ** 2 / 3, rel=1e-8)
        assert found.values[fun.clearance((low, high))] == pytest.approx(f / low - 1, rel=1e-8)

    def test_damping_ratio(self):
        """Two bodies: ``zeta = d (1/J_a + 1/J_b) / (2 w)``."""
        pair = lp.assemble(
            lp.compose(
                a=Inertia(J=1.0),
                shaft=SpringDamper(c=4000.0, d=0.1),
                b=Inertia(J=0.5),
                connections=lambda m: lp.chain(m.a, m.shaft, m.b),
            )
        )
        found = lp.optimise(
            lp.modes(pair),
            vary={"shaft.d": (0, 100)},
            minimise={"shaft.d": 1.0},
            subject_to={fun.damping(0): (0.05, None)},
        )
        assert found.parameters["shaft.d"] == pytest.approx(0.1 * np.sqrt(12e3) / 3, rel=1e-7)

    def test_what_cannot_be(self):
        modes = lp.modes(self.drive())
        with pytest.raises(OptimisationError, match=r"Worst violated: frequency\(0\)"):
            lp.optimise(
                modes,
                vary={"a.J": (0.5, 2)},
                minimise={"a.J": 1},
                subject_to={fun.frequency(0): (100, None)},
            )
        with pytest.raises(OptionError, match="0 to 1"):
            lp.optimise(modes, vary={"a.J": (0.5, 2)}, minimise=fun.frequency(5))
        with pytest.raises(OptionError, match="nothing that modes has"):
            lp.optimise(modes, vary={"a.J": (0.5, 2)}, minimise=fun.rms("a.w"))
        with pytest.raises(OptionError, match="negative weight"):
            lp.optimise(modes, vary={"a.J": (0.5, 2)}, minimise=fun.clearance((10.0,)))


class TestBadInput:
    @pytest.mark.parametrize(
        ("vary", "options", "error", "text"),
        [
            ({}, {}, OptionError, "at least one parameter"),
            ({"spring.c": (9, 1)}, {}, OptionError, r"bounds of spring\.c = \(9, 1\)"),
            ({"spring.c": (1,)}, {}, OptionError, r"bounds of spring\.c"),
            ({"spring.c": (20, 99)}, {}, OptionError, r"spring\.c = 10 N\.m/rad, outside"),
            ({"spring.c": (-5, 99)}, {}, OptionError, r"spring\.c = -5 N\.m/rad"),
            ({"spring.k": (1, 9)}, {}, UnknownNameError, r"spring\.c"),
            (
                {"spring.c": (1, 99)},
                {"minimise": fun.rms("drive.tau")},
                UnknownNameError,
                "Nearest",
            ),
            (
                {"spring.c": (1, 99)},
                {"minimise": {fun.rms(TAU): 0}},
                OptionError,
                "nothing",
            ),
            (
                {"spring.c": (1, 99)},
                {"minimise": {fun.peak(TAU): -1}},
                OptionError,
                "made small",
            ),
            (
                {"spring.c": (1, 99)},
                {"minimise": fun.frequency(0)},
                OptionError,
                "known are",
            ),
            (
                {"spring.c": (1, 99), "oil.d": (1, 9)},
                {"minimise": fun.rms("spring.tau")},
                OptionError,
                r"oil\.d has no effect on",
            ),
            (
                {"spring.c": (1, 99)},
                {"subject_to": {"oil.d": (1, 2)}},
                OptionError,
                "belong to `vary`",
            ),
            (
                {"spring.c": (1, 99)},
                {"subject_to": {fun.peak(TAU): (None, 0.9 * LEAST)}},
                OptimisationError,
                r"Worst violated: peak\(drive\.flange\.tau\) = [\d.]+ N\.m, which must be at most",
            ),
            (
                {"spring.c": (1, 99)},
                {"subject_to": {TAU: (-1, 1)}},
                OptimisationError,
                r"Worst violated: drive\.flange\.tau = .* at t = ",
            ),
        ],
    )
    def test_it_is_named(self, vary, options, error, text):
        with pytest.raises(error, match=text):
            lp.optimise(shaken(), vary=vary, **({"minimise": fun.rms(TAU)} | options))

    def test_parameter_that_moves_an_instant(self):
        class Stepped(lp.Component):
            when: lp.Param = lp.param("s", "begin", 0.5)
            turn: Speed = Speed(w=lp.ops.where(lp.time >= when, 2.0, 1.0))
            oil: Damper = Damper(d=D)
            ground: Fixed = Fixed()

            def connections(self):
                yield from lp.chain(self.turn, self.oil, self.ground)

        run = lp.simulate(lp.assemble(Stepped()), until=1.0)
        with pytest.raises(OptionError, match="when moves an instant"):
            lp.optimise(run, vary={"when": (0.1, 0.9)}, minimise=fun.rms("oil.tau"))
