"""Excitation of synchronous machines, and damping of power oscillations by it.

Sources: Kundur, Power System Stability and Control, ch. 8 and 12; IEEE Std 421.5, type ST1A as
OpenIPSL has it; its type PSS1A was not read. These are the parts that small and large oscillations
need.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Input, Output, Param, Var, der, param, var
from lumped.components.control.controllers import limit_between

__all__ = ["PowerSystemStabiliser", "StaticExciter"]


class StaticExciter(Component):
    """Thyristor bridge on the terminals of its machine, with voltage control (as ST1A).

    ``T_R der(V_1) = V / V_n - V_1``, ``T_A der(E) = clip(K_A (V_ref + u - V_1), E_min V / V_n,
    E_max V / V_n) - E`` and ``y = v_n E``: a bridge gives the less the lower its supply. `v_n` is
    the voltage of the field winding that induces `V_n` at rated speed without load and saturation:
    ``v_n = R_f V_n / (w L_md)``. `u` is the signal of a stabiliser.

    With ``steady=True`` a run begins in steady state; set `V_ref` free. Limits of underexcitation
    and of the field current, and the load of the bridge, are left out.
    """

    symbol = "controller"
    V: Input = Input("V", "amplitude of the voltage of a phase at the terminals")
    u: Input = Input("1", "signal of a stabiliser over the rated voltage")
    steady: bool = False
    V_n: Param = param("V", "rated amplitude of the voltage of a phase", above=0)
    v_n: Param = param("V", "voltage of the field winding for the rated voltage", above=0)
    V_ref: Param = param("1", "wanted voltage over the rated one", 1.0)
    T_R: Param = param("s", "time constant of the measurement", above=0)
    K_A: Param = param("1", "gain", above=0)
    T_A: Param = param("s", "time constant of the control", above=0)
    E_min: Param = param("1", "least voltage over `v_n`, at rated terminal voltage")
    E_max: Param = param("1", "greatest voltage over `v_n`, at rated voltage", above=E_min)
    V_1: Var = var("1", "measured voltage over the rated one", state="prefer")
    E: Var = var("1", "voltage of the field winding over `v_n`", state="prefer")
    y = Output("V", "voltage of the field winding")

    def equations(self) -> Iterator[Equation]:
        V = self.V / self.V_n
        wanted = self.K_A * (self.V_ref + self.u - self.V_1)
        yield self.T_R * der(self.V_1) == V - self.V_1
        yield (
            self.T_A * der(self.E) == limit_between(wanted, self.E_min * V, self.E_max * V) - self.E
        )
        yield self.y == self.v_n * self.E

    def initial_equations(self) -> Iterator[Equation]:
        if self.steady:
            yield der(self.V_1) == 0
            yield der(self.E) == 0


class PowerSystemStabiliser(Component):
    """Stabiliser on the speed of the shaft: ``y = clip(K G(s) (w / w_s - 1), y_min, y_max)``.

    ``G(s) = T_w s / (1 + T_w s) (1 + T_1 s) / (1 + T_2 s) (1 + T_3 s) / (1 + T_4 s)`` (as PSS1A):
    a washout, which lets slow changes of the speed pass without an effect, and two leads for the
    lag of exciter and field. With equal `T_3` and `T_4` there is one.
    """

    symbol = "controller"
    w: Input = Input("rad/s", "speed of the shaft")
    w_s: Param = param("rad/s", "synchronous speed of the shaft", above=0)
    K: Param = param("1", "gain")
    T_w: Param = param("s", "time constant of the washout", above=0)
    T_1: Param = param("s", "lead of the first stage", min=0)
    T_2: Param = param("s", "lag of the first stage", above=0)
    T_3: Param = param("s", "lead of the second stage", 1.0, min=0)
    T_4: Param = param("s", "lag of the second stage", 1.0, above=0)
    y_min: Param = param("1", "least output")
    y_max: Param = param("1", "greatest output", above=y_min)
    x_w: Var = var("1", "slow part of the speed, times the gain", state="prefer")
    x_1: Var = var("1", "state of the first stage", state="prefer")
    x_2: Var = var("1", "state of the second stage", state="prefer")
    y = Output("1", "signal to the exciter")

    def equations(self) -> Iterator[Equation]:
        slip = self.K * (self.w / self.w_s - 1)
        washed = slip - self.x_w
        first = self.x_1 + self.T_1 / self.T_2 * (washed - self.x_1)
        second = self.x_2 + self.T_3 / self.T_4 * (first - self.x_2)
        yield self.T_w * der(self.x_w) == washed
        yield self.T_2 * der(self.x_1) == washed - self.x_1
        yield self.T_4 * der(self.x_2) == first - self.x_2
        yield self.y == limit_between(second, self.y_min, self.y_max)
