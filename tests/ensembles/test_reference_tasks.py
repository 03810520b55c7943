"""Four tasks against closed forms, SciPy, and figures that were computed without `lumped`."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

import lumped as lp
from benchmarks._ensemble_tasks import DELAY, tasks
from lumped import functionals as fun

FIGURES = yaml.safe_load(
    (Path(__file__).parents[1] / "data" / "ensembles" / "tasks.yaml").read_text()
)
TASKS = tasks()
QUANTILES = {"q001": 0.001, "q500": 0.5, "q999": 0.999, "min": 0.0, "max": 1.0}
SYSTEMS = {}


def system_of(letter):
    if letter not in SYSTEMS:
        SYSTEMS[letter] = lp.assemble(TASKS[letter].model)
    return SYSTEMS[letter]


def ran(letter, rows, of=None, **options):
    """Some variants of a task."""
    task = TASKS[letter]
    points = task.points[rows]
    over = lp.ensembles.paired(dict(zip(task.names, points.T, strict=True)))
    of = task.of if of is None else of
    found = lp.ensemble(system_of(letter), over=over, until=task.until, of=of, **options)
    assert (found.points == points).all()
    assert not found.failures
    return found


def worst(found, expected):
    """Largest relative error of each column."""
    return np.abs(found / expected - 1).max(axis=0)


# -- the first variants of the published figures ---------------------------------------------------


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_clutches_of_the_first_variants_lock_at_the_instants_of_the_figures(rtol):
    """Speeds are straight lines of time, so any tolerance gives them up to rounding."""
    of = {f"t{k}": fun.instant(f"clutch[{k}]", "stuck") for k in range(3)}
    error = np.abs(ran("b", slice(3), of, rtol=rtol).values - FIGURES["b"]["first"]).max(axis=0)
    assert error.max() < 1e-13


# -- task b ----------------------------------------------------------------------------------------

HEAT = {f"q{k}": fun.integral(f"clutch[{k}].tau", f"clutch[{k}].w_rel") for k in range(3)}


@pytest.fixture(scope="module")
def chain():
    """All variants of the clutches."""
    of = {f"t{k}": fun.instant(f"clutch[{k}]", "stuck") for k in range(3)}
    return ran("b", slice(None), of | HEAT)


def assert_statistics(values, figures, within):
    """Mean, deviation and quantiles against figures."""
    found = {"mean": values.mean(), "std": values.std(ddof=1)}
    found |= {name: np.quantile(values, q) for name, q in QUANTILES.items()}
    error = {name: abs(value / figures[name] - 1) for name, value in found.items()}
    assert max(error.values()) < within


@pytest.mark.parametrize("k", range(3))
def test_statistics_of_all_lock_times_are_those_of_the_figures(chain, k):
    assert len(chain) == FIGURES["b"]["n"]
    assert_statistics(chain[f"t{k}"], FIGURES["b"][f"t_lock_{k + 1}"], 1e-12)


def test_the_clutches_lock_in_the_orders_of_the_figures(chain):
    order = np.argsort([chain[f"t{k}"] for k in range(3)], axis=0).T + 1
    names, counts = np.unique(order, axis=0, return_counts=True)
    found = {"-".join(map(str, name)): int(n) for name, n in zip(names, counts, strict=True)}
    print(found)
    assert found == FIGURES["b"]["orders"]


def test_heat_of_all_clutches_is_that_of_the_figures(chain):
    heat = sum(chain[name] for name in HEAT)
    assert_statistics(heat, FIGURES["b"]["heat"], 1e-12)


# -- task a ----------------------------------------------------------------------------------------


def torques(point):
    """Modal solution: torques of both shafts and their rates as functions of time.

    With damping in proportion to stiffness the modes are those without, each a damped oscillator
    under a constant torque.
    """
    J, c = point[:3], point[3:]
    twist = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0]])
    square, modes = eigh(twist.T @ (c[:, None] * twist), np.diag(J))
    square, modes = square[1:], modes[:, 1:]
    push, decay = modes[0] * 100.0, 0.5 * DELAY * square
    rate = np.sqrt(square - decay**2)
    share = c[:, None] * (twist @ modes) * push  # of each mode in each torque

    def values(t):
        fade, turn = np.exp(-np.outer(decay, t)), np.outer(rate, t)
        wave, slow = np.sin(turn) / rate[:, None], decay[:, None]
        q = (1 - fade * (np.cos(turn) + slow * wave)) / square[:, None]
        v = fade * wave
        a = fade * (np.cos(turn) - slow * wave)
        return share @ (q + DELAY * v), share @ (v + DELAY * a)

    return values


def greatest(values, until):
    """Greatest sizes of both torques: the best samples, then halving of their rates."""
    t = np.linspace(0.0, until, 20_001)
    found = []
    for k in range(2):
        size = np.abs(values(t)[0][k])
        best = 0.0
        for i in np.argsort(size)[-8:]:
            low, high = t[max(i - 1, 0)], t[min(i + 1, len(t) - 1)]
            sign = np.sign(values(np.array([t[i]]))[0][k, 0])
            for _ in range(60):
                middle = 0.5 * (low + high)
                climbs = sign * values(np.array([middle]))[1][k, 0] > 0
                low, high = (middle, high) if climbs else (low, middle)
            best = max(best, abs(values(np.array([low]))[0][k, 0]))
        found.append(best)
    return found


@pytest.fixture(scope="module")
def modal():
    rows = slice(1000, 1030)
    expected = [greatest(torques(point), TASKS["a"].until) for point in TASKS["a"].points[rows]]
    return rows, np.array(expected)


def test_the_modal_solution_gives_the_figures():
    found = [max(greatest(torques(point), 2.0)) for point in TASKS["a"].points[:3]]
    error = worst(np.array(found), np.array(FIGURES["a"]["peak_torque"]["first"]))
    assert error < 1e-12


@pytest.mark.parametrize(("rtol", "limit"), [(1e-5, 2e-4), (1e-6, 1e-5), (1e-9, 5e-9)])
def test_peaks_of_shaft_torques_are_those_of_the_modal_solution(modal, rtol, limit):
    rows, expected = modal
    error = worst(ran("a", rows, rtol=rtol).values, expected)
    assert error.max() < limit


# -- tasks c and d ---------------------------------------------------------------------------------


def crank_rates(points):
    """Rates of all crank drives at once: angles, speeds, and the square of the shaft torque."""
    J1, c, J2, r, length, m = points.T

    def rates(t, z):
        phi, w, twist, w1, _ = z.reshape(5, -1)
        sine, cosine = np.sin(phi), np.cos(phi)
        root = np.sqrt(length**2 - (r * sine) ** 2)
        slope = -r * sine - r**2 * sine * cosine / root
        bend = (
            -r * cosine
            - r**2 * (cosine**2 - sine**2) / root
            - (r**2 * sine * cosine) ** 2 / root**3
        )
        tau = c * twist + 1.5 * (w1 - w)
        motor = 60.0 * (1 - w1 / 80.0)
        load = tau - 0.2 * w + 150.0 * slope - m * slope * bend * w**2
        return np.concatenate([w, load / (J2 + m * slope**2), w1 - w, (motor - tau) / J1, tau**2])

    return rates


def test_thirty_crank_drives_are_those_of_scipy():
    rows = slice(100, 130)
    task = TASKS["c"]
    n = len(task.points[rows])
    first = np.concatenate([np.full(n, 0.3), np.zeros(4 * n)])
    run = solve_ivp(
        crank_rates(task.points[rows]),
        (0.0, task.until),
        first,
        method="DOP853",
        rtol=1e-11,
        atol=1e-13,
    )
    phi, w, _, _, square = run.y[:, -1].reshape(5, -1)
    expected = np.column_stack([phi, w, np.sqrt(square / task.until)])
    before = np.inf
    for rtol, limit in ((1e-5, 2e-4), (1e-7, 2e-6), (1e-9, 5e-9)):
        error = worst(ran("c", rows, rtol=rtol).values, expected)
        print(f"30 variants, rtol {rtol:g}: largest relative errors {error}")
        assert error.max() < min(limit, 0.5 * before)
        before = error.max()


def test_five_trajectories_of_lorenz_are_those_of_scipy():
    task, count = TASKS["d"], 5
    rows = np.linspace(0, len(task.points) - 1, count).astype(int)
    rho = task.points[rows, 0]

    def rates(t, s):
        x, y, z = s.reshape(3, -1)
        return np.concatenate([10.0 * (y - x), rho * x - y - x * z, x * y - 2.666 * z])

    first = np.concatenate([np.ones(count), np.zeros(2 * count)])
    run = solve_ivp(rates, (0.0, task.until), first, method="DOP853", rtol=1e-12, atol=1e-14)
    expected = run.y[:, -1].reshape(3, -1).T
    for rtol, limit in ((1e-6, 1e-4), (1e-8, 1e-6), (1e-10, 1e-8)):
        values = ran("d", rows, rtol=rtol, atol=rtol).values
        error = np.abs(values - expected).max()
        print(f"rtol {rtol:g}: largest error {error:.1e}")
        assert error < limit
