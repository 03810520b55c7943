"""Functionals of runs at many values of parameters."""

from __future__ import annotations

from collections.abc import Mapping

from lumped.compiler.system import System
from lumped.ensembles.collected_runs import RunsAt
from lumped.errors import LumpedError, OptionError, UnknownNameError
from lumped.functionals import Functional
from lumped.gradients.gradient_ensemble import gradients_at
from lumped.timeloop.run_options import RunPlan
from lumped.tolerances.evaluated import Array, Evaluated, Evaluation


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
        super().__init__(system, names, of)
        self._plan, self._workers, self._analysis = plan, workers, analysis
        self.error = plan.rtol
        self._runs = RunsAt(system, names, of, plan, workers)

    def evaluate(self, x: Array, with_slopes: bool) -> Evaluation:
        """Functionals of all runs, and derivatives by the adjoint if they are asked for.

        Raises
        ------
        OptionError
            If a functional has no derivative.
        """
        unknown = Evaluation.unknown(len(x), len(self._of), with_slopes * x.shape[1])
        if not with_slopes:
            values, failures = self._runs(x)
            return unknown._replace(values=values, failures=failures)
        for label, wanted in self._of.items():
            if not all(reading.smooth for reading in wanted.readings):
                raise OptionError(
                    f"{self._analysis}: {label} has no derivative: numbers of events jump. Take a "
                    "method of samples."
                )
        of, plan = tuple(self._of.values()), self._plan
        try:
            found = gradients_at(self._system, self._names, x, of, self._names, plan, self._workers)
        except (OptionError, UnknownNameError):
            raise
        except LumpedError as error:
            return unknown._replace(failures=dict.fromkeys(range(len(x)), str(error)))
        return Evaluation(found.values, found.derivatives, found.failures)
