"""Where branches of periodic motions end, and branches whose period another parameter keeps."""

import numpy as np
import pytest
from periodic_motions import ROTOR, TURN, torque_for
from scipy.integrate import solve_ivp

import lumped as lp
from lumped.errors import OptionError
from lumped.ops import cos


class Bob(lp.Component):
    """Pendulum of length one by its position: x leads while it is lower than its hinge."""

    x: lp.Var = lp.var("m", "across", start=0.0)
    y: lp.Var = lp.var("m", "up", start=-1.0)
    u: lp.Var = lp.var("m/s", "speed across")
    v: lp.Var = lp.var("m/s", "speed up")
    f: lp.Var = lp.var("1/s2", "force of the rod over mass and length")
    a: lp.Param = lp.param("m/s2", "push across", 0.5)

    def equations(self):
        yield lp.der(self.x) == self.u
        yield lp.der(self.y) == self.v
        yield lp.der(self.u) == self.a * cos(2.0 * lp.time) - self.f * self.x - 0.4 * self.u
        yield lp.der(self.v) == -self.f * self.y - 10.0 - 0.4 * self.v
        yield self.x**2 + self.y**2 == 1.0


def swing(x, u, a):
    """Angle and its rate after a period of the push, and the greatest angle, in polar form."""

    def rates(t, s):
        push = a * np.cos(2.0 * t) * np.cos(s[0])
        return [s[1], push - 10.0 * np.sin(s[0]) - 0.4 * s[1]]

    begin = [np.arcsin(x), u / np.sqrt(1 - x**2)]
    t = np.linspace(0, np.pi, 4001)
    found = solve_ivp(rates, (0, np.pi), begin, "DOP853", t_eval=t, rtol=1e-12, atol=1e-13)
    return found.y[:, -1] - begin, found.y[0].max()


def test_a_branch_ends_where_states_change_places():
    """A pendulum that swings up to its hinge; before it, the motions are those of its angle."""
    orbit = lp.periodic(lp.assemble(Bob()), period=np.pi, warm_up=30.0)
    branch = lp.orbits.branch(orbit, along={"a": (0.5, 30.0)}, step=0.1)
    assert "least value that was asked for" in branch.ends[0]
    assert "states change places during the period" in branch.ends[1]
    assert not branch.points
    x, u = (np.array([run[name][0] for run in branch.runs]) for name in "xu")
    highest = []
    for i in (0, len(x) // 2, len(x) - 1):
        missed, angle = swing(x[i], u[i], branch.values[i])
        assert np.abs(missed).max() < 1e-7
        assert branch["x"].highest[i] == pytest.approx(np.sin(angle), abs=1e-6)
        highest.append(angle)
    assert 0.99 * np.pi / 2 < highest[-1] < np.pi / 2


def test_a_branch_keeps_the_period_for_which_a_parameter_is_free():
    """The torque that turns an eccentric rotor at a mean speed, by an own calculation."""
    period = 2 * np.pi / 12.0
    orbit = lp.periodic(ROTOR, turn=TURN, period=period, free=["tau"])
    branch = lp.orbits.branch(orbit, along={"G": (0.0, 20.0)}, step=0.1)
    assert branch.periods == pytest.approx(np.full(len(branch.periods), period), rel=1e-14)
    for G in (0.0, 7.0, 20.0):
        (found,) = branch.at(G)
        wanted = torque_for(period, G=G)
        assert found.free["tau"] == pytest.approx(wanted, rel=1e-9)
        assert found.mean("w") == pytest.approx(12.0, rel=1e-9)
    assert branch.at(0.0)[0].free["tau"] == pytest.approx(0.5 * 12.0, rel=1e-10)
    with pytest.raises(OptionError, match="this motion determines tau, so that its period stays"):
        lp.orbits.branch(orbit, along={"tau": (0.0, 20.0)})
