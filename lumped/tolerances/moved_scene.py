"""A scene that moves with a design: functionals and derivatives by scatter and by the design."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lumped.ensembles.distributions import Correlated
from lumped.ensembles.other_laws import Scaled
from lumped.ensembles.variants import Over, marginals_of
from lumped.errors import OptionError
from lumped.timeloop.run_options import RunPlan
from lumped.tolerances.evaluated import Array, Evaluated, Failures
from lumped.tolerances.scene import Scattered, Scene, plan_scene


class MovedScene:
    """One functional of what scatters around designs.

    Parameters of a design may scatter themselves, as `scaled` distributions; the others are the
    same in all samples of a design.

    Parameters
    ----------
    what, over, analysis
        As for `scene_of`.
    functional : functional
    design : sequence of str
        What a design consists of, m parameters.
    plan : RunPlan or None
        Options of the runs of a system.

    Raises
    ------
    OptionError
        If a parameter of the design has a distribution that does not follow its value; otherwise
        as `scene_of`.
    """

    def __init__(
        self,
        what: Scattered,
        functional: Any,
        over: Over,
        design: Sequence[str],
        analysis: str,
        plan: RunPlan | None,
    ) -> None:
        self.first = plan_scene(what, over, [functional], plan, None, analysis)
        self.design, self.analysis = tuple(design), analysis
        names, system = self.first.names, self.first.system
        self._refuse_fixed()
        self._base = {system.key(k): value for k, value in (self.first.parameters or {}).items()}
        self._others = [name for name in self.design if name not in names]
        every = (*names, *self._others)
        self._places = [every.index(name) for name in self.design]
        self._whole = self.first.evaluated_over(every)

    def _refuse_fixed(self) -> None:
        """Refuse parameters of the design whose scatter would not follow."""
        over: Any = self.first.over
        given = over.distributions if isinstance(over, Correlated) else over
        for name, law in zip(self.first.names, given.values(), strict=True):
            if name in self.design and not isinstance(law, Scaled):
                raise OptionError(
                    f"{self.analysis}: {name} is in `vary` and scatters, but its distribution "
                    "does not follow its value. Give that of a factor, such as "
                    "lumped.distributions.scaled(lumped.normal(1.0, 0.05))."
                )

    def at(self, design: Mapping[str, float]) -> Scene:
        """The scene at a design."""
        system, over, base = self.first.system, self.first.over, self._base | dict(design)
        marginals = marginals_of(system, over, parameters=base, analysis=self.analysis)
        held = _Held(self._whole, self._fix_values(design))
        return Scene(system, over, marginals, lambda names: held, base, self.analysis)

    def _fix_values(self, design: Mapping[str, float]) -> Array:
        """Values of what the design has beside what scatters."""
        return np.array([design[name] for name in self._others])

    def slopes(self, design: Mapping[str, float], u: Array) -> tuple[Array, Array, Failures]:
        """The functional, and its derivatives by the design where the normal numbers are held.

        Parameters
        ----------
        design : mapping of str to float
        u : ndarray, shape (n, d)
            Standard normal numbers.

        Returns
        -------
        values : ndarray, shape (n,)
            Not a number where an evaluation failed.
        slopes : ndarray, shape (n, m)
        failures : dict of int to str
        """
        x = self.at(design).physical(u)
        values, slopes, failures = self._whole.slopes(_beside(x, self._fix_values(design)))
        found: Array = slopes[:, 0, self._places]
        for j, (name, place) in enumerate(zip(self.design, self._places, strict=True)):
            if place < x.shape[1]:  # a factor times the value of the design
                found[:, j] *= x[:, place] / design[name]
        return values[:, 0], found, failures


class _Held(Evaluated):
    """Functionals where parameters beside those that scatter are held (see `Evaluated`)."""

    def __init__(self, whole: Evaluated, fixed: Array) -> None:
        self._whole, self._fixed = whole, fixed
        self.labels, self.units, self.error = whole.labels, whole.units, whole.error

    def values(self, x: Array) -> tuple[Array, Failures]:
        return self._whole.values(_beside(x, self._fixed))

    def slopes(self, x: Array) -> tuple[Array, Array, Failures]:
        values, slopes, failures = self._whole.slopes(_beside(x, self._fixed))
        return values, slopes[:, :, : x.shape[1]], failures


def _beside(x: Array, fixed: Array) -> Array:
    """Values of all parameters, shape (n, d + m)."""
    return np.hstack([x, np.tile(fixed, (len(x), 1))])
