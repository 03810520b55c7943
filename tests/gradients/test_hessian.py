"""Second derivatives of runs, and derivatives of equilibria and responses, by closed forms."""

import numpy as np
import pytest

import lumped as lp
from lumped import functionals as fun
from lumped.components import Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptionError, UnknownNameError
from lumped.ops import where


def one(equations, **quantities):
    body = {"equations": equations, "__doc__": "One component: see equations.", **quantities}
    return type("One", (lp.Component,), body)()


def decay(**changes):
    def equations(self):
        yield lp.der(self.x) == self.u - self.k * self.x

    quantities = {
        "k": lp.param("1/s", "rate", 0.8),
        "u": lp.param("m/s", "inflow", 0.5),
        "x": lp.var("m", "position", start=1.5),
    }
    return lp.assemble(one(equations, **(quantities | changes)))


UNTIL, POINT = 2.0, np.array([0.8, 0.5, 1.5])


def closed(k, u, x_0):
    """Final value, and integral of the square of x = u/k + (x_0 - u/k) exp(-k t)."""
    a, T = u / k, UNTIL
    b = x_0 - a
    e = np.exp(-k * T)
    square = a**2 * T + 2 * a * b * (1 - e) / k + b**2 * (1 - e**2) / (2 * k)
    return np.array([a + b * e, square, np.sqrt(square / T)])


def second(which):
    """Hessian of one of these: complex step over central differences of sixth order."""
    h, found = 1e-3, np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for k, weight in ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60)):
                for sign in (1, -1):
                    point = POINT.astype(complex)
                    point[j] += sign * k * h
                    point[i] += 1e-30j
                    found[i, j] += sign * weight / h * closed(*point)[which].imag / 1e-30
    return found


@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize(
    ("of", "which"),
    [(fun.final("x"), 0), (fun.integral("x", "x"), 1), (fun.rms("x"), 2)],
    ids=["final", "integral", "rms"],
)
def test_second_derivatives_are_those_of_the_closed_form(of, which, method):
    found = lp.gradients.hessian(
        decay(), of=of, to=["k", "u", "x"], until=UNTIL, rtol=1e-11, method=method
    )
    assert found.run.statistics.method == method
    assert found.value == pytest.approx(closed(*POINT)[which], rel=1e-9)
    assert found.matrix == pytest.approx(second(which), rel=1e-8, abs=1e-9)
    assert f"{of} = " in repr(found)


def message(kind, action):
    with pytest.raises(kind) as caught:
        action()
    print(f"\n{kind.__name__}: {caught.value}")
    return str(caught.value)


def test_where_there_are_no_second_derivatives_this_is_said():
    def call(of=None, to=("k",)):
        return lambda: lp.gradients.hessian(decay(), of=of or fun.final("x"), to=to, until=UNTIL)

    assert "peak(x) has no second derivatives" in message(OptionError, call(fun.peak("x")))
    assert "nothing to vary" in message(OptionError, call(to=()))


def test_a_kink_of_the_rates_is_followed():
    # x' = -x, y' = max(0, x - b) for x > b: y(T) = x_0 - b - b log(x_0 / b)
    def equations(self):
        yield lp.der(self.x) == -self.x
        yield lp.der(self.y) == where(self.x > self.b, self.x - self.b, 0)

    system = lp.assemble(
        one(
            equations,
            b=lp.param("1", "border", 0.5),
            x=lp.var("1", "what falls", start=1.5, state="always"),
            y=lp.var("1", "sum", state="always"),
        )
    )
    x, b = 1.5, 0.5
    expected = np.array([[1 / b, -1 / x], [-1 / x, b / x**2]])
    value = x - b - b * np.log(x / b)
    for of in (fun.final("y"), fun.at(2.5, "y")):
        found = lp.gradients.hessian(system, of=of, to=["b", "x"], until=3.0, rtol=1e-11)
        assert found.value == pytest.approx(value, rel=1e-9)
        assert found.gradient == pytest.approx([-np.log(x / b), 1 - b / x], rel=1e-8)
        assert found.matrix == pytest.approx(expected, rel=1e-8)
        assert found.asymmetry < 1e-8
    sums = lp.gradients.hessian(
        system, of=fun.integral("y", between=(0.0, 2.0)), to=["b", "x"], until=3.0, rtol=1e-11
    )

    def total(b, x):
        t = np.log(x / b)
        return x * t - x + b - b * t**2 / 2 + (x - b - b * t) * (2 - t)

    def slopes(b, x):
        return np.array([total(b + 1e-30j, x).imag, total(b, x + 1e-30j).imag]) / 1e-30

    h = 1e-4
    columns = [
        (
            8 * (slopes(b + h * i, x + h * j) - slopes(b - h * i, x - h * j))
            - (slopes(b + 2 * h * i, x + 2 * h * j) - slopes(b - 2 * h * i, x - 2 * h * j))
        )
        / (12 * h)
        for i, j in ((1, 0), (0, 1))
    ]
    assert sums.value == pytest.approx(total(b, x), rel=1e-9)
    assert sums.matrix == pytest.approx(np.array(columns), rel=1e-8)


# -- equilibrium ---------------------------------------------------------------------------------


def test_an_equilibrium_moves_as_its_closed_form():
    # tau_0 (1 - w/w_0) == d w behind a spring that carries this torque
    tau, w_0, d, c = 40.0, 100.0, 0.3, 900.0
    system = lp.assemble(
        lp.compose(
            motor=Torque(tau=tau),
            drag=Damper(d=tau / w_0),
            rotor=Inertia(J=0.2),
            shaft=SpringDamper(c=c, d=0.5),
            load=Inertia(J=1.0),
            oil=Damper(d=d),
            wall=Fixed(),
            connections=lambda m: (
                *lp.chain(m.motor, m.rotor, m.shaft, m.load, m.oil, m.wall),
                *lp.chain(m.rotor, m.drag, m.wall),
            ),
        )
    )
    point = lp.equilibrium(system)
    of, to = ["load.w", "shaft.phi_rel"], ["motor.tau", "drag.d", "oil.d", "shaft.c", "load.J"]
    found = lp.points.equilibrium_sensitivity(point, of=of, to=to)

    def closed(tau, drag, d, c, J):
        w = tau / (drag + d)
        return np.array([w, -d * w / c])

    point = np.array([tau, tau / w_0, d, c, 1.0], dtype=complex)
    expected = [closed(*(point + 1e-30j * np.eye(5)[i])).imag / 1e-30 for i in range(5)]
    sign = np.sign(found.values[1] / closed(*point)[1].real)  # as the spring counts its twist
    assert found.values == pytest.approx(closed(*point).real * [1, sign], rel=1e-9)
    rows = np.array(expected).T * np.array([[1], [sign]])
    assert found.derivatives == pytest.approx(rows, rel=1e-9, abs=1e-12)
    assert found["load.w", "motor.tau"] == found.derivatives[0, 0]
    assert found.ranked("load.w")[0] == ("motor.tau", pytest.approx(1.0))
    figure = found.plot("load.w")  # the speed depends on neither c nor J
    assert len(figure.axes[0].patches) == 3
    assert figure.get_suptitle().endswith("\n2 without effect")
    assert "motor.tau +1.0000" in repr(found)


def test_a_point_that_is_no_equilibrium_is_refused():
    system = decay()
    point = lp.start_point(system)
    text = message(OptionError, lambda: lp.points.equilibrium_sensitivity(point, of=["x"]))
    assert "no equilibrium" in text
    still = lp.equilibrium(system)
    assert lp.points.equilibrium_sensitivity(still, of=["x"])["x", "k"] == pytest.approx(
        -0.5 / 0.64
    )
    message(OptionError, lambda: lp.points.equilibrium_sensitivity(still, of=[]))


# -- frequency response --------------------------------------------------------------------------


def two_masses():
    return lp.assemble(
        lp.compose(
            load=Torque(tau=0.0),
            a=Inertia(J=0.5),
            shaft=SpringDamper(c=800.0, d=3.0),
            b=Inertia(J=2.0),
            connections=lambda m: lp.chain(m.load, m.a, m.shaft, m.b),
        )
    )


def test_a_response_has_the_derivatives_of_its_closed_form():
    system, hertz = two_masses(), np.array([0.5, 3.0, 6.9, 20.0])
    response = lp.frequency_response(
        system, inputs=["load.tau"], outputs=["b.w", "a.w"], hertz=hertz
    )
    to = ["a.J", "b.J", "shaft.c", "shaft.d"]
    found = lp.vibration.response_sensitivity(response, to=to)
    s = 2j * np.pi * hertz

    def closed(J_a, J_b, c, d):
        """Speeds of b and a for each N.m on a."""
        k = d + c / s
        under = (J_a * s + k) * (J_b * s + k) - k**2
        return np.array([k / under, (J_b * s + k) / under])

    # complex amplitudes leave no room for a complex step: differences of sixth order
    point = np.array([0.5, 2.0, 800.0, 3.0])
    for i, name in enumerate(to):
        h, expected = 3e-3 * point[i], 0.0
        for k, weight in ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60)):
            e = np.eye(4)[i] * k * h
            expected = expected + weight / h * (closed(*(point + e)) - closed(*(point - e)))
        assert found["b.w", "load.tau", name] == pytest.approx(expected[0], rel=1e-8)
        assert found["a.w", "load.tau", name] == pytest.approx(expected[1], rel=1e-8)
        size = np.abs(closed(*point)[0])
        along = (closed(*point)[0].conj() * expected[0]).real / size
        assert found.magnitude("b.w", "load.tau", name) == pytest.approx(along, rel=1e-7)
    message(UnknownNameError, lambda: found["b.w", "load.tau", "load.tau"])
    message(OptionError, lambda: lp.vibration.response_sensitivity(response, to=[]))


def test_the_operating_point_of_a_response_moves():
    # x' = u - k x^2 answers to u with 1/(s + 2 k x), x = sqrt(u/k)
    def equations(self):
        yield lp.der(self.x) == self.u - self.k * self.x**2

    system = lp.assemble(
        one(
            equations,
            k=lp.param("1/(m.s)", "rate", 0.8),
            u=lp.param("m/s", "inflow", 0.5),
            x=lp.var("m", "position", start=0.8),
        )
    )
    hertz = np.array([0.1, 0.5])
    response = lp.frequency_response(
        system, inputs=["u"], outputs=["x"], hertz=hertz, at=lp.equilibrium(system)
    )
    found = lp.vibration.response_sensitivity(response, to=["k", "u"])
    pole = 2 * np.sqrt(0.5 * 0.8)
    slope = -1 / (2j * np.pi * hertz + pole) ** 2
    assert found.moving
    assert found["x", "u", "k"] == pytest.approx(slope * np.sqrt(0.5 / 0.8), rel=1e-8)
    assert found["x", "u", "u"] == pytest.approx(slope * np.sqrt(0.8 / 0.5), rel=1e-8)


def test_drag_by_the_square_of_a_speed_that_turns_back_has_exact_second_derivatives():
    # J w' = -M - k w |w|: tan while it turns forward, tanh after it has stopped
    def equations(self):
        yield self.J * lp.der(self.w) == -self.M - self.k * self.w * abs(self.w)

    system = lp.assemble(
        one(
            equations,
            J=lp.param("kg.m2", "inertia", 1.3),
            M=lp.param("N.m", "torque", 1.5),
            k=lp.param("N.m.s2", "drag", 0.6),
            w=lp.var("rad/s", "speed", start=1.0, state="always"),
        )
    )
    until, point = 2.0, np.array([1.3, 1.5, 0.6])

    def last(J, M, k):
        c = np.sqrt(M / k)
        stop = np.arctan(1.0 / c) * J / (c * k)
        return -c * np.tanh(c * k * (until - stop) / J)

    def slopes(values):
        return np.array([last(*(values + 1e-30j * np.eye(3)[i])).imag / 1e-30 for i in range(3)])

    columns = []
    for i in range(3):
        step = 1e-3 * np.eye(3)[i]
        near = 8 * (slopes(point + step) - slopes(point - step))
        far = slopes(point + 2 * step) - slopes(point - 2 * step)
        columns.append((near - far) / 12e-3)
    found = lp.gradients.hessian(
        system, of=fun.final("w"), to=["J", "M", "k"], until=until, rtol=1e-8
    )
    assert found.gradient == pytest.approx(slopes(point), rel=1e-8)
    assert found.matrix == pytest.approx(np.array(columns), rel=1e-7)
