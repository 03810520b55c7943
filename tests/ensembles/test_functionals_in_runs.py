"""Functionals that the time loop collects, against closed forms."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped import functionals as fun
from lumped.components import Fixed, Inertia, Position, Spring, Torque
from lumped.ops import sin, where

paired = lp.ensembles.paired


def check(what, found, expected, limit):
    """Compare all runs, relative to the largest expected value, and print the figure."""
    found, expected = np.asarray(found), np.broadcast_to(expected, np.shape(found))
    missing = np.isnan(expected)
    assert (np.isnan(found) == missing).all(), f"{what}: {found} instead of {expected}"
    size = max(np.abs(expected[~missing]).max(initial=0.0), 1e-3)
    error = np.abs(found - expected)[~missing].max(initial=0.0) / size
    assert error < limit, f"{what}: {found} instead of {expected}"


def compare(of, limit, system, **options):
    """Run an ensemble of functionals, and compare those with whom an expected value stands.

    Parameters
    ----------
    of : dict of str to (functional, array_like or callable)
        What is expected; functions take the ensemble.
    limit : float
        Of errors.
    """
    found = lp.ensemble(system, of={name: one for name, (one, _) in of.items()}, **options)
    for name, (_, expected) in of.items():
        check(name, found[name], expected(found) if callable(expected) else expected, limit)
    return found


# -- an oscillator ---------------------------------------------------------------------------------

SPEED, END = 1.5, 2.0
C = np.linspace(30.0, 300.0, 12)
J = np.linspace(0.4, 2.5, 12)[::-1] ** 2
RATE = np.sqrt(C / J)
SIZE = SPEED / RATE


@pytest.fixture(scope="module")
def oscillator():
    """A body with a speed on a spring: phi = SIZE sin(RATE t)."""
    model = in_a_row(ground=Fixed(), shaft=Spring(c=100.0), body=Inertia(J=1.0, phi=0.0, w=SPEED))
    return lp.assemble(model)


OVER = paired({"shaft.c": C, "body.J": J})


def swung(oscillator, of, rtol=1e-9, until=END):
    return lp.ensemble(oscillator, over=OVER, until=until, of=of, rtol=rtol)


def compare_swung(oscillator, of, limit, rtol=1e-9):
    compare(of, limit, oscillator, over=OVER, until=END, rtol=rtol)


def phi(t):
    return SIZE * np.sin(RATE * t)


def sine_integral(a, b, rate=RATE):
    return (np.cos(rate * a) - np.cos(rate * b)) / rate


def square_integral(a, b, rate=RATE):
    return (b - a) / 2 - (np.sin(2 * rate * b) - np.sin(2 * rate * a)) / (4 * rate)


def sine_extremes(a, b):
    """Greatest and least value of the sine from a to b, for each variant."""
    found = []
    for sign in (1.0, -1.0):
        first = np.ceil((RATE * a / np.pi - sign / 2) / 2)
        crest = np.pi * (2 * first + sign / 2) <= RATE * b
        ends = np.maximum(sign * np.sin(RATE * a), sign * np.sin(RATE * b))
        found.append(np.where(crest, 1.0, ends) * sign)
    return found


PARTS = [None, (0.0, 0.3), (0.31, 0.5), (1.0, 1.9), (0.7, END)]


@pytest.mark.parametrize("part", PARTS)
def test_integrals_of_a_sine(oscillator, part):
    a, b = part or (0.0, END)
    work = 0.5 * C * (phi(b) ** 2 - phi(a) ** 2)
    sine = np.sin(RATE * b) - np.sin(RATE * a)
    cube = np.sin(RATE * b) ** 3 - np.sin(RATE * a) ** 3
    mean = sine_integral(a, b) / (b - a)
    square = square_integral(a, b) / (b - a)
    power = 0.5 * C * SIZE * SPEED * np.sqrt(square_integral(a, b, 2 * RATE) / (b - a))
    of = {
        "integral": (fun.integral("shaft.phi_rel", between=part), SIZE * sine_integral(a, b)),
        "mean": (fun.mean("shaft.tau", between=part), C * SIZE * mean),
        "rms": (fun.rms("shaft.phi_rel", between=part), SIZE * np.sqrt(square)),
        "work": (fun.integral("shaft.tau", "body.w", between=part), work),
        "power": (fun.mean("shaft.tau", "body.w", between=part), work / (b - a)),
        "rms of power": (fun.rms("shaft.tau", "body.w", between=part), power),
        "cube": (
            fun.integral(*["body.w"] * 3, between=part),
            SPEED**3 * (sine - cube / 3) / RATE,
        ),
    }
    compare_swung(oscillator, of, 2e-8)


@pytest.mark.parametrize("part", PARTS)
def test_extremes_of_a_sine(oscillator, part):
    high, low = sine_extremes(*(part or (0.0, END)))
    top, bottom = sine_extremes(0.0, END)
    of = {
        "peak": (fun.peak("shaft.phi_rel", between=part), SIZE * np.maximum(high, -low)),
        "highest": (fun.highest("shaft.phi_rel", between=part), SIZE * high),
        "lowest": (fun.lowest("shaft.tau", between=part), C * SIZE * low),
        "swing": (fun.swing("shaft.tau"), C * SIZE * (top - bottom)),
    }
    compare_swung(oscillator, of, 1e-8)


def test_values_at_instants_are_added(oscillator):
    times = [0.7, 0.0, END, 0.2, 0.7]
    w = {t: SPEED * np.cos(RATE * t) for t in times}
    of = {
        "end": (fun.final("shaft.tau"), C * phi(END)),
        "one": (fun.at_time(0.7, "shaft.phi_rel"), phi(0.7)),
        "last": (fun.at_time(END, "body.w"), w[END]),
        "several": (fun.at_time(times, "shaft.phi_rel"), sum(phi(t) for t in times)),
        "product": (
            fun.at_time(times, "shaft.tau", "body.w"),
            sum(C * phi(t) * w[t] for t in times),
        ),
    }
    compare_swung(oscillator, of, 1e-8)
    first = swung(oscillator, [fun.at_time(0.0, "body.w")])
    assert (first.values == SPEED).all()


def test_what_else_is_taken_changes_no_more_than_the_tolerance(oscillator):
    """Values between steps have an error of their own, which steps obey where they are wanted."""
    of = {
        "peak": fun.peak("shaft.tau"),
        "part": fun.highest("shaft.tau", between=(0.3, 0.9)),
        "rms": fun.rms("shaft.tau"),
        "energy": fun.integral("body.w", "body.w", between=(0.3, 0.9)),
    }
    together = swung(oscillator, of, rtol=1e-6)
    for name, one in of.items():
        check(name, swung(oscillator, {name: one}, rtol=1e-6)[name], together[name], 2e-6)


def test_peaks_at_the_begin_and_the_end_and_equal_ones(oscillator):
    """The speed is greatest at the begin, and again after each period."""
    period = 2 * np.pi / RATE[0]
    of = {"w": fun.highest("body.w"), "peak": fun.peak("body.w"), "x": fun.highest("shaft.phi_rel")}
    found = swung(oscillator, of, rtol=1e-7, until=2 * period)
    assert (found["w"] >= SPEED).all()
    assert (found["peak"] >= SPEED).all()
    check("speed at the begin", found["w"], SPEED, 1e-6)
    check("size of the speed", found["peak"], SPEED, 1e-6)
    quarter = swung(oscillator, {**of, "end": fun.final("shaft.phi_rel")}, until=period / 4)
    assert (quarter["x"] >= quarter["end"]).all()
    check("crest at the end", quarter["x"][0], SIZE[0], 1e-9)
    rising = RATE[0] > RATE
    assert (quarter["x"] == quarter["end"])[rising].all()


# -- functions of time alone -----------------------------------------------------------------------


class Shaken(lp.Component):
    """A body that is moved, and a torque that comes at an instant; nothing is a state."""

    size: lp.Param = lp.param("rad", "amplitude", 0.5)
    rate: lp.Param = lp.param("rad/s", "angular rate", 30.0)
    comes: lp.Param = lp.param("s", "instant of the torque", 0.4)
    drive: Position = Position(phi=size * sin(rate * lp.time))
    body: Inertia = Inertia(J=2.0)
    load: Torque = Torque(tau=where(lp.time >= comes, 3.0, 1.0))

    def connections(self):
        yield from lp.chain(self.drive, self.body, self.load)


def test_a_system_without_states_moves_as_its_functions_of_time():
    system, until = lp.assemble(Shaken()), 1.3
    assert not system.state_names
    A, w, comes = (
        axis.ravel()
        for axis in np.meshgrid([0.2, 0.5], [9.0, 30.0, 400.0], [0.4, 0.95, 2.0], indexing="ij")
    )
    begins = comes < until
    square = 0.5 - np.sin(2 * w * until) / (4 * w * until)
    products = 0.5 * A**2 * w * (np.sin(0.2 * w) + np.sin(0.4 * w))
    of = {
        "peak": (fun.peak("body.a"), A * w**2),
        "highest": (fun.highest("body.w"), A * w),
        "late": (fun.highest("body.phi", between=(0.8, until)), A),
        "swing": (fun.swing("body.phi"), 2 * A),
        "integral": (fun.integral("body.w"), A * np.sin(w * until)),
        "rms": (fun.rms("body.a"), A * w**2 * np.sqrt(square)),
        "at": (fun.at_time([0.1, 0.2], "body.phi", "body.w"), products),
        "final": (fun.final("body.phi"), A * np.sin(w * until)),
        "momentum": (fun.integral("load.tau"), until + 2 * np.maximum(until - comes, 0)),
        "greatest": (fun.highest("load.tau"), np.where(begins, 3.0, 1.0)),
    }
    at_event = {
        "instant": (fun.instant("load.tau"), comes),
        "angle": (fun.at_event("body.phi", "load.tau"), A * np.sin(w * comes)),
        "before": (fun.at_event("load.tau", "load.tau"), 1.0),
        "after": (fun.at_event("load.tau", "load.tau", side="after"), 3.0),
    }
    of |= {name: (one, np.where(begins, value, np.nan)) for name, (one, value) in at_event.items()}
    over = paired({"size": A, "rate": w, "comes": comes})
    found = compare(of, 1e-12, system, over=over, until=until)
    assert sorted(found.failures) == np.flatnonzero(~begins).tolist()


class Square(lp.Component):
    """A torque that changes its sign with a sine, a clock that is not a straight line of time."""

    rate: lp.Param = lp.param("rad/s", "angular rate", 10.0)
    body: Inertia = Inertia(J=2.0, w=0.0, phi=0.0)
    drive: Torque = Torque(tau=where(sin(rate * lp.time) > 0, 1.0, -1.0))

    def connections(self):
        yield from lp.chain(self.drive, self.body)


def test_a_torque_that_changes_its_sign_with_a_sine_of_varied_rate():
    rate, until = np.linspace(1.0, 90.0, 40), 1.0
    half = np.pi / rate
    count = np.floor(until / half)
    rest = until - count * half
    w = np.where(count % 2, half - rest, rest) / 2
    last = np.where(count > 0, count * half, np.nan)
    of = {
        "w": (fun.final("body.w"), w),
        "peak": (fun.peak("body.w"), np.where(count > 0, half, until) / 2),
        "count": (fun.count("drive.tau"), count),
        "last": (fun.instant("drive.tau", number=-1), last),
        "sum": (
            fun.at_event("body.w", "drive.tau", number=None),
            np.ceil(count / 2) * half / 2,
        ),
        "mean": (fun.mean("drive.tau"), 2 * w / until),
    }
    found = compare(of, 1e-12, lp.assemble(Square()), over={"rate": rate}, until=until)
    check("last", found["last"], last, 1e-13)
