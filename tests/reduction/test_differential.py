"""A differential over a hundred turns of its cage: no drift, equal torques, closed forms."""

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.linalg import expm

import lumped as lp
from lumped.components import Damper, Fixed, IdealGear, Inertia, Spring, Torque
from lumped.errors import EquationError

TURNS = 100


class Differential(lp.Component):
    """Bevel differential without mass: the cage turns with the mean of its sides."""

    cage = lp.Flange()
    left = lp.Flange()
    right = lp.Flange()

    def equations(self):
        c, a, b = self.cage, self.left, self.right
        yield lp.lossless(c.phi == (a.phi + b.phi) / 2, c, a, b)


def drift(run):
    """Largest gap between the angle of the cage and the mean of its sides, over the angle."""
    gap = run["cage.phi"] - (run["left.phi"] + run["right.phi"]) / 2
    return np.abs(gap).max() / np.abs(run["cage.phi"]).max()


def check_torques(run):
    """Virtual work: each side takes half of what the cage gives."""
    left, right, cage = (run[f"set.{port}.tau"] for port in ("left", "right", "cage"))
    assert np.abs(left).max() > 1
    assert left == pytest.approx(right, abs=1e-10)
    assert cage == pytest.approx(-2 * left, abs=1e-10)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_differential_with_unequal_loads_turns_a_hundred_times_without_drift(method):
    J_cage, J_left, J_right, d_left, d_right, d_slip = 0.4, 1.0, 1.5, 0.3, 0.5, 0.1
    tau, load, end, n = 20.0, -4.0, 40.0, 4000
    model = lp.compose(
        drive=Torque(tau=tau),
        cage=Inertia(J=J_cage, phi=0.0),
        set=Differential(),
        left=Inertia(J=J_left, w=3.0, phi=0.2),
        right=Inertia(J=J_right, w=-5.0),
        tyre=[Damper(d=d_left), Damper(d=d_right)],
        slip=Damper(d=d_slip),
        load=Torque(tau=load),
        ground=Fixed(),
        connections=lambda m: [
            *lp.chain(m.drive, m.cage, m.set.cage),
            lp.connect(m.set.left, m.left.flange_a, m.slip.flange_a),
            lp.connect(m.set.right, m.right.flange_a, m.slip.flange_b),
            lp.connect(m.left.flange_b, m.tyre[0].flange_a),
            lp.connect(m.right.flange_b, m.tyre[1].flange_a, m.load.flange),
            lp.connect(m.ground.flange, *(tyre.flange_b for tyre in m.tyre)),
        ],
    )
    system = lp.assemble(model, keep=["left.phi", "right.phi"])
    run = lp.simulate(system, until=end, rtol=1e-9, method=method, grid=n)
    turns = run["cage.phi"][-1] / (2 * np.pi)
    print(f"{turns:.0f} turns, drift {drift(run):.1e}, {run.statistics}")
    assert turns > TURNS
    assert drift(run) < 1e-9
    check_torques(run)

    mass = np.diag([J_left, J_right]) + J_cage / 4
    drag = np.diag([d_left, d_right]) + d_slip * np.array([[1, -1], [-1, 1]])
    A = np.zeros((5, 5))  # angles and speeds of the sides, and the number one
    A[:2, 2:4] = np.eye(2)
    A[2:4, 2:4] = -np.linalg.solve(mass, drag)
    A[2:4, 4] = np.linalg.solve(mass, [tau / 2, tau / 2 + load])
    step, x = expm(A * end / n), np.array([0.2, -0.2, 3.0, -5.0, 1.0])
    expected = np.array([x := step @ x if k else x for k in range(n + 1)])
    assert np.allclose(run.t, np.linspace(0, end, n + 1), rtol=1e-12)
    names = ["left.phi", "right.phi", "left.w", "right.w"]
    error = np.abs(run.table(names) - expected[:, :4]).max(axis=0)
    assert (error < 1e-8 * np.abs(expected[:, :4]).max(axis=0)).all()

    w_left, w_right, w_cage = run["left.w"], run["right.w"], run["cage.w"]
    kinetic = (J_cage * w_cage**2 + J_left * w_left**2 + J_right * w_right**2) / 2
    given = tau * run["cage.phi"] + load * (run["right.phi"] + 0.2)
    loss = d_left * w_left**2 + d_right * w_right**2 + d_slip * (w_left - w_right) ** 2
    lost = simpson(loss, x=run.t)
    balance = kinetic[-1] - kinetic[0] + lost - given[-1]
    assert abs(balance) < 1e-9 * given[-1]


def car_in_a_curve(**shafts):
    """A cage drives two wheels that the road turns at unequal speeds: 1.1 and 0.9 of the car's."""
    return lp.compose(
        drive=Torque(tau=6.0),
        cage=Inertia(J=0.4, phi=0.0),
        set=Differential(),
        left=Inertia(J=1.0),
        right=Inertia(J=1.5),
        **shafts,
        outer=IdealGear(ratio=1.1),
        inner=IdealGear(ratio=0.9),
        car=Inertia(J=5.0, w=2.0),
        connections=lambda m: [
            *lp.chain(m.drive, m.cage, m.set.cage),
            *lp.chain(m.set.left, m.left, *([m.one] if shafts else []), m.outer, m.car),
            *lp.chain(m.set.right, m.right, *([m.two] if shafts else []), m.inner),
            lp.connect(m.inner.flange_b, m.car.flange_a),
        ],
    )


def test_a_car_in_a_curve_closes_a_rigid_loop_over_its_differential():
    system = lp.assemble(car_in_a_curve(), keep=["cage.phi"])
    assert len(system.state_names) == 2
    run = lp.simulate(system, until=40.0, rtol=1e-9, grid=2000)
    assert run["cage.phi"][-1] > TURNS * 2 * np.pi
    assert drift(run) < 1e-9
    check_torques(run)
    scale = np.abs(run["car.phi"]).max()
    assert np.abs(run["left.phi"] - 1.1 * run["car.phi"]).max() < 1e-9 * scale
    assert np.abs(run["right.phi"] - 0.9 * run["car.phi"]).max() < 1e-9 * scale
    acceleration = 6.0 / (0.4 + 1.0 * 1.1**2 + 1.5 * 0.9**2 + 5.0)  # the cage turns with the car
    assert run["car.phi"] == pytest.approx(2 * run.t + acceleration / 2 * run.t**2, rel=1e-8)
    assert run["car.w"] == pytest.approx(2 + acceleration * run.t, rel=1e-8)


def test_elastic_half_shafts_keep_the_loop_and_the_energy():
    model = car_in_a_curve(one=Spring(c=900.0), two=Spring(c=400.0))
    run = lp.simulate(lp.assemble(model, keep=["cage.phi"]), until=40.0, rtol=1e-10, grid=2000)
    turns = run["cage.phi"][-1] / 2 / np.pi
    kinetic = sum(
        J / 2 * run[f"{name}.w"] ** 2
        for name, J in {"cage": 0.4, "left": 1.0, "right": 1.5, "car": 5.0}.items()
    )
    stored = sum(run[f"{name}.tau"] ** 2 / (2 * c) for name, c in (("one", 900), ("two", 400)))
    balance = kinetic + stored - 6.0 * run["cage.phi"]
    error = np.abs(balance - balance[0]).max() / kinetic.max()
    assert turns > TURNS
    assert drift(run) < 1e-9
    assert error < 1e-9
    check_torques(run)
    # twists are what the angles of the wheels and of the car say
    for name, wheel, ratio in (("one", "left", 1.1), ("two", "right", 0.9)):
        twist = ratio * run["car.phi"] - run[f"{wheel}.phi"]
        assert np.abs(run[f"{name}.phi_rel"] - twist).max() < 1e-9 * run["car.phi"].max()


class RateGear(lp.Component):
    """Lossless parts of rates: a gear, a differential, and a screw whose pitch grows."""

    a = lp.Flange()
    b = lp.Flange()
    c = lp.Flange(free=True)
    ratio: lp.Param = lp.param("1", "ratio", 3.0)
    law: object = None

    def equations(self):
        yield lp.lossless(self.law(self), self.a, self.b, self.c)


@pytest.mark.parametrize(
    ("law", "factors"),
    [
        (lambda g: lp.der(g.a.phi) == g.ratio * lp.der(g.b.phi), (3.0, 0.0)),
        (lambda g: lp.der(g.a.phi) == -lp.der(g.b.phi / 2) - lp.der(g.c.phi) * 4.0, (-0.5, -4.0)),
        (
            lambda g: lp.der(g.a.phi) == (lp.der(g.b.phi) + lp.der(g.c.phi)) / g.ratio + 0.0,
            (1 / 3, 1 / 3),
        ),
        (lambda g: lp.der(g.a.phi) == lp.ops.cos(g.b.phi) * lp.der(g.b.phi), None),
    ],
)
def test_rates_of_a_lossless_part_give_its_torques(law, factors):
    """Lagrange: ``(J_b + i**2 J_a) der(w_b) + i i' w_b**2 J_a == 0`` with one output of factor i.

    With two outputs at constant factors, ``J_k w_k + i_k J_a w_a`` stays what it was.
    """
    J = {"A": 2.0, "B": 5.0, "C": 7.0}
    model = lp.compose(
        **{name: Inertia(J=value) for name, value in J.items()},
        push=Torque(tau=11.0),
        gear=RateGear(law=law),
        connections=lambda m: [
            *(lp.connect(getattr(m, n).flange_a, getattr(m.gear, n.lower())) for n in J),
            lp.connect(m.push.flange, m.A.flange_b),
        ],
    )
    start = {"B.w": 2.0, "B.phi": 0.3}
    run = lp.simulate(lp.assemble(model, keep=["B.phi"]), until=1.5, start=start, rtol=1e-10)
    w = {name: run[f"{name}.w"] for name in J}
    if factors is None:
        i = np.cos(run["B.phi"])
        energy = sum(0.5 * J[n] * w[n] ** 2 for n in "AB")
        work = 11.0 * (np.sin(run["B.phi"]) - np.sin(0.3))
        assert w["A"] == pytest.approx(i * w["B"], rel=1e-8)
        assert energy - energy[0] == pytest.approx(work, rel=1e-7, abs=1e-7)
        return
    assert w["A"] == pytest.approx(factors[0] * w["B"] + factors[1] * w["C"], abs=1e-8)
    # the impulse of the torque, less that of A, passes on by the factors
    passed = 11.0 * run.t - J["A"] * (w["A"] - w["A"][0])
    for name, factor in zip("BC", factors, strict=True):
        assert J[name] * (w[name] - w[name][0]) == pytest.approx(factor * passed, abs=1e-7)


@pytest.mark.parametrize(
    "law",
    [
        lambda g: lp.der(g.a.phi) == lp.der(g.b.phi) ** 2,
        lambda g: lp.der(g.a.phi) == lp.der(g.b.phi) * lp.der(g.c.phi),
        lambda g: lp.der(g.a.phi) == lp.der(g.a.phi) + lp.der(g.b.phi),
        lambda g: 2 * lp.der(g.a.phi) == lp.der(g.b.phi),
    ],
)
def test_rates_that_give_no_torques_are_refused(law):
    with pytest.raises(EquationError, match="lossless"):
        list(RateGear(law=law).equations())
