"""The modes of large drives nearest to a frequency: closed forms and all modes of smaller ones."""

import numpy as np
import pytest
from drive_chains import in_turn, uniform, uniform_hertz
from rows import in_a_row

import lumped as lp
from lumped.components import Damper, Fixed, IdealGear, Inertia, Spring, SpringDamper
from lumped.errors import OptionError


def nearest(hertz, near, count):
    return np.sort(hertz[np.argsort(np.abs(hertz - near), kind="stable")[:count]])


@pytest.mark.parametrize(("n", "near"), [(300, 0.0), (300, 40.0), (3000, 0.0)])
def test_a_uniform_chain_has_its_closed_form_frequencies(n, near):
    received = lp.modes(lp.assemble(uniform(n)), near=near, count=20)
    expected = nearest(uniform_hertz(n), near, 20)
    assert received.hertz == pytest.approx(expected, rel=1e-12)
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
    plain, lossy = [Spring(c=x) for x in c.tolist()], [SpringDamper(c=x, d=y) for x, y in pairs]
    drives = {
        "undamped": (plain, {}),
        "damped": (lossy, {}),
        "held": (plain, {"last": Spring(c=1e4), "wall": Fixed()}),
        "braked": (lossy, {"last": Damper(d=2.0), "wall": Fixed()}),
    }
    for shafts, end in drives.values():
        system = lp.assemble(in_turn(end=end, body=bodies, shaft=shafts))
        everything = lp.modes(system)
        for near in (0.0, float(everything.hertz[40])):
            received = lp.modes(system, near=near, count=12)
            goal = 2j * np.pi * near
            order = np.argsort(np.abs(everything.eigenvalues - goal))[:12]
            expected = everything.eigenvalues[np.sort(order)]
            assert received.eigenvalues == pytest.approx(expected, rel=1e-8)
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
    model = in_turn(body=[Inertia(J=0.15) for _ in range(2 * n)], shaft=shafts)
    received = lp.modes(lp.assemble(model), near=0.0, count=10).hertz
    assert received == pytest.approx(uniform_hertz(n)[:10], rel=2e-9)


def test_separate_large_drives_each_give_their_modes():
    model = lp.compose(one=uniform(150), two=uniform(150), connections=lambda m: [])
    received = lp.modes(lp.assemble(model), near=0.0, count=10)
    assert received.hertz == pytest.approx(np.repeat(uniform_hertz(150)[:5], 2), rel=1e-11)
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
        ({"near": -1.0, "count": 3}, "near = -1 Hz must not be"),
        ({"near": np.nan, "count": 3}, "near = nan: a finite number"),
        ({"near": 1.0, "count": 0}, "count = 0 must be at least 1"),
    ],
)
def test_wrong_options_are_refused(two_mass, options, text):
    with pytest.raises(OptionError, match=text):
        lp.modes(lp.assemble(two_mass), **options)
