"""Probabilities and sample estimates of designs, with derivatives by the design."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lumped.errors import SolverError
from lumped.numerics.nearest_points import FURTHEST, Search
from lumped.support.text_table import amounts, listed, number
from lumped.tolerances.evaluated import Array
from lumped.tolerances.form import form, joined, nothing_found, searches
from lumped.tolerances.importance import around
from lumped.tolerances.limit import Limit
from lumped.tolerances.moved_scene import MovedScene
from lumped.tolerances.probability import Probability
from lumped.tolerances.robust_aims import RobustAim
from lumped.tolerances.sampled import Sampled

__all__ = ["CheckedAim", "CheckedProbability", "DesignAim", "DesignProbability"]

_MORE = 4
"""How much larger than a sample is the one by which it is checked."""

Design = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class CheckedProbability:
    """A probability at the best design, checked by samples.

    Attributes
    ----------
    wanted : Probability
        What was asked for.
    most : float or None
        Its greatest value; None where it was made small.
    beta : float
        Reliability index by the design point, the one nearest to the median.
    first_order : float
        Probability with the limit plane at each design point (FORM).
    sampled : Sampled or None
        Estimate from samples around the design points, with its interval of 95 %; None where the
        limit is out of reach, so that the probability is less than 1e-15.
    design_point : dict of str to float
        The most likely combination that fails.
    shift : float
        By how much beta had to be greater than that of the greatest probability, because the limit
        is no plane.
    searches : int
        How often the best design was searched, each time with another shift.
    """

    wanted: Probability
    most: float | None
    beta: float
    first_order: float
    sampled: Sampled | None
    design_point: dict[str, float]
    shift: float = 0.0
    searches: int = 1

    def __str__(self) -> str:
        aim = "" if self.most is None else f" <= {self.most:g}"
        text = f"{self.wanted}{aim}: beta {number(self.beta, 5)}, "
        if self.sampled is None or self.sampled.interval is None:
            return f"{text}the limit is out of reach"
        low, high = self.sampled.interval
        text += (
            f"{self.first_order:.3g} by its design point, {self.sampled.probability:.3g} by "
            f"{self.wanted.runs} samples ({low:.3g} to {high:.3g})"
        )
        if self.shift:
            text += f"; beta shifted by {self.shift:+.3g}, searched {self.searches} times"
        if self.sampled.failed:
            text += f"; {self.sampled.failed} samples failed"
        return "; ".join([text, *self.sampled.remarks])


@dataclass(frozen=True, eq=False)
class CheckedAim:
    """What sums up the scatter of a functional at the best design, by two samples.

    Attributes
    ----------
    aim : MeanPlusAim or QuantileAim
        What was asked for.
    value : float
        By the sample with which the design was found.
    fresh : float
        By another sample, four times as large.
    failed : int
        How many runs of this failed, and are left out of it.
    unit : str
        Of both values.
    """

    aim: RobustAim
    value: float
    fresh: float
    failed: int
    unit: str

    def __str__(self) -> str:
        *told, unit = amounts(str(self.aim.functional), self.unit, self.value, self.fresh)
        text = (
            f"{self.aim}: {told[0]} {unit} by {self.aim.runs} runs, {told[1]} {unit} by "
            f"{_MORE * self.aim.runs} others"
        )
        return text + (f", of which {self.failed} failed" if self.failed else "")


class DesignProbability:
    """The reliability index of designs, each found from the design point of the last.

    Parameters
    ----------
    wanted : Probability
    scene : MovedScene
        Of its functional.

    Attributes
    ----------
    evaluations : int
        Runs or analyses so far.
    """

    def __init__(self, wanted: Probability, scene: MovedScene) -> None:
        self.wanted, self.scene, self.evaluations = wanted, scene, 0
        self._begin: Array | None = None
        self._last: tuple[Design, float, Array] | None = None

    def limit(self, design: Design) -> Limit:
        """The limit at a design."""
        wanted = self.wanted
        return Limit(self.scene.at(design), wanted.above, wanted.below)

    def beta(self, design: Design) -> tuple[float, Array]:
        """Reliability index, and its derivatives by the design, shape (m,).

        Where the limit is out of reach, it is taken as plane from where the search ended. Whether
        it is smooth is looked at in `checked`.

        Raises
        ------
        SolverError
            As `form`.
        """
        if self._last is None or self._last[0] != design:
            limit = self.limit(design)
            beta, u, steepness = self._nearest(limit, design)
            _, slopes, _ = self.scene.slopes(design, u[None])
            self.evaluations += limit.evaluations + 1
            self._begin, self._last = u, (dict(design), beta, -limit.sign * slopes[0] / steepness)
        return self._last[1:]

    def _nearest(self, limit: Limit, design: Design) -> tuple[float, Array, float]:
        """Reliability index, the point it belongs to, and the growth of the excess there."""
        starts = 4 if self._begin is None else 1
        every = searches(limit, self._begin, starts)
        ends = [search for search in every if search.is_found]
        if not ends and starts == 1:
            self._begin = None
            return self._nearest(limit, design)
        if not ends and not limit.is_crossed:
            ends = [search for search in every if search.slope.any()]
        if not ends:
            told = listed([f"{name} = {value:.6g}" for name, value in design.items()])
            error = nothing_found(limit, every)
            raise SolverError(f"{self.scene.analysis}: at {told}: {error}", None)
        return min(map(_plane, ends), key=lambda plane: abs(plane[0]))

    def checked(
        self, design: Design, most: float | None, shift: float, searches: int
    ) -> CheckedProbability:
        """The probability by samples around all design points that are found from four starts."""
        beta, limit = self.beta(design)[0], self.limit(design)
        if beta >= FURTHEST:
            return CheckedProbability(self.wanted, most, beta, 0.0, None, {}, shift, searches)
        points = form(limit, self._begin)
        if points[0].beta < beta:  # nearer than the one that was followed
            self._begin, self._last, beta = points[0].u, None, points[0].beta
        found = around(limit, [point.u for point in points], self.wanted.runs, self.wanted.seed)
        own = dict(zip(limit.scene.names, points[0].x.tolist(), strict=True))
        plane = joined(points)
        return CheckedProbability(self.wanted, most, beta, plane, found, own, shift, searches)


def _plane(search: Search) -> tuple[float, Array, float]:
    """Distance of the median from a limit that is plane at the end of a search."""
    steepness = float(np.linalg.norm(search.slope))
    return float(search.slope @ search.u - search.g) / steepness, search.u, steepness


class DesignAim:
    """What sums up scatter at designs, over the same standard normal numbers for each.

    Parameters
    ----------
    aim : MeanPlusAim or QuantileAim
    scene : MovedScene
        Of its functional.

    Attributes
    ----------
    evaluations : int
        Runs or analyses so far.
    """

    def __init__(self, aim: RobustAim, scene: MovedScene) -> None:
        self.aim, self.scene, self.evaluations = aim, scene, 0
        self._scores: Array | None = None
        self._last: tuple[Design, float, Array] | None = None

    def at(self, design: Design) -> tuple[float, Array]:
        """Value, and its derivatives by the design, shape (m,).

        Raises
        ------
        SolverError
            If a run fails.
        """
        if self._last is None or self._last[0] != design:
            if self._scores is None:
                scene = self.scene.at(design)
                self._scores = scene.scores(self.aim.runs, self.aim.seed, "sobol")
            values, slopes, failures = self.scene.slopes(design, self._scores)
            self.evaluations += len(values)
            for run, reason in failures.items():
                told = [f"{name} = {value:.6g}" for name, value in design.items()]
                raise SolverError(
                    f"{self.scene.analysis}: {self.aim}: {len(failures)} of {self.aim.runs} runs "
                    f"fail at {listed(told)}. Run {run}: {reason}",
                    None,
                )
            self._last = dict(design), *self.aim.of_sample(values, slopes)
        return self._last[1:]

    def checked(self, design: Design) -> CheckedAim:
        """The value beside that of a fresh sample."""
        scene = self.scene.at(design)
        u = scene.scores(_MORE * self.aim.runs, self.aim.seed + 1, "sobol")
        values = scene.values(scene.physical(u))[:, 0]
        sound = values[np.isfinite(values)]
        fresh, _ = self.aim.of_sample(sound, np.zeros((len(sound), 0)))
        value, failed = self.at(design)[0], len(values) - len(sound)
        return CheckedAim(self.aim, value, fresh, failed, scene.units[0])
