"""Functionals of runs at many values of parameters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lumped.compiler.system import System
from lumped.ensembles.collected_runs import RunsAt
from lumped.errors import LumpedError, OptionError, UnknownNameError
from lumped.functionals import Functional
from lumped.gradients.gradient_ensemble import gradients_at
from lumped.timeloop.run_options import RunPlan
from lumped.tolerances.evaluated import Array, Evaluated, Failures


class OfRuns(Evaluated):
    """Functionals of runs, in the time loop and on all cores (see `Evaluated`).

    Parameters
    ----------
    system : System
    names : tuple of str
        What varies.
    of : mapping of str to functional
    plan : RunPlan
        Options of each run.
    workers : int or None
    analysis : str
        With which errors begin.
    """

    def __init__(
        self,
        system: System,
        names: tuple[str, ...],
        of: Mapping[str, Functional],
        plan: RunPlan,
        workers: int | None,
        analysis: str,
    ) -> None:
        self._system, self._names, self._of = system, names, dict(of)
        self._plan, self._workers, self._analysis = plan, workers, analysis
        self.error = plan.rtol
        self._runs = RunsAt(system, names, of, plan, workers)
        self.labels = tuple(of)
        self.units = tuple(functional.unit(system) for functional in of.values())

    def values(self, x: Array) -> tuple[Array, Failures]:
        """Functionals of all runs."""
        return self._runs(x)

    def slopes(self, x: Array) -> tuple[Array, Array, Failures]:
        """Functionals and derivatives of all runs, by the adjoint.

        Raises
        ------
        OptionError
            If a functional has none.
        """
        for label, wanted in self._of.items():
            if not all(reading.smooth for reading in wanted.readings):
                raise OptionError(
                    f"{self._analysis}: {label} has no derivative: numbers of events jump. Take a "
                    "method of samples."
                )
        shape = len(x), len(self._of)
        try:
            found = gradients_at(
                self._system,
                self._names,
                x,
                tuple(self._of.values()),
                self._names,
                self._plan,
                self._workers,
            )
        except (OptionError, UnknownNameError):
            raise
        except LumpedError as error:
            lost = dict.fromkeys(range(len(x)), str(error))
            return np.full(shape, np.nan), np.full((*shape, x.shape[1]), np.nan), lost
        return found.values, found.derivatives, found.failures
