"""Heat: paths of losses, and bodies that become warm."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, HeatPort, Input, Param, Var, der, param, var
from lumped.errors import DeclarationError
from lumped.language.switch import Item

__all__ = ["FixedTemperature", "HeatCapacitor", "HeatFlow", "Heated", "ThermalConductor"]


class HeatCapacitor(Component):
    """Body with one temperature: ``C der(T) = Q``."""

    symbol = "heat_capacity"
    port = HeatPort()
    C: Param = param("J/K", "heat capacity", above=0)
    T: Var = var("K", "temperature", 293.15, nominal=100.0)

    def equations(self) -> Iterator[Equation]:
        yield self.port.T == self.T
        yield self.C * der(self.T) == self.port.Q


class ThermalConductor(Component):
    """Heat conduction or convection without storage: ``Q = G (T_a - T_b)``, from a to b."""

    symbol = "resistor"
    port_a = HeatPort()
    port_b = HeatPort()
    G: Param = param("W/K", "thermal conductance", min=0)
    Q: Var = var("W", "heat flow from a to b")

    def equations(self) -> Iterator[Equation]:
        yield self.Q == self.G * (self.port_a.T - self.port_b.T)
        yield self.port_a.Q == self.Q
        yield self.port_b.Q == -self.Q


class FixedTemperature(Component):
    """Environment: ``T_port = T``, whatever heat flow that takes."""

    symbol = "temperature"
    port = HeatPort()
    T: Param = param("K", "temperature", 293.15, above=0)

    def equations(self) -> Iterator[Equation]:
        yield self.port.T == self.T


class HeatFlow(Component):
    """Heat source: ``Q_port = -Q``; it warms the parts joined to the port.

    `Q` is given as a number, as an expression of the time, or connected to a signal.
    """

    symbol = "heat_flow"
    port = HeatPort()
    Q: Input = Input("W", "heat flow into what is joined")

    def equations(self) -> Iterator[Equation]:
        yield self.port.Q == -self.Q


class Heated(Component):
    """Base class that gives a dissipating component a thermal port: ``Q_heat = -loss()``.

    The method `loss` of the component gives the dissipated power. Put `Heated` before the component
    in a class of your own::

        class HotBrake(Heated, Brake):
            '''Brake that warms its disc.'''

    The port `heat` must be connected, for example to a `HeatCapacitor`.
    """

    heat = HeatPort()

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        loss = self.loss()
        if loss is None:
            raise DeclarationError(
                f"{type(self).__name__}: Heated needs a component with a method loss, its "
                "dissipated power; write class HotBrake(Heated, Brake), Heated first."
            )
        yield self.heat.Q + loss == 0
