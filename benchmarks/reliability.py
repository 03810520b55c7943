"""How near do methods of reliability come to ten million samples, in how many evaluations?

Three drives: a speed that is linear in normal torques, a natural frequency of lognormal stiffness
and inertia (its limit is plane in their logarithms), and that of two masses, whose limit is
curved. The samples are drawn with numpy and go through the closed form of each drive; `lumped` runs
the drives themselves. The first two have a probability in closed form too. Read the ratios. For
sampled methods the deviation is what they tell of themselves, and the last column is how many plain
samples have an interval as narrow.

    python -m benchmarks.reliability
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import norm

import lumped as lp
from benchmarks.harness import publish, time_action
from lumped import functionals as fun
from lumped.components import Fixed, Inertia, SpringDamper, Torque
from lumped.ensembles import lognormal, truncated

SAMPLES, PART = 10_000_000, 1_000_000
METHODS: tuple[dict[str, Any], ...] = (
    {"search": "form"},
    {"search": "sorm"},
    {"search": "importance", "runs": 20_000},
    {"search": "subset", "runs": 200_000},
)


@dataclass(frozen=True)
class Task:
    """A drive and its closed form.

    Attributes
    ----------
    value : callable
        The functional for standard normal numbers, shape (d, n).
    exact : float
        The probability; nan where it has no closed form.
    call : dict
        Arguments of `reliability`.
    """

    value: Callable[[np.ndarray], np.ndarray]
    count: int
    exact: float
    call: dict[str, Any]


def pull_inertia() -> Task:
    """``w(1 s) = (t + s) / J`` above 9 rad/s."""
    model = lp.compose(
        a=Inertia(J=2.0),
        t=Torque(tau=10.0),
        s=Torque(tau=4.0),
        connections=lambda m: [lp.connect(x.flange, m.a.flange_a) for x in (m.t, m.s)],
    )
    over = {"t.tau": lp.normal(10.0, 1.2), "s.tau": lp.normal(4.0, 0.5)}
    exact = float(norm.sf((18 - 14) / np.hypot(1.2, 0.5)))
    call = {"what": lp.assemble(model), "functional": fun.final("a.w"), "over": over}
    return Task(
        lambda z: (14 + 1.2 * z[0] + 0.5 * z[1]) / 2, 2, exact, call | {"above": 9.0, "until": 1.0}
    )


def ground_inertia() -> Task:
    """Natural frequency of an inertia on a spring above 3.8 Hz."""
    model = lp.compose(
        wall=Fixed(),
        spring=SpringDamper(c=400.0, d=0.0),
        mass=Inertia(J=1.0),
        connections=lambda m: lp.chain(m.wall, m.spring, m.mass),
    )
    over = {"spring.c": lognormal(400.0, 0.1), "mass.J": lognormal(1.0, 0.05)}
    exact = float(norm.sf(np.log(7.6 * np.pi / 20) / np.hypot(0.05, 0.025)))
    call = {"what": lp.modes(lp.assemble(model)), "functional": fun.frequency(0), "over": over}
    return Task(
        lambda z: 20 * np.exp(0.05 * z[0] - 0.025 * z[1]) / (2 * np.pi),
        2,
        exact,
        call | {"above": 3.8},
    )


def two_masses() -> Task:
    """Natural frequency of two inertias on a spring above 5 Hz."""
    model = lp.compose(
        a=Inertia(J=1.0),
        spring=SpringDamper(c=400.0, d=0.0),
        b=Inertia(J=2.0),
        connections=lambda m: lp.chain(m.a, m.spring, m.b),
    )
    over = {
        "spring.c": lognormal(400.0, 0.15),
        "a.J": truncated(lp.normal(1.0, 0.12), 0.1, None),
        "b.J": truncated(lp.normal(2.0, 0.3), 0.1, None),
    }

    def value(z: np.ndarray) -> np.ndarray:
        a, b = np.maximum(1 + 0.12 * z[1], 0.1), np.maximum(2 + 0.3 * z[2], 0.1)
        return np.sqrt(400 * np.exp(0.15 * z[0]) * (1 / a + 1 / b)) / (2 * np.pi)

    call = {"what": lp.modes(lp.assemble(model)), "functional": fun.frequency(0), "over": over}
    return Task(value, 3, np.nan, call | {"above": 5.0})


def sample_limit(task: Task) -> float:
    """Share of all samples beyond the limit."""
    random = np.random.default_rng(0)
    beyond = 0
    for _ in range(SAMPLES // PART):
        beyond += int(
            (task.value(random.standard_normal((task.count, PART))) > task.call["above"]).sum()
        )
    return beyond / SAMPLES


def rows_of(name: str, task: Task) -> Iterator[tuple[str, ...]]:
    """All methods on a drive, after the samples."""
    many = sample_limit(task)

    def probabilities(p: float) -> tuple[str, ...]:
        exact = "" if np.isnan(task.exact) else f"{p / task.exact:.4f}"
        return f"{p:.4e}", f"{p / many:.4f}", exact

    error = f"{np.sqrt((1 - many) / many / SAMPLES):.1%}"
    yield name, f"{SAMPLES} samples", *probabilities(many), error, "", "", "", ""
    for options in METHODS:
        one = time_action(lambda o=options: lp.reliability(**task.call, **o), 1)
        found = one.result
        p, off = found.probability, found.sampled.deviation
        told = (f"{off:.1%}", f"{(1 - p) / p / off**2:.0f}") if off else ("", "")
        counts = (str(found.evaluations), str(found.gradients), f"{one.seconds:.2f}")
        yield name, options["search"], *probabilities(p), told[0], *counts, told[1]


def main() -> None:
    """Print the table and write it to the results."""
    head = ("drive", "method", "probability", "over samples", "over closed form", "deviation")
    head = (*head, "evaluations", "with gradients", "time, s", "plain samples")
    tasks = {
        "linear, normal": pull_inertia(),
        "frequency, lognormal": ground_inertia(),
        "two masses, curved": two_masses(),
    }
    publish("reliability", head, [row for item in tasks.items() for row in rows_of(*item)])


if __name__ == "__main__":
    main()
