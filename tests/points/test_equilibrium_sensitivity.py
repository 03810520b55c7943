"""Derivatives of equilibria by closed forms."""

import numpy as np
import pytest
from rows import assemble_rows

import lumped as lp
from lumped.components import Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptionError


class Decay(lp.Component):
    """``x' = u - k x``."""

    k: lp.Param = lp.param("1/s", "rate", 0.8)
    u: lp.Param = lp.param("m/s", "inflow", 0.5)
    x: lp.Var = lp.var("m", "position", start=1.5)

    def equations(self):
        yield lp.der(self.x) == self.u - self.k * self.x


def test_an_equilibrium_moves_as_its_closed_form():
    # tau_0 (1 - w/w_0) == d w behind a spring that carries this torque
    tau, w_0, d, c = 40.0, 100.0, 0.3, 900.0
    system = assemble_rows(
        "motor rotor shaft load oil wall",
        "rotor drag wall",
        motor=Torque(tau=tau),
        drag=Damper(d=tau / w_0),
        rotor=Inertia(J=0.2),
        shaft=SpringDamper(c=c, d=0.5),
        load=Inertia(J=1.0),
        oil=Damper(d=d),
        wall=Fixed(),
    )
    point = lp.equilibrium(system)
    of, to = ["load.w", "shaft.phi_rel"], ["motor.tau", "drag.d", "oil.d", "shaft.c", "load.J"]
    found = lp.points.equilibrium_sensitivity(point, of=of, by=to)

    def closed(tau, drag, d, c, J):
        w = tau / (drag + d)
        return np.array([w, -d * w / c])

    point = np.array([tau, tau / w_0, d, c, 1.0], dtype=complex)
    expected = [closed(*(point + 1e-30j * np.eye(5)[i])).imag / 1e-30 for i in range(5)]
    sign = np.sign(found.values[1] / closed(*point)[1].real)  # as the spring counts its twist
    assert found.values == pytest.approx(closed(*point).real * [1, sign], rel=1e-9)
    rows = np.array(expected).T * np.array([[1], [sign]])
    assert found.derivatives == pytest.approx(rows, rel=1e-9, abs=1e-12)
    assert found["load.w", "motor.tau"] == found.derivatives[0, 0]
    assert found.ranked("load.w")[0] == ("motor.tau", pytest.approx(1.0))
    figure = found.plot("load.w")  # the speed depends on neither c nor J
    assert len(figure.axes[0].patches) == 3
    assert figure.get_suptitle().endswith("\n2 without effect")
    assert "motor.tau +1.0000" in repr(found)


def test_a_point_that_is_no_equilibrium_is_refused():
    system = lp.assemble(Decay())
    point = lp.start_point(system)
    with pytest.raises(OptionError, match="no equilibrium"):
        lp.points.equilibrium_sensitivity(point, of=["x"])
    still = lp.equilibrium(system)
    found = lp.points.equilibrium_sensitivity(still, of=["x"])
    assert found["x", "k"] == pytest.approx(-0.5 / 0.64)
    with pytest.raises(OptionError):
        lp.points.equilibrium_sensitivity(still, of=[])
