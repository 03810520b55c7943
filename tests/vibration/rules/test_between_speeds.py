"""Limits between the speeds of an order response, against responses by numpy alone."""

from dataclasses import dataclass, field

import numpy as np
import pytest
import scipy.optimize

import lumped as lp
from lumped.components import Damper, Fixed, IdealGear, Inertia, SpringDamper, Torque
from lumped.vibration import Limit
from lumped.vibration.rules.measures import show_peaks

LOW, HIGH = 20.0, 400.0


@dataclass
class Line:
    """Inertias on shafts in a row, some behind a gear; torques of some orders on the first."""

    seed: int
    orders: np.ndarray = field(init=False)

    def __post_init__(self):
        draw = np.random.default_rng(self.seed)
        n = int(draw.integers(3, 13))
        self.J, self.c = 10 ** draw.uniform(-1, 1, n), 10 ** draw.uniform(4, 6, n - 1)
        reduced = self.J[1:] * self.J[:-1] / (self.J[1:] + self.J[:-1])
        self.d = 2 * draw.uniform(0.001, 0.05) * np.sqrt(self.c * reduced)
        self.brake = 10 ** draw.uniform(-1, 0.5)
        self.gear, self.ratio = int(draw.integers(n - 1)), draw.uniform(0.5, 3)
        twists = np.diff(np.eye(n), axis=0)
        twists[self.gear, self.gear] /= self.ratio
        self.M, self.K = np.diag(self.J), twists.T @ np.diag(self.c) @ twists
        self.C = twists.T @ np.diag(self.d) @ twists
        self.C[-1, -1] += self.brake
        self.own = int(draw.integers(n - 1))
        self.twist = twists[self.own]
        count = int(draw.integers(1, 5))
        self.orders = np.sort(draw.choice(np.arange(1, 13) / 2, count, replace=False))
        self.torques = 50 * draw.random(count) * np.exp(1j * draw.uniform(0, 6, count))

    def amplitudes(self, speeds):
        """Torque of the shaft at speeds, by orders."""
        w = (np.ravel(speeds)[:, None] * self.orders)[..., None, None]
        right = np.zeros((len(self.orders), len(self.J), 1), dtype=complex)
        right[:, 0, 0] = self.torques
        x = np.linalg.solve(self.K + 1j * w * self.C - w**2 * self.M, right)[..., 0]
        w = w[..., 0, 0]
        return (self.c[self.own] + 1j * w * self.d[self.own]) * (x @ self.twist)

    def sum(self, speeds):
        return np.abs(self.amplitudes(speeds)).sum(axis=1)

    def half_range(self, speeds, points=65536):
        """Extremes over two turns by parabolas through three of many points."""
        angle = 4 * np.pi * np.arange(points) / points
        waves = (self.amplitudes(speeds) @ np.exp(1j * self.orders[:, None] * angle)).real
        extremes = []
        for side in (waves, -waves):
            top = side.argmax(axis=1)
            a, b, c = (side[np.arange(len(top)), (top + i) % points] for i in (-1, 0, 1))
            extremes.append(b + (a - c) ** 2 / (8 * (2 * b - a - c)))
        return sum(extremes) / 2

    def find_most(self, size, **coarse):
        """Largest size, looked for beside each resonance."""
        n = len(self.J)
        lower = -np.linalg.solve(self.M, np.hstack([self.K, self.C]))
        values = np.linalg.eigvals(np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower]))
        values = values[values.imag > 1e-3]
        beside = values.imag + values.real * np.linspace(-4, 4, 65)[:, None]
        speeds = [*np.geomspace(LOW, HIGH, 500), *np.divide.outer(beside, self.orders).ravel()]
        speeds = np.unique(np.clip(speeds, LOW, HIGH))
        sizes = size(speeds, **coarse)
        best = size(speeds[[sizes.argmax()]])[0]
        for k in np.flatnonzero(sizes > 0.95 * sizes.max()):
            ends = speeds[max(k - 1, 0)], speeds[min(k + 1, len(speeds) - 1)]
            found = scipy.optimize.minimize_scalar(
                lambda n: -size(n)[0], bounds=ends, method="bounded", options={"xatol": 1e-9}
            )
            best = max(best, -found.fun)
        return best

    def assemble(self):
        n = len(self.J)

        def connections(m):
            row = [m.drive]
            for k in range(n):
                row += [m.body[k], *[m.gear] * (k == self.gear), *m.shaft[k : k + 1]]
            yield from lp.chain(*row, m.load)
            yield from lp.chain(m.body[-1], m.brake, m.frame)

        model = lp.compose(
            drive=Torque(tau=0.0),
            body=[Inertia(J=J) for J in self.J],
            shaft=[SpringDamper(c=c, d=d) for c, d in zip(self.c, self.d, strict=True)],
            gear=IdealGear(ratio=self.ratio),
            brake=Damper(d=self.brake),
            frame=Fixed(),
            load=Torque(tau=0.0),
            connections=connections,
        )
        return lp.assemble(model)

    def respond(self, system, count):
        return lp.vibration.order_response(
            system,
            speeds=np.linspace(LOW, HIGH, count),
            of=[f"shaft[{self.own}].tau"],
            excitations={"drive.tau": dict(zip(self.orders, self.torques, strict=True))},
            shaft="body[0].phi",
            free="load.tau",
        )


@pytest.mark.parametrize("seed", range(40))
def test_a_verdict_does_not_depend_on_the_speeds_that_were_computed(seed):
    line = Line(seed)
    system, key = line.assemble(), f"shaft[{line.own}].tau"
    most = {
        "sum": line.find_most(line.sum),
        "half range": line.find_most(line.half_range, points=512),
    }
    limits = [Limit(key, 0.8 * size, measure=measure) for measure, size in most.items()]
    found = [lp.vibration.verdict(line.respond(system, k), limits) for k in (12, 45, 2000)]
    first = {result.measure: result for result in found[0].results}
    for judged in found:
        assert not judged.notes
        for result in judged.results:
            assert result.value == pytest.approx(most[result.measure], rel=1e-7)
            ends = [end for barred in result.beyond for end in (barred.begin, barred.end)]
            same = [end for b in first[result.measure].beyond for end in (b.begin, b.end)]
            assert ends == pytest.approx(same, rel=1e-8)
            inner = [end for end in ends if LOW < end < HIGH]
            size = line.sum if result.measure == "sum" else line.half_range
            assert size(inner) == pytest.approx(result.permitted, rel=1e-7)


def test_a_verdict_tells_what_it_does_not_cover():
    line = Line(0)
    response = line.respond(line.assemble(), 12)
    key = f"shaft[{line.own}].tau"
    (note,) = lp.vibration.verdict(response, [Limit(key, 1e9, speeds=(LOW / 2, HIGH))]).notes
    low, high = 30 * LOW / np.pi, 30 * HIGH / np.pi
    assert note == f"limit 'limit' of {key} is judged from {low:.6g} to {high:.6g} 1/min only"


def test_rows_of_a_limit_may_end_with_the_speeds():
    line = Line(0)
    response, key = line.respond(line.assemble(), 12), f"shaft[{line.own}].tau"
    rows = ((LOW, 1e9), (HIGH, 1e-12))  # used most at the end
    (result,) = lp.vibration.verdict(response, [Limit(key, rows, measure="sum")]).results
    assert (result.speed, result.value) == (HIGH, pytest.approx(line.sum([HIGH])[0]))


@pytest.mark.parametrize("seed", range(6))
def test_pages_show_the_maxima_of_each_order_and_of_all(seed):
    line = Line(seed)
    key = f"shaft[{line.own}].tau"
    shown = show_peaks(line.respond(line.assemble(), 12))
    for k, found in enumerate(np.abs(shown[key]).max(axis=0)):
        most = line.find_most(lambda speeds, k=k: np.abs(line.amplitudes(speeds)[:, k]))
        assert found == pytest.approx(most, rel=1e-6)
    assert shown.synthesis(key).half_range.max() == pytest.approx(
        line.find_most(line.half_range, points=512), rel=1e-7
    )
