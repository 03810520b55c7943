"""A limit of one functional, over independent standard normal variables."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from lumped.errors import Interrupted, OptionError, SolverError
from lumped.support.arrays import Real
from lumped.support.text_table import list_names
from lumped.support.units import amount, plain
from lumped.tolerances.scene import Scene


class Limit:
    """The excess of a functional over its limit: positive where the limit is exceeded.

    Parameters
    ----------
    scene : Scene
        What scatters, and the functional that is computed.
    above, below : float or str or None
        The limit, in the SI unit of the functional or with a unit: one of both.

    Attributes
    ----------
    evaluations, gradients : int
        Runs or analyses so far, and those of them with derivatives.

    Raises
    ------
    OptionError
        If not exactly one limit is given, or it is no finite number.
    UnitError
        If it has a unit of another dimension.
    """

    def __init__(
        self, scene: Scene, above: float | str | None = None, below: float | str | None = None
    ) -> None:
        self.scene, (self.label,), (self.unit,) = scene, scene.labels, scene.units
        if (above is None) == (below is None):
            raise OptionError(
                f"reliability: {self.label}: give the limit as above= or as below=, one of both."
            )
        self.word, given, self.sign = (
            ("above", above, 1.0) if below is None else ("below", below, -1.0)
        )
        what = f"reliability: {self.word} ="
        self.bound = plain(given, self.unit or "1", what, OptionError)
        if not np.isfinite(self.bound):
            raise OptionError(f"{what} {given} must be a finite number.")
        self.evaluations = self.gradients = 0
        self._furthest = self._nearest = (np.nan, np.zeros(self.count))
        self.reason = ""
        self._known: dict[bytes, tuple[float, Real]] = {}

    @property
    def count(self) -> int:
        """How many parameters scatter."""
        return len(self.scene.names)

    @property
    def event(self) -> str:
        """What happens, in words."""
        return f"{self.label} {self.word} {self.amount(self.bound)}"

    @property
    def head(self) -> str:
        """With which errors begin."""
        return f"reliability: {self.event}"

    def amount(self, value: float) -> str:
        """A value of the functional with its unit."""
        return amount(value, self.unit)

    def values(self, u: Real) -> Real:
        """Excess at points, shape (n, d); nan where an evaluation failed.

        `Interrupted` holds the excess at the first of them.
        """
        try:
            values = self.scene.values(self.scene.physical(u))
        except Interrupted as error:
            known = error.partial
            self.evaluations += len(known)
            found = self._note_extremes(u[: len(known)], known)
            raise Interrupted(str(error), found) from None
        self.evaluations += len(u)
        return self._note_extremes(u, values)

    def slopes(self, u: Real) -> tuple[Real, Real]:
        """Excess at points, and its gradients, shape (n, d), by the standard normal variables.

        Each point is evaluated once.
        """
        keys = [point.tobytes() for point in u]
        new = [i for i, key in enumerate(keys) if key not in self._known]
        if new:
            try:
                values, by = self.scene.slopes(self.scene.physical(u[new]))
            except OptionError as error:
                raise OptionError(
                    f"{self.head}: {error} search='subset' needs no derivatives."
                ) from None
            self.evaluations += len(new)
            self.gradients += len(new)
            excess = self._note_extremes(u[new], values)
            for i, *known in zip(new, excess, self.sign * by[:, 0], strict=True):
                self._known[keys[i]] = known[0], known[1]
        found = [self._known[key] for key in keys]
        slopes = np.array([by for _, by in found])
        along = np.einsum("ni,nij->nj", slopes, self.scene.physical_slopes(u))
        return np.array([excess for excess, _ in found]), along

    def at(self, u: Real) -> tuple[Real, Real]:
        """Parameters at a point, and the derivatives of the excess by them.

        Raises
        ------
        SolverError
            If there are none.
        """
        self.slopes(u[None])
        return self.scene.physical(u[None])[0], self._there(self._known[u.tobytes()][1], u)

    def at_by_others(self, u: Real, others: Mapping[str, float]) -> Real:
        """Derivatives of the excess at a point by parameters that do not scatter, shape (m,).

        Parameters
        ----------
        others : mapping of str to float
            The m parameters and their values.

        Raises
        ------
        SolverError
            If there are none.
        """
        self.evaluations, self.gradients = self.evaluations + 1, self.gradients + 1
        by = self.scene.slopes_by_others(self.scene.physical(u[None]), others)
        return self._there(self.sign * by[0, 0], u)

    def _there(self, by: Real, u: Real) -> Real:
        if not np.isfinite(by).all():
            raise SolverError(
                f"{self.head} has no derivatives at its design point, {self.combination(u)}: "
                f"{next(iter(self.scene.failures.values()), '')} search='subset' needs none."
            )
        return by

    def curvature(self, x: Real) -> Real | None:
        """Exact second derivatives of the excess by the parameters, shape (d, d), if known."""
        found = self.scene.exact_curvatures(x)
        return None if found is None else self.sign * found[0]

    def _note_extremes(self, u: Real, values: Real) -> Real:
        """Excess of values of the functional, shape (n, 1)."""
        excess: Real = self.sign * (values[:, 0] - self.bound)
        for failure in list(self.scene.failures.values())[:1]:
            self.reason = failure
        known = np.flatnonzero(np.isfinite(excess))
        if len(known):
            most, least = known[excess[known].argmax()], known[excess[known].argmin()]
            if not excess[most] <= self._furthest[0]:
                self._furthest = float(excess[most]), u[most]
            if not excess[least] >= self._nearest[0]:
                self._nearest = float(excess[least]), u[least]
        return excess

    @cached_property
    def is_kept_by_median(self) -> bool:
        """Whether the limit is kept where all parameters have their median."""
        return not self.values(np.zeros((1, self.count)))[0] > 0

    @property
    def is_crossed(self) -> bool:
        """Whether values on both sides of the limit were met."""
        return self._nearest[0] <= 0 < self._furthest[0]

    def explain_unreached(self, where: str) -> SolverError:
        """The error that the limit is exceeded nowhere, or everywhere."""
        never = self._furthest[0] <= 0
        excess, u = self._furthest if never else self._nearest
        value, far = self.bound + self.sign * excess, float(np.linalg.norm(u))
        extreme = "greatest" if never == (self.sign > 0) else "least"
        met = "nowhere" if never else "everywhere"
        return SolverError(
            f"{self.head} is met {met} in {self.evaluations} evaluations {where}: the {extreme} "
            f"value found is {self.amount(value)}, with {self.combination(u)}, at beta = {far:.3g} "
            f"(probability {scipy.special.ndtr(-far):.2g}). Check the limit, its unit and the "
            "distributions."
        )

    def combination(self, u: Real) -> str:
        """Parameters at a point, in words."""
        x: Any = self.scene.physical(u[None])[0].tolist()
        pairs = zip(self.scene.names, x, self.scene.parameter_units, strict=True)
        return list_names([f"{name} = {amount(value, unit)}" for name, value, unit in pairs])
