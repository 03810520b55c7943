"""The modes of large drives nearest to a frequency: closed forms and all modes of smaller ones."""

import time

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Damper, Fixed, IdealGear, Inertia, Spring, SpringDamper
from lumped.errors import OptionError


def chain_of(bodies, shafts, **more):
    def joints(m):
        for i, shaft in enumerate(m.shaft):
            yield from lp.chain(m.body[i], shaft, m.body[i + 1])
        if more:
            yield from lp.chain(m.body[-1], m.end, m.wall)

    return lp.assemble(lp.compose(body=bodies, shaft=shafts, **more, connections=joints))


def uniform(n):
    return chain_of([Inertia(J=0.3) for _ in range(n)], [Spring(c=2e4) for _ in range(n - 1)])


def closed_form(n):
    k = np.arange(1, n)
    return 2 * np.sqrt(2e4 / 0.3) * np.sin(k * np.pi / (2 * n)) / (2 * np.pi)


def nearest(hertz, near, count):
    return np.sort(hertz[np.argsort(np.abs(hertz - near), kind="stable")[:count]])


@pytest.mark.parametrize(("n", "near"), [(300, 0.0), (300, 40.0), (3000, 0.0)])
def test_a_uniform_chain_has_its_closed_form_frequencies(n, near):
    system = uniform(n)
    lp.start_point(system)
    _ = system.jacobian
    begin = time.perf_counter()
    received = lp.modes(system, near=near, count=20)
    seconds = time.perf_counter() - begin
    expected = nearest(closed_form(n), near, 20)
    error = np.abs(received.hertz / expected - 1).max()
    print(f"{n} inertias near {near} Hz: {seconds:.2f} s, relative error {error:.1e}")
    assert error < 1e-12
    assert (received.damping == 0).all()
    assert received.rigid == (near == 0)
    if near == 0:
        first = received.shape("body[0].phi")
        for place in (n // 10, n // 2 + 3):
            k = np.arange(1, 21) * np.pi / n
            form = np.cos((place + 0.5) * k) / np.cos(0.5 * k)
            assert np.abs(received.shape(f"body[{place}].phi") / first - form).max() < 1e-9
        assert received.rigid_shape("body[3].phi") == pytest.approx([1.0])


def test_random_free_held_and_damped_drives_agree_with_all_their_modes():
    rng = np.random.default_rng(4)
    n = 160
    bodies = [Inertia(J=float(x)) for x in 10 ** rng.uniform(-2, 2, n)]
    c, d = 10 ** rng.uniform(3, 7, n - 1), 10 ** rng.uniform(-1, 1, n - 1)
    pairs = list(zip(c.tolist(), d.tolist(), strict=True))
    systems = {
        "undamped": chain_of(bodies, [Spring(c=x) for x in c.tolist()]),
        "damped": chain_of(bodies, [SpringDamper(c=x, d=y) for x, y in pairs]),
        "held": chain_of(
            bodies, [Spring(c=x) for x in c.tolist()], end=Spring(c=1e4), wall=Fixed()
        ),
        "braked": chain_of(
            bodies, [SpringDamper(c=x, d=y) for x, y in pairs], end=Damper(d=2.0), wall=Fixed()
        ),
    }
    for name, system in systems.items():
        everything = lp.modes(system)
        for near in (0.0, float(everything.hertz[40])):
            received = lp.modes(system, near=near, count=12)
            goal = 2j * np.pi * near
            order = np.argsort(np.abs(everything.eigenvalues - goal))[:12]
            expected = everything.eigenvalues[np.sort(order)]
            error = np.abs(received.eigenvalues / expected - 1).max()
            print(f"{name} near {near:.3g} Hz: {error:.1e}")
            assert error < 1e-8
            if near == 0:
                assert received.rigid == everything.rigid
                assert received.rigid_names == everything.rigid_names
            shapes = np.array([received.shape(f"body[{i}].phi") for i in (0, 50, 159)])
            all_shapes = np.array([everything.shape(f"body[{i}].phi") for i in (0, 50, 159)])
            assert np.abs(shapes - all_shapes[:, np.sort(order)]).max() < 1e-5


def test_stiff_shafts_beside_soft_ones_keep_the_digits_of_low_modes():
    """Pairs of inertias on stiff shafts move as one: the chain of their sums, to soft/stiff."""
    n, soft, stiff = 300, 2e4, 2e13
    shafts = [Spring(c=soft if i % 2 else stiff) for i in range(2 * n - 1)]
    system = chain_of([Inertia(J=0.15) for _ in range(2 * n)], shafts)
    received = lp.modes(system, near=0.0, count=10).hertz
    error = np.abs(received / closed_form(n)[:10] - 1).max()
    print(f"relative error {error:.1e}")
    assert error < 2e-9


def test_separate_large_drives_each_give_their_modes():
    def joints(m):
        for bodies, shafts in ((m.one, m.first), (m.two, m.second)):
            for i, shaft in enumerate(shafts):
                yield from lp.chain(bodies[i], shaft, bodies[i + 1])

    model = lp.compose(
        one=[Inertia(J=0.3) for _ in range(150)],
        first=[Spring(c=2e4) for _ in range(149)],
        two=[Inertia(J=0.3) for _ in range(150)],
        second=[Spring(c=2e4) for _ in range(149)],
        connections=joints,
    )
    received = lp.modes(lp.assemble(model), near=0.0, count=10)
    assert received.hertz == pytest.approx(np.repeat(closed_form(150)[:5], 2), rel=1e-11)
    assert received.rigid == 2


def test_a_small_drive_gives_what_it_has():
    model = in_a_row(
        a=Inertia(J=1.0), shaft=Spring(c=900.0), gear=IdealGear(ratio=3.0), b=Inertia(J=9.0)
    )
    received = lp.modes(lp.assemble(model), near=5.0, count=20)
    assert received.hertz == pytest.approx([np.sqrt(1800.0) / (2 * np.pi)], rel=1e-13)
    assert "only those near 5 Hz" in repr(received)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"near": 0.0}, "`near` and `count` go together"),
        ({"count": 3}, "`near` and `count` go together"),
        ({"near": -1.0, "count": 3}, "near = -1 Hz must be"),
        ({"near": np.nan, "count": 3}, "near = nan: a finite number"),
        ({"near": 1.0, "count": 0}, "count = 0 must be at least 1"),
    ],
)
def test_wrong_options_are_refused(two_mass, options, text):
    with pytest.raises(OptionError, match=text):
        lp.modes(lp.assemble(two_mass), **options)
