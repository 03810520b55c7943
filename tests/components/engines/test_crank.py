"""Cranks against closed forms, Newton and Euler, and conservation."""

import numpy as np
import pytest
from checks import refused, worst
from rows import assemble_rows, in_a_row

import lumped as lp
from lumped.components import (
    CrankSlider,
    Inertia,
    Position,
    RotatingMass,
    SpringDamper,
    StrokeLoad,
    translation,
)
from lumped.errors import ParameterError, SolverError

R, L, E = 0.59, 4.25, 0.33
DEGREES = np.arange(0.0, 360.25, 0.5)


def turning(parts, w=1.0, begin=0.0, **more):
    """Parts on a shaft that turns at the speed w."""

    def connections(m):
        yield lp.connect(m.turn.flange, *(part.flange for part in m.parts))
        if "ground_x" in more:
            yield lp.connect(m.ground_x.flange, *(part.frame_x for part in m.parts))
            yield lp.connect(m.ground_y.flange, *(part.frame_y for part in m.parts))

    turn = Position(phi=begin + w * lp.time)
    return lp.assemble(lp.compose(turn=turn, parts=parts, **more, connections=connections))


def grounded():
    return {"ground_x": translation.Fixed(), "ground_y": translation.Fixed()}


def revolve(parts, w=1.0, degrees=DEGREES, **more):
    angles = np.radians(degrees)
    system = turning(parts, w, angles[0], **more)
    times = (angles - angles[0]) / w
    return lp.simulate(system, until=times[-1], grid=times)


class TestKinematics:
    @pytest.mark.parametrize("e", [0.0, E, -E])
    @pytest.mark.parametrize("assembly", [1, -1])
    def test_velocity_is_that_of_the_closed_form(self, e, assembly):
        w, q = 3.0, np.radians(DEGREES)
        run = revolve([CrankSlider(r=R, L=L, e=e, assembly=assembly)], w)
        psi = np.arcsin((e - R * np.sin(q)) / L)
        psi = psi if assembly == 1 else np.pi - psi
        # the rod keeps its length: speeds of both ends along it are equal
        expected = R * w * np.sin(psi - q) / np.cos(psi)
        assert worst(run["parts[0].v"], expected) < 1e-12
        assert worst(run["parts[0].s"], R * np.cos(q) + L * np.cos(psi)) < 1e-14
        turned = (run["parts[0].psi"] - psi + np.pi) % (2 * np.pi) - np.pi
        assert np.abs(turned).max() < 1e-14
        assert worst(run["parts[0].w_rod"], -w * R * np.cos(q) / (L * np.cos(psi))) < 1e-12

    @pytest.mark.parametrize(
        ("angle", "reach"),
        [(-np.arcsin(E / (L + R)), L + R), (np.pi - np.arcsin(E / (L - R)), L - R)],
    )
    def test_velocity_is_zero_at_the_dead_centres(self, angle, reach):
        crank = CrankSlider(r=R, L=L, e=-E, m=100.0)
        point = lp.start_point(turning([crank], begin=angle))
        assert abs(point["parts[0].v"]) < 1e-15
        assert abs(point["parts[0].s"] - np.sqrt(reach**2 - E**2)) < 2e-15
        assert abs(point["turn.flange.tau"]) < 1e-13

    @pytest.mark.parametrize("assembly", [1, -1])
    def test_closed_linkage_follows_the_assembly_it_starts_in(self, assembly):
        crank = {"r": R, "L": L, "e": E, "m": 10.0, "m_rod": 3.0, "J_rod": 2.0, "k": 0.4}
        start = {"parts[0].psi": 0.0 if assembly == 1 else np.pi}
        system = turning([CrankSlider(**crank, assembly=0)])
        times = np.radians(DEGREES)
        run = lp.simulate(system, until=times[-1], grid=times, start=start)
        fixed = revolve([CrankSlider(**crank, assembly=assembly)])
        for name in ("parts[0].s", "parts[0].v", "turn.flange.tau", "parts[0].guide"):
            assert worst(run[name], fixed[name]) < 1e-12

    def test_no_crank_leaves_the_slider_where_it_is(self):
        run = revolve([CrankSlider(r=0.0, L=L, e=E, m=5.0, m_rod=1.0)])
        assert np.abs(run["parts[0].s"] - np.sqrt(L**2 - E**2)).max() < 1e-15
        assert np.abs(run["turn.flange.tau"]).max() == 0


def moment(arm, force):
    """Of a force in the plane."""
    return arm[0] * force[1] - arm[1] * force[0]


def newton_euler(p, q, w, g):
    """Forces on a rod by its own balance of forces and moments; crank speed w constant.

    Returns crank torque, guide force to the left, bearing force along and across the slide.
    `g`: weight per mass, along and across the slide.
    """
    r, length, k = p["r"], p["L"], p["k"]
    psi = np.arcsin((p["e"] - r * np.sin(q)) / length)
    w_rod = -r * w * np.cos(q) / (length * np.cos(psi))
    a_rod = (r * w**2 * np.sin(q) + length * w_rod**2 * np.sin(psi)) / (length * np.cos(psi))
    along, left = (np.array([np.cos(psi), np.sin(psi)]), np.array([-np.sin(psi), np.cos(psi)]))
    pin = -r * w**2 * np.array([np.cos(q), np.sin(q)])
    rod = pin + k * length * (a_rod * left - w_rod**2 * along)
    end = pin + length * (a_rod * left - w_rod**2 * along)
    assert abs(end[1]) < 1e-9

    # unknown: force on the rod at the pin (x, y), guide force; force at the slider from its balance
    def balance(x):
        at_pin, guide = x[:2], x[2]
        at_end = np.array([0.0, guide]) + p["m"] * (g - end)
        forces = at_pin + at_end + p["m_rod"] * (g - rod)
        arms = moment(-k * length * along, at_pin) + moment((1 - k) * length * along, at_end)
        return np.array([*forces, arms - p["J_rod"] * a_rod])

    zero = balance(np.zeros(3))
    matrix = np.array([balance(unit) - zero for unit in np.eye(3)]).T
    x, y, guide = np.linalg.solve(matrix, -zero)
    arm = r * np.array([np.cos(q), np.sin(q)])
    return moment(arm, (x, y)), guide, -x, -y


ROD = {"r": 0.59, "L": 1.7, "e": 0.2, "m": 9.0, "m_rod": 4.0, "J_rod": 0.8, "k": 0.3}


class TestRod:
    @pytest.mark.filterwarnings("ignore:Arrays of 2-dimensional vectors")
    @pytest.mark.parametrize("axis", [0.0, np.pi / 2, 2.0])
    def test_forces_are_those_of_newton_and_euler(self, axis):
        w, g, down = 5.0, 9.81, -1.1
        run = revolve([CrankSlider(**ROD, axis=axis, phase=0.7, g=g, down=down)], w)
        turn = np.array([[np.cos(axis), np.sin(axis)], [-np.sin(axis), np.cos(axis)]])
        weight = g * turn @ [np.cos(down), np.sin(down)]
        expected = [newton_euler(ROD, q, w, weight) for q in np.radians(DEGREES) + 0.7 - axis]
        names = ["turn.flange.tau", "parts[0].guide", "parts[0].bearing_x", "parts[0].bearing_y"]
        tau, guide, x, y = run.table(names).T
        bearing = turn @ [x, y]
        received = np.array([-tau, guide, *bearing])
        for name, got, wanted in zip(names, received, np.transpose(expected), strict=True):
            assert worst(got, wanted) < 1e-11, name

    def test_two_masses_give_the_same_force_and_another_torque(self):
        run = revolve([CrankSlider(**ROD)], **grounded())
        split = revolve([CrankSlider(**ROD, two_mass=True)], **grounded())
        for end in ("ground_x", "ground_y"):
            assert worst(split[f"{end}.flange.f"], run[f"{end}.flange.f"]) < 1e-14
        p = ROD
        spare = p["J_rod"] - p["m_rod"] * p["k"] * (1 - p["k"]) * p["L"] ** 2
        expected = spare * run["parts[0].a_rod"] * run["parts[0].w_rod"]  # power at 1 rad/s
        assert worst(split["turn.flange.tau"] - run["turn.flange.tau"], expected) < 1e-12
        assert spare < 0

    @pytest.mark.parametrize("length", [42.5, 4250.0, 4.25e6])
    def test_long_rods_give_a_pure_cosine(self, length):
        run = revolve([CrankSlider(r=R, L=length, m=1.0)])
        received = np.abs(run["parts[0].a"] + R * np.cos(np.radians(DEGREES))).max()
        assert abs(received * length / R**2 - 1) < (R / length) ** 2 + 1e-6


class TestShortRod:
    def test_velocity_changes_fast_where_the_rod_is_just_long_enough(self):
        near = np.array([89.999, 90.0, 90.001])
        run = revolve([CrankSlider(r=R, L=0.9200001, e=E, phase=np.pi, assembly=-1)], degrees=near)
        assert np.abs(run["parts[0].v"][[0, 2]] - [0.61208, 0.56792]).max() < 5.1e-6

    def test_velocity_all_but_jumps_on_either_side_of_the_change_point(self):
        near, longer = np.array([89.9, 90.1]), 0.92 * (1 + 1.1e-8)
        run = revolve([CrankSlider(r=R, L=longer, e=E, phase=np.pi, assembly=-1)], degrees=near)
        q = np.radians(near) + np.pi
        rise = E - R * np.sin(q)
        expected = -R * np.sin(q) - R * np.cos(q) * rise / np.sqrt(longer**2 - rise**2)
        assert np.abs(run["parts[0].v"] - expected).max() < 1e-6
        # at the change point of a rod of 0.92 itself it jumps between these
        root = np.sqrt(0.92 / R)
        assert np.abs(run["parts[0].v"] - [R * (1 + root), R * (1 - root)]).max() < 5e-3

    @pytest.mark.parametrize(("e", "longer"), [(0.0, 0.0), (E, 0.0), (-E, 0.0), (E, 1e-9)])
    @pytest.mark.parametrize("assembly", [1, -1])
    def test_rod_that_turns_at_once_is_refused(self, e, longer, assembly):
        crank = CrankSlider(r=R, L=(R + abs(e)) * (1 + longer), e=e, m=100.0, assembly=assembly)
        model = in_a_row(fly=Inertia(J=50.0, w=2.0, phi=0.3), crank=crank)
        words = ("crank.L = ", "must be greater than", "(r + abs(e))")
        refused(ParameterError, lambda: lp.simulate(lp.assemble(model), until=12.0), *words)

    def swing(self, assembly, until):
        model = in_a_row(
            fly=Inertia(J=50.0),
            crank=CrankSlider(r=R, L=0.9, e=E, m=100.0, phase=np.pi, assembly=assembly),
        )
        start = {"fly.w": 1.0} | ({} if assembly else {"crank.psi": np.pi})
        return lp.simulate(lp.assemble(model), until=until, start=start, rtol=1e-8, grid=4000)

    def test_crank_turns_round_at_the_lock_while_the_slider_passes_through(self):
        run = self.swing(0, 12.0)
        lock = np.arcsin((0.9 - E) / R)
        assert abs(np.degrees(lock) - 75.0390) < 5e-5
        assert 0 < lock - run["fly.phi"].max() < 1e-4
        run_of_rod = np.cos(run["crank.psi"])
        assert run_of_rod.min() < -0.5  # begins behind the pin
        assert run_of_rod.max() > 0.5
        energy = 25 * run["fly.w"] ** 2 + 50 * run["crank.v"] ** 2
        assert np.ptp(energy) < 1e-6 * energy[0]

    @pytest.mark.parametrize("assembly", [1, -1])
    def test_one_assembly_alone_cannot_close(self, assembly):
        words = ("crank.L = 0.9 m (length of the rod)", "greater than r + abs(e) + 1e-08 * (r + ")
        refused(ParameterError, lambda: self.swing(assembly, 12.0), *words)

    @pytest.mark.parametrize("e", [0.0, E, -E])
    @pytest.mark.parametrize("assembly", [1, -1])
    def test_the_shortest_rod_that_is_accepted_keeps_the_energy(self, e, assembly):
        crank = CrankSlider(r=R, L=(R + abs(e)) * (1 + 1.1e-8), e=e, m=100.0, assembly=assembly)
        system = lp.assemble(in_a_row(fly=Inertia(J=50.0, w=2.0, phi=0.3), crank=crank))
        run = lp.simulate(system, until=12.0)
        assert run["fly.phi"][-1] > 4 * np.pi
        energy = 25 * run["fly.w"] ** 2 + 50 * run["crank.v"] ** 2
        assert np.ptp(energy) < 1e-4 * energy[0]

    def test_prescribed_speed_through_the_lock_is_refused(self):
        system = turning([CrankSlider(r=R, L=0.9, e=E, phase=np.pi, assembly=0)])
        with pytest.raises(SolverError, match="linkage"):
            lp.simulate(system, until=2.0, start={"parts[0].psi": np.pi})


class TestRotatingMass:
    def test_force_is_centrifugal_and_torque_its_weight(self):
        w, m, r, g = 4.0, 3.0, 0.5, 9.81
        run = revolve([RotatingMass(m=m, r=r, phase=0.3, g=g)], w, **grounded())
        angle = np.radians(DEGREES) + 0.3
        assert worst(run["ground_x.flange.f"], m * r * w**2 * np.cos(angle)) < 1e-13
        assert worst(run["ground_y.flange.f"], m * r * w**2 * np.sin(angle) - m * g) < 1e-13
        assert worst(-run["turn.flange.tau"], m * g * r * np.cos(angle)) < 1e-13

    def test_it_hangs_as_a_pendulum(self):
        model = in_a_row(
            mass=RotatingMass(m=3.0, r=0.5, J=0.2, phase=-np.pi / 2, g=9.81), shaft=Inertia(J=0.1)
        )
        received = lp.modes(lp.assemble(model)).hertz[0]
        assert abs(received * 2 * np.pi / np.sqrt(3 * 9.81 * 0.5 / (0.75 + 0.3)) - 1) < 1e-12


def test_peaks_under_a_stroke_load_have_derivatives_by_all_parameters():
    """Outside of the stroke the load is zero to a power that is a parameter."""
    system = assemble_rows(
        *("wheel shaft disc crank", "crank.slider stone.flange"),
        wheel=Inertia(J=5.0, w=12.0),
        shaft=SpringDamper(c=2e4, d=5.0),
        disc=Inertia(J=1.0),
        crank=CrankSlider(r=0.05, L=0.4, m=10.0),
        stone=StrokeLoad(forward=3e3, backward=10.0, s_0=0.36, s_1=0.45, p=1.0, q=1.5),
    )
    to = ["wheel.J", "stone.forward", "stone.p"]
    of = lp.functionals.final("shaft.tau")
    found = lp.gradient(system, of=[of], by=to, until=0.4, rtol=1e-11)
    for name in to:
        value = system.parameters[name]
        ends = [
            lp.simulate(system, until=0.4, rtol=1e-11, grid=1, parameters={name: value * (1 + h)})[
                "shaft.tau"
            ][-1]
            for h in (1e-4, -1e-4)
        ]
        difference = (ends[0] - ends[1]) / (2e-4 * value)
        assert found["final(shaft.tau)", name] == pytest.approx(difference, rel=1e-4)
