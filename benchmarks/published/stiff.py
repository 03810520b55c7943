"""Stiff and smooth problems of the IVP test set (Mazzia, Bari), as models of their equations.

The rates are written once, for the model and, by NumPy, for other solvers; those that NumPy does
faster with arrays have them written a second time.
"""

import numpy as np

import lumped as lp
from benchmarks.published.problem import ByHand, Problem

PI = np.pi


def equations_of(name, rates, start):
    """A component of quantities y1, y2, ... with given rates."""

    def equations(self):
        y = [getattr(self, f"y{i + 1}") for i in range(len(start))]
        for quantity, rate in zip(y, rates(lp.time, y, lp.ops), strict=True):
            yield lp.der(quantity) == rate

    body = {f"y{i + 1}": lp.var("1", "", float(value)) for i, value in enumerate(start)}
    return type(name, (lp.Component,), {"equations": equations, **body})


def problem(name, rates, start, until, end, largest=None, digits=1e-13, rate=None):
    """A problem whose rates are those of its equations."""
    places = list(end)

    def read(z):
        return z[[i - 1 for i in places]]

    return Problem(
        name,
        "IVP test set",
        equations_of("".join(filter(str.isalpha, name)), rates, start),
        until,
        {f"y{i}": value for i, value in end.items()},
        ByHand(rate or (lambda t, z: rates(t, z.tolist(), np)), start, read),
        digits,
        largest,
    )


def numbered(*values):
    """Values by the numbers of their quantities."""
    return dict(enumerate(values, 1))


def hires(_, y, __):
    """Light in a plant: eight reactions."""
    y1, y2, y3, y4, y5, y6, y7, y8 = y
    meeting = 280 * y6 * y8
    return [
        -1.71 * y1 + 0.43 * y2 + 8.32 * y3 + 0.0007,
        1.71 * y1 - 8.75 * y2,
        -10.03 * y3 + 0.43 * y4 + 0.035 * y5,
        8.32 * y2 + 1.71 * y3 - 1.12 * y4,
        -1.745 * y5 + 0.43 * y6 + 0.43 * y7,
        -meeting + 0.69 * y4 + 1.71 * y5 - 0.43 * y6 + 0.69 * y7,
        meeting - 1.81 * y7,
        -meeting + 1.81 * y7,
    ]


HIRES = problem(
    "HIRES",
    hires,
    (1, 0, 0, 0, 0, 0, 0, 0.0057),
    321.8122,
    numbered(
        0.7371312573325668e-3,
        0.1442485726316185e-3,
        0.5888729740967575e-4,
        0.1175651343283149e-2,
        0.2386356198831331e-2,
        0.6238968252742796e-2,
        0.2849998395185769e-2,
        0.2850001604814231e-2,
    ),
)


def robertson(_, y, __):
    """Three reactions over eleven decades of time."""
    a, b, c = y
    slow, fast = -0.04 * a + 1e4 * b * c, 3e7 * b * b
    return [slow, -slow - fast, fast]


ROBERTSON = problem(
    "Robertson",
    robertson,
    (1, 0, 0),
    1e11,
    numbered(0.2083340149701255e-7, 0.8333360770334713e-13, 0.9999999791665050),
    largest=(1.0, 3.6e-5, 1.0),
)


def van_der_pol(_, y, __):
    """A relaxation oscillator."""
    return [y[1], ((1 - y[0] ** 2) * y[1] - y[0]) / 1e-6]


# The second number is that of SciPy's Radau at 1e-9; the test set has it for time over 1e3.
VAN_DER_POL = problem(
    "van der Pol",
    van_der_pol,
    (2, 0),
    2.0,
    numbered(1.706167732170469, -0.8928097010248125),
)


def oregonator(_, y, __):
    """An oscillating reaction."""
    a, b, c = y
    return [
        77.27 * (b + a * (1 - 8.375e-6 * a - b)),
        (c - (1 + a) * b) / 77.27,
        0.161 * (a - c),
    ]


OREGONATOR = problem(
    "Oregonator",
    oregonator,
    (1, 2, 3),
    360.0,
    numbered(1.000814870318523, 1228.178521549917, 132.0554942846706),
)


def pleiades(_, y, m):
    """Seven stars in a plane, with masses 1 to 7."""
    x, h, n = y[:7], y[7:14], range(7)
    cubes = {
        (i, j): m.sqrt((x[i] - x[j]) ** 2 + (h[i] - h[j]) ** 2) ** 3 for i in n for j in range(i)
    }
    pulls = [
        [sum((j + 1) * (z[j] - z[i]) / cubes[max(i, j), min(i, j)] for j in n if j != i) for i in n]
        for z in (x, h)
    ]
    return [*y[14:], *pulls[0], *pulls[1]]


def pleiades_in_arrays(_, z):
    """The same for NumPy."""
    place = z[:14].reshape(2, 7)
    apart = place[:, None, :] - place[:, :, None]
    cubes = (apart**2).sum(axis=0) ** 1.5
    np.fill_diagonal(cubes, 1.0)
    return np.concatenate([z[14:], (apart / cubes @ np.arange(1.0, 8.0)).ravel()])


PLACES = (3, 3, -1, -3, 2, -2, 2, 3, -3, 2, 0, 0, -4, 4)
SPEEDS = (0, 0, 0, 0, 0, 1.75, -1.5, 0, 0, 0, -1.25, 1, 0, 0)
PLEIADES = problem(
    "Pleiades",
    pleiades,
    (*PLACES, *SPEEDS),
    3.0,
    {1: 0.3706139143970502, 7: -0.7003092922212495, 8: -3.943437585517392, 14: 1.091449240428980},
    largest=(3.0, 2.0, 4.0, 4.0),
    rate=pleiades_in_arrays,
)


def ring_modulator(t, y, m):
    """An electric circuit of four diodes, index 0 by its parasitic capacitors."""
    signal, carrier = 0.5 * m.sin(2e3 * PI * t), 2 * m.sin(2e4 * PI * t)
    through = (
        y[2] - y[4] - y[6] - carrier,
        -y[3] + y[5] - y[6] - carrier,
        y[3] + y[4] + y[6] + carrier,
        -y[2] - y[5] + y[6] + carrier,
    )
    q = [40.67286402e-9 * (m.exp(17.7493332 * u) - 1) for u in through]
    return [
        (y[7] - 0.5 * y[9] + 0.5 * y[10] + y[13] - y[0] / 25e3) / 1.6e-8,
        (y[8] - 0.5 * y[11] + 0.5 * y[12] + y[14] - y[1] / 25e3) / 1.6e-8,
        (y[9] - q[0] + q[3]) / 2e-12,
        (-y[10] + q[1] - q[2]) / 2e-12,
        (y[11] + q[0] - q[2]) / 2e-12,
        (-y[12] - q[1] + q[3]) / 2e-12,
        (-y[6] / 50.0 + q[0] + q[1] - q[2] - q[3]) / 1e-8,
        -y[0] / 4.45,
        -y[1] / 4.45,
        (0.5 * y[0] - y[2] - 17.3 * y[9]) / 5e-4,
        (-0.5 * y[0] + y[3] - 17.3 * y[10]) / 5e-4,
        (0.5 * y[1] - y[4] - 17.3 * y[11]) / 5e-4,
        (-0.5 * y[1] + y[5] - 17.3 * y[12]) / 5e-4,
        (-y[0] + signal - 86.3 * y[13]) / 2e-3,
        (-y[1] - 636.3 * y[14]) / 2e-3,
    ]


RING_MODULATOR = problem(
    "ring modulator",
    ring_modulator,
    (0,) * 15,
    1e-3,
    numbered(
        -0.02339057358486745,
        -0.007367485485540825,
        0.2582956709291169,
        -0.4064465721283450,
        -0.4039455665149794,
        0.2607966765422943,
        0.1106761861269975,
    ),
)

LINKS = 40
REACH = LINKS + 0.5 - np.maximum.outer(np.arange(1, LINKS + 1), np.arange(1, LINKS + 1))


def push(t):
    """Force on the free end of the beam in NumPy."""
    return 1.5 * np.sin(t) ** 2 if t <= PI else 0.0


class ElasticBeam(lp.Component):
    """Forty stiff links, clamped, pushed at their end; accelerations stay in full equations."""

    for _i in range(LINKS):
        locals()[f"y{_i + 1}"] = lp.var("rad", "", 0.0)
        locals()[f"y{_i + 1 + LINKS}"] = lp.var("rad/s", "", 0.0)

    def equations(self):
        n, sin, cos = range(LINKS), lp.ops.sin, lp.ops.cos
        force = lp.ops.where(lp.time <= PI, 1.5 * sin(lp.time) ** 2, 0.0) * LINKS**2
        a, w = ([getattr(self, f"y{i + 1 + k}") for i in n] for k in (0, LINKS))
        for i in n:
            yield lp.der(a[i]) == w[i]
            before, behind = a[i - 1] if i else -a[0], a[i + 1] if i + 1 < LINKS else a[i]
            bent = LINKS**4 * (before - 2 * a[i] + behind) + force * (cos(a[i]) + sin(a[i]))
            moved = lp.der(w[i]) * float(REACH[i, i])
            for k in n:
                if k != i:
                    moved += float(REACH[i, k]) * cos(a[i] - a[k]) * lp.der(w[k])
                    bent -= float(REACH[i, k]) * sin(a[i] - a[k]) * w[k] ** 2
            yield moved == bent


def beam_in_arrays(t, z):
    """The same for NumPy."""
    a, w = z[:LINKS], z[LINKS:]
    gap = a[:, None] - a[None, :]
    before, behind = np.append(-a[0], a[:-1]), np.append(a[1:], a[-1])
    force = LINKS**4 * (before - 2 * a + behind) + LINKS**2 * push(t) * (np.cos(a) + np.sin(a))
    bent = force - (REACH * np.sin(gap)) @ w**2
    return np.concatenate([w, np.linalg.solve(REACH * np.cos(gap), bent)])


BEAM = Problem(
    "elastic beam",
    "IVP test set, beam",
    ElasticBeam,
    5.0,
    {"y1": -0.005792366591285007, "y40": -0.1767201761075488, "y80": 1.186724615113034},
    ByHand(beam_in_arrays, (0.0,) * (2 * LINKS), lambda z: z[[0, 39, 79]]),
)
