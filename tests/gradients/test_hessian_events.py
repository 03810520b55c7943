"""Second derivatives of runs with events, by closed forms and by differences of gradients."""

import numpy as np
import pytest
from derivative_drives import DRIVES

import lumped as lp
from lumped import functionals as fun
from lumped.errors import SolverError
from lumped.ops import where

WEIGHTS = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
"""Of central differences of sixth order."""


def one(equations, **quantities):
    body = {"equations": equations, "__doc__": "See equations.", **quantities}
    return lp.assemble(type("One", (lp.Component,), body)())


def second(function, point, h=1e-3):
    """Hessian of a closed form: complex step over central differences."""
    found = np.zeros((len(point),) * 2)
    for i, j in np.ndindex(*found.shape):
        for k, weight in WEIGHTS:
            for sign in (1, -1):
                moved = np.array(point, dtype=complex)
                moved[j] += sign * k * h
                moved[i] += 1e-30j
                found[i, j] += sign * weight / h * function(*moved).imag / 1e-30
    return found


def agrees(found, function, point, rel):
    """Whether value and Hessian are those of a closed form; the error is printed."""
    expected = second(function, point)
    error = np.abs(found.matrix - expected).max() / np.abs(expected).max()
    print(f"\n{found.of}: error of the Hessian {error:.1e}, asymmetry {found.asymmetry:.1e}")
    assert found.value == pytest.approx(function(*point), rel=1e-9)
    assert found.asymmetry < 1e-9
    assert error < rel


# -- a ball that bounces -------------------------------------------------------------------------


def ball(jump):
    def equations(self):
        yield lp.der(self.s) == self.v
        if jump:
            yield lp.der(self.v) == -self.g
            yield lp.when(self.s <= 0, {self.v: -self.e * self.v})
        else:
            yield lp.der(self.v) == -self.g - self.f
            yield lp.hold(reaction=self.f, speed=self.v, gap=self.s, restitution=self.e)

    quantities = {
        "g": lp.param("m/s2", "gravity", 10.0),
        "e": lp.param("1", "restitution", 0.8),
        "s": lp.var("m", "height", start=1.0),
        "v": lp.var("m/s", "velocity", state="prefer"),
    }
    if not jump:
        quantities["f"] = lp.var("N/kg", "reaction of the ground, upwards negative")
    return one(equations, **quantities)


def flights(s, e, g, until):
    """Instants of the bounces before the end, and speeds after them."""
    t, v, found = np.sqrt(2 * s / g), e * np.sqrt(2 * g * s), []
    while t.real < until:
        found.append((t, v))
        t, v = t + 2 * v / g, e * v
    return found


@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize("jump", [True, False], ids=["when", "hold"])
@pytest.mark.parametrize(("until", "bounces"), [(0.8, 1), (2.4, 4)])
def test_a_ball_bounces_as_its_closed_form(jump, method, until, bounces):
    point = np.array([1.0, 0.8, 10.0])
    assert len(flights(*point, until)) == bounces

    def height(s, e, g):
        t, v = flights(s, e, g, until)[-1]
        return v * (until - t) - g * (until - t) ** 2 / 2

    def speed(s, e, g):
        t, v = flights(s, e, g, until)[-1]
        return v - g * (until - t)

    def squares(s, e, g):
        """Integral of the square of the speed."""
        hits = flights(s, e, g, until)
        total = g**2 * hits[0][0] ** 3 / 3
        ends = [t for t, _ in hits[1:]] + [until]
        for (t, v), end in zip(hits, ends, strict=True):
            total = total + (v**3 - (v - g * (end - t)) ** 3) / (3 * g)
        return total

    options = {"to": ["s", "e", "g"], "until": until, "rtol": 1e-10, "method": method}
    cases = [("s", height), ("v", speed), (fun.integral("v", "v"), squares)]
    for of, closed in cases:
        of = fun.final(of) if isinstance(of, str) else of
        agrees(lp.gradients.hessian(ball(jump), of=of, **options), closed, point, 1e-8)


def test_a_product_with_a_direction_is_that_of_the_matrix():
    options = {"of": fun.final("v"), "to": ["s", "e", "g"], "until": 2.9, "rtol": 1e-9}
    found = lp.gradients.hessian(ball(False), **options)
    along = np.array([0.3, -0.2, 1.7])
    product = lp.gradients.hessian_product(ball(False), along=along, **options)
    assert product == pytest.approx(found.matrix @ along, rel=1e-9)


# -- friction ------------------------------------------------------------------------------------


def block():
    """A block that slides to rest."""

    def equations(self):
        yield lp.der(self.s) == self.v
        yield lp.der(self.v) == -self.f
        most = self.mu * self.g
        yield lp.hold(self.f, self.v, forward=most, backward=-most, upper=most, lower=-most)

    return one(
        equations,
        mu=lp.param("1", "friction", 0.4),
        g=lp.param("m/s2", "gravity", 9.81),
        s=lp.var("m", "way", state="always"),
        v=lp.var("m/s", "velocity", start=3.0, state="always"),
        f=lp.var("N/kg", "friction"),
    )


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_block_slides_to_rest_as_its_closed_form(method):
    # v^2 / (2 mu g), and v^3 / (3 mu g) as the integral of the square of its speed
    to, point = ["v", "mu", "g"], np.array([3.0, 0.4, 9.81])
    options = {"to": to, "until": 2.0, "rtol": 1e-10, "method": method}
    way = lp.gradients.hessian(block(), of=fun.final("s"), **options)
    agrees(way, lambda v, mu, g: v**2 / (2 * mu * g), point, 1e-9)
    squares = lp.gradients.hessian(block(), of=fun.integral("v", "v"), **options)
    agrees(squares, lambda v, mu, g: v**3 / (3 * mu * g), point, 1e-9)


# -- functions of time, and conditions -----------------------------------------------------------


def test_an_instant_that_is_not_linear_in_a_parameter():
    # v' = a until t = b^2, then -a; s(T) = a b^4 / 2 + a b^2 (T - b^2) - a (T - b^2)^2 / 2
    def equations(self):
        yield lp.der(self.s) == self.v
        yield lp.der(self.v) == where(lp.time < self.b**2, self.a, -self.a)

    system = one(
        equations,
        a=lp.param("m/s2", "acceleration", 1.3),
        b=lp.param("1", "root of the instant, s", 0.9),
        s=lp.var("m", "way", state="always"),
        v=lp.var("m/s", "velocity", state="always"),
    )

    def way(a, b):
        rest = 2.0 - b**2
        return a * b**4 / 2 + a * b**2 * rest - a * rest**2 / 2

    found = lp.gradients.hessian(system, of=fun.final("s"), to=["a", "b"], until=2.0, rtol=1e-10)
    agrees(found, way, np.array([1.3, 0.9]), 1e-9)


def test_rates_that_jump_at_a_border():
    def equations(self):
        yield lp.der(self.x) == where(self.x >= 1.0, -self.k, -self.u)

    system = one(
        equations,
        k=lp.param("m/s", "rate", 0.8),
        u=lp.param("m/s", "rate below", 0.5),
        x=lp.var("m", "position", start=1.5),
    )
    to, point = ["k", "u", "x"], np.array([0.8, 0.5, 1.5])
    found = lp.gradients.hessian(system, of=fun.final("x"), to=to, until=2.0, rtol=1e-10)
    agrees(found, lambda k, u, x: 1 - u * (2 - (x - 1) / k), point, 1e-9)

    def total(k, u, x):
        t = (x - 1) / k
        return x * t - k * t**2 / 2 + (2 - t) - u * (2 - t) ** 2 / 2

    found = lp.gradients.hessian(system, of=fun.integral("x"), to=to, until=2.0, rtol=1e-10)
    agrees(found, total, point, 1e-9)


# -- drives --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "of"),
    [
        ("brake_with_a_ramp", fun.integral("brake.tau", "brake.w")),
        ("clutch_engaged_by_its_command", fun.final("clutch.tau")),
        ("dog_clutch_at_an_instant", fun.integral("oil.tau", "oil.w_rel")),
        ("elastic_play_with_damped_flanks", fun.final("b.w")),
        ("load_that_is_picked_up", fun.final("body.w")),
        ("mass_between_two_stops", fun.final("body.s")),
        ("stick_slip_with_stribeck", fun.mean("shaft.tau", between=(0.4, 2.2))),
    ],
)
def test_second_derivatives_are_differences_of_gradients(name, of):
    system, _, to, until = DRIVES[name]()
    begin = lp.start_point(system)
    point = [system.parameters[n] if n in system.parameters else begin[n] for n in to]
    found = lp.gradients.hessian(system, of=of, to=to, until=until, rtol=1e-10)
    columns = []
    for key, value in zip(to, point, strict=True):
        kind, h, column = "parameters" if key in system.parameters else "start", 2e-4 * value, 0.0
        for k, weight in WEIGHTS:
            for sign in (1, -1):
                options = {kind: {key: value + sign * k * h}, "until": until, "rtol": 1e-12}
                slopes = lp.gradient(system, of=[of], to=to, **options).derivatives[0]
                column = column + sign * weight / h * slopes
        columns.append(column)
    sizes = np.outer(point, point)
    expected = np.array(columns) * sizes
    error = np.abs(found.matrix * sizes - expected).max() / np.abs(expected).max()
    print(f"\n{name}: {len(found.run.events)} events, error {error:.1e}, {found.asymmetry:.1e}")
    assert found.run.events
    assert found.asymmetry < 1e-9
    assert error < 1e-9


# -- what is refused -----------------------------------------------------------------------------


def refused(system, of, to, until, *words):
    with pytest.raises(SolverError) as caught:
        lp.gradients.hessian(system, of=of, to=to, until=until)
    print(f"\n{caught.value}")
    for word in words:
        assert word in str(caught.value)


def two(height):
    """Two rates that fall at borders: at 0.5 s and at half a height, less a half."""

    def equations(self):
        yield lp.der(self.x) == where(self.x >= 1.0, -1, -self.u)
        yield lp.der(self.y) == where(self.y >= 1.0, -2, -self.u * self.x)

    return one(
        equations,
        u=lp.param("m/s", "rate below", 0.5),
        x=lp.var("m", "position", start=1.5),
        y=lp.var("m", "position", start=height),
    )


def test_changes_that_coincide_are_refused():
    refused(two(2.0), fun.final("y"), ["x", "y"], 2.0, "t = 0.5 s", "coincide")
    # y falls to 1 at T = (y - 1) / 2, then to 1 - u (x (t - T) - (t^2 - T^2) / 2)
    found = lp.gradients.hessian(two(1.6), of=fun.final("y"), to=["x", "y"], until=0.45)

    def last(x, y):
        t = (y - 1) / 2
        return 1 - 0.5 * (x * (0.45 - t) - (0.45**2 - t**2) / 2)

    agrees(found, last, np.array([1.5, 1.6]), 1e-6)


def test_a_border_that_is_touched_is_refused():
    def equations(self):
        yield lp.der(self.v) == self.a
        yield lp.der(self.s) == self.v
        yield lp.der(self.n) == where(self.s >= 0.0, 1, 2)

    system = one(
        equations,
        a=lp.param("m/s2", "acceleration", 2.0),
        v=lp.var("m/s", "velocity", start=-2.0, state="always"),
        s=lp.var("m", "position", start=1.0, state="always"),
        n=lp.var("1", "number", state="always"),
    )
    refused(system, fun.final("n"), ["a", "v"], 2.0, "t = 1 s", "touches")


def test_bounces_that_come_to_an_end_are_refused():
    words = "ever smaller bounces come to an end", "One", "lumped.gradient"
    refused(ball(False), fun.final("s"), ["e", "g"], 10.0, *words)


def test_an_instant_that_is_looked_at_must_not_be_that_of_a_change():
    refused(two(1.6), fun.at(0.5, "x"), ["x"], 1.0, "t = 0.5 s", "is looked at")
    whole = fun.integral("x", between=(0.5, 0.8))
    refused(two(1.6), whole, ["x"], 1.0, "t = 0.5 s", "is looked at")
