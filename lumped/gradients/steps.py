"""Steps of a system, with what is integrated."""

from __future__ import annotations

import casadi as ca

from lumped.compiler.system import System
from lumped.gradients.step_code import StepCode
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once
from lumped.timeloop.plants.many_points import ManyPoints
from lumped.timeloop.programs import refuse_programs
from lumped.timeloop.run import nominals


class Steps(StepCode):
    """Steps of one system with integrals of some products, and the same backwards.

    Parameters
    ----------
    system : System
        From `assemble`.
    products : tuple of tuple of str
        Factors of what is integrated.
    """

    def __init__(self, system: System, products: tuple[tuple[str, ...], ...]) -> None:
        self.system = system
        self.integrands = ca.vertcat(ca.SX(0, 1), *map(system.product, products))
        rates, inputs = system.rates, system.inputs
        own = rates, self.integrands, nominals(system)
        super().__init__(system.name, inputs, *own)

    @property
    @made_once
    def _integrated(self) -> ca.Function:
        return ca.Function("integrated", self.system.inputs, [ca.densify(self.integrands)])

    @property
    @made_once
    def integrated(self) -> ArrayFunction:
        """What is integrated, at one point: (x, p, t, m)."""
        return ArrayFunction(self._integrated)

    @property
    @made_once
    def integrated_along(self) -> ManyPoints:
        """What is integrated, at points of a run."""
        return ManyPoints(self._integrated)


@made_once
def steps_of(system: System, products: tuple[tuple[str, ...], ...]) -> Steps:
    """Steps of a system."""
    refuse_programs(system, "a derivative of a run")
    return Steps(system, products)
