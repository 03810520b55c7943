"""Drives that stick, slide and switch: equilibria against closed forms, stick-slip both ways."""

import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Damper, Fixed, Inertia, SlipCoupling, Speed

W_A, W_B, D_A, D_B = 30.0, 10.0, 2.0, 3.0
NEEDED = D_A * D_B / (D_A + D_B) * (W_A - W_B)  # to turn both at one speed
ANYWHERE = [{}, {"a.w": 50.0}, {"b.w": 50.0}, {"a.w": -5.0, "b.w": 5.0}]


def pair(static, kinetic):
    """Two bodies led by dampers to different speeds, with a slip coupling between them."""
    return in_a_row(
        lead_a=Speed(w=W_A),
        damper_a=Damper(d=D_A),
        a=Inertia(J=1.0),
        coupling=SlipCoupling(static=static, kinetic=kinetic, u=1.0),
        b=Inertia(J=2.0),
        damper_b=Damper(d=D_B),
        lead_b=Speed(w=W_B),
    )


@pytest.mark.parametrize("start", ANYWHERE)
def test_a_coupling_that_can_hold_turns_both_sides_at_one_speed(start):
    system = lp.assemble(pair(1.5 * NEEDED, 1.2 * NEEDED))
    point = lp.equilibrium(system, start=start)
    received = [point[name] for name in ("a.w", "b.w", "coupling.tau", "coupling.position")]
    common = (D_A * W_A + D_B * W_B) / (D_A + D_B)
    expected = [common, common, -NEEDED, 0.0]
    assert received == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("start", ANYWHERE)
def test_a_coupling_that_is_too_weak_slips_steadily(start):
    kinetic = 0.5 * NEEDED
    system = lp.assemble(pair(0.6 * NEEDED, kinetic))
    point = lp.equilibrium(system, start=start)
    received = [point[name] for name in ("a.w", "b.w", "coupling.tau", "coupling.position")]
    expected = [W_A - kinetic / D_A, W_B + kinetic / D_B, -kinetic, -1.0]
    assert received == pytest.approx(expected, rel=1e-9)


class Governed(lp.Component):
    """Motor whose torque drops above 100 rad/s."""

    flange = lp.Flange()
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self):
        yield self.w == lp.der(self.flange.phi)
        drop = lp.ops.where(self.w > 100.0, 4.0 * (self.w - 100.0), 0.0)
        yield self.flange.tau == drop - 20.0


@pytest.mark.parametrize("w", [0.0, 150.0])
def test_the_branch_of_a_characteristic_is_that_of_the_equilibrium(w):
    drive = in_a_row(motor=Governed(), body=Inertia(J=0.5), load=Damper(d=0.1), ground=Fixed())
    received = lp.equilibrium(lp.assemble(drive), start={"body.w": w})["body.w"]
    expected = (20.0 + 4.0 * 100.0) / 4.1  # 20 - 4 (w - 100) = 0.1 w
    assert received == pytest.approx(expected, rel=1e-9)
