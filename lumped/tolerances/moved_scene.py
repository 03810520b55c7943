"""A scene that moves with a design: functionals and derivatives by scatter and by the design."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lumped.ensembles.distributions import Correlated
from lumped.ensembles.other_laws import Scaled
from lumped.ensembles.variants import Over, marginals_of
from lumped.errors import OptionError
from lumped.tolerances.evaluated import Array, Evaluated, Failures
from lumped.tolerances.scene import Scattered, Scene, evaluated_of, of_what

__all__ = ["MovedScene"]


class MovedScene:
    """One functional of what scatters around designs.

    Parameters of a design may scatter themselves, as `scaled` distributions; the others are the
    same in all samples of a design.

    Parameters
    ----------
    what : System, Modes or OrderResponse
        See `scene_of`.
    functional : functional
    over : mapping of name to distribution, or Correlated
        What scatters.
    design : sequence of str
        What a design consists of, m parameters.
    analysis : str
        With which errors begin.
    **options
        For a system: ``until``, ``parameters``, ``start`` and ``rtol``.

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
        **options: Any,
    ) -> None:
        given = [options.get(key) for key in ("until", "parameters", "start")]
        self.system, base = of_what(what, *given, analysis)
        self.over, self.design, self.analysis = over, tuple(design), analysis
        self.base = {self.system.key(name): value for name, value in (base or {}).items()}
        self.label = str(functional)
        names = marginals_of(self.system, over, parameters=base, analysis=analysis).names
        self._refuse_fixed(names)
        # places of the design among the parameters that are evaluated
        every = (*names, *(name for name in self.design if name not in names))
        self.count = len(names)
        self._places = [every.index(name) for name in self.design]
        self._functional = evaluated_of(
            what, every, {self.label: functional}, analysis=analysis, **options
        )

    def _refuse_fixed(self, names: Sequence[str]) -> None:
        """Refuse parameters of the design whose scatter would not follow."""
        over: Any = self.over
        given = over.distributions if isinstance(over, Correlated) else over
        for name, law in zip(names, given.values(), strict=True):
            if name in self.design and not isinstance(law, Scaled):
                raise OptionError(
                    f"{self.analysis}: {name} is in `vary` and scatters, but its distribution "
                    "does not follow its value. Give that of a factor, such as "
                    "lumped.distributions.scaled(lumped.normal(1.0, 0.05))."
                )

    def at(self, design: Mapping[str, float]) -> Scene:
        """The scene at a design."""
        base = self.base | dict(design)
        marginals = marginals_of(self.system, self.over, parameters=base, analysis=self.analysis)
        fixed = np.array([design[name] for name in self._others])
        held = _Held(self._functional, fixed)
        return Scene(self.system, self.over, marginals, held, base, self.analysis)

    @property
    def _others(self) -> list[str]:
        """What the design has beside what scatters."""
        return [n for n, k in zip(self.design, self._places, strict=True) if k >= self.count]

    def slopes(self, design: Mapping[str, float], u: Array) -> tuple[Array, Array, Failures]:
        """The functional, and its derivatives by the design where the scores are held.

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
        fixed = np.array([design[name] for name in self._others])
        values, slopes, failures = self._functional.slopes(_beside(x, fixed))
        found = slopes[:, 0, self._places]
        for j, (name, place) in enumerate(zip(self.design, self._places, strict=True)):
            if place < self.count:  # a factor times the value of the design
                found[:, j] *= x[:, place] / design[name]
        return values[:, 0], found, failures


class _Held:
    """Functionals where parameters beside those that scatter are held (see `Evaluated`)."""

    def __init__(self, whole: Evaluated, fixed: Array) -> None:
        self._whole, self._fixed = whole, fixed
        self.labels, self.units = whole.labels, whole.units

    def values(self, x: Array) -> tuple[Array, Failures]:
        return self._whole.values(_beside(x, self._fixed))

    def slopes(self, x: Array) -> tuple[Array, Array, Failures]:
        values, slopes, failures = self._whole.slopes(_beside(x, self._fixed))
        return values, slopes[:, :, : x.shape[1]], failures

    def curvatures(self, x: Array) -> Array:
        found = self._whole.curvatures(np.concatenate([x, self._fixed]))
        return found[:, : len(x), : len(x)]


def _beside(x: Array, fixed: Array) -> Array:
    """Values of all parameters, shape (n, d + m)."""
    return np.hstack([x, np.tile(fixed, (len(x), 1))])
