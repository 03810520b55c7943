"""Winding against closed forms, momentum and energy balances, and plane geometry."""

import numpy as np
import pytest
from rows import assemble_row, assemble_rows, in_rows
from scipy.optimize import brentq

import lumped as lp
from lumped.components import Coil, Inertia, Position, Speed, Strip, StripPath, Torque, translation
from lumped.ops import pi, sqrt

r, h, b, rho = 0.3, 2e-3, 1.2, 7850.0
COIL = Coil(r=r, R_max=1.0, h=h, b=b, rho=rho)


def wound(coil=COIL, f=-5e4, drive=None):
    """A coil on a mandrel that is driven, strip under a force."""
    return in_rows(
        *("drive mandrel coil", "coil.strip pull.flange"),
        mandrel=Inertia(J=400.0),
        coil=coil,
        pull=translation.Force(f=f),
        drive=Torque(tau=0.0) if drive is None else drive,
    )


class TestCoil:
    @pytest.mark.parametrize("fill", [1.0, 0.95])
    def test_radius_follows_the_wound_length(self, fill):
        coil = COIL.with_({"fill": fill})
        run = lp.simulate(lp.assemble(wound(coil, drive=Speed(w=20.0))), until=60.0, grid=50)
        assert run["coil.R"] ** 2 == pytest.approx(r**2 + h / fill * run["coil.L"] / pi, rel=1e-13)
        layers = 20.0 * run.t / (2 * pi)
        assert run["coil.R"] == pytest.approx(r + layers * h / fill, rel=1e-9)
        volume = pi * (run["coil.R"] ** 2 - r**2) * b * fill
        assert run["coil.m"] == pytest.approx(rho * volume, rel=1e-10, abs=1e-9)
        J = pi * rho * b * fill / 2 * (run["coil.R"] ** 4 - r**4)
        assert run["coil.J"] == pytest.approx(J, rel=1e-10, abs=1e-9)

    def test_strip_that_comes_with_the_speed_of_the_coil_does_not_brake_it(self):
        system = lp.assemble(wound(f=0.0))
        run = lp.simulate(system, until=30.0, start={"mandrel.w": 40.0}, rtol=1e-11)
        assert run["mandrel.w"] == pytest.approx(40.0, rel=1e-13)
        assert run["coil.J"][-1] > 5 * 400.0

    def test_prescribed_steady_speed_gives_the_closed_form_of_the_inertia_torque(self):
        v = 15.0
        R = sqrt(r**2 + h * v * lp.time / pi)
        turn = Position(phi=2 * v * lp.time / (r + R))
        run = lp.simulate(lp.assemble(wound(f=0.0, drive=turn)), until=40.0, grid=100, rtol=1e-12)
        J0 = 400.0 - pi * rho * b * r**4 / 2
        radius = np.sqrt(r**2 + h * v * run.t / np.pi)
        # M / R = J w' / R = -(A / R^4 + B), w' = -h v^2 / (2 pi R^3)
        expected = -(J0 * h * v**2 / (2 * np.pi) / radius**4 + rho * b * h * v**2 / 4)
        assert -run["drive.flange.tau"] / radius == pytest.approx(expected, rel=1e-9)

    def test_strip_without_thickness_neither_grows_nor_bends(self):
        coil = COIL.with_({"h": 0.0, "sigma_s": 3e8})
        run = lp.simulate(lp.assemble(wound(coil, drive=Torque(tau=2e4))), until=5.0, rtol=1e-11)
        assert np.all(run["coil.R"] == r)
        assert np.all(run["coil.M_b"] == 0)
        rate = (2e4 - 5e4 * r) / 400.0
        assert run["mandrel.w"] == pytest.approx(rate * run.t, rel=1e-9, abs=1e-12)

    def test_bending_holds_a_coil_still_up_to_its_torque(self):
        coil = COIL.with_({"sigma_s": 3e8})
        limit = 3e8 * b * h**2 / 4
        for share, moves in ((0.99, False), (-0.99, False), (1.01, True)):
            tau = 5e4 * r + share * limit
            run = lp.simulate(
                lp.assemble(wound(coil, drive=Torque(tau=tau))), until=1.0, rtol=1e-11
            )
            assert bool(run["coil.w"][-1] != 0) is moves
            expected = limit if moves else share * limit
            assert run["coil.M_b"][-1] == pytest.approx(expected, rel=1e-9)

    def test_growing_beyond_the_full_radius_is_an_event_at_its_instant(self):
        coil = COIL.with_({"R_max": 0.35})
        run = lp.simulate(lp.assemble(wound(coil, drive=Speed(w=30.0))), until=8.0)
        full = 2 * np.pi * (0.35 - r) / h / 30.0
        assert [(e.time, e.component) for e in run.events] == [(pytest.approx(full), "coil")]
        assert run["coil.state"][-1] == 1

    def test_pulling_the_strip_off_the_bare_mandrel_is_an_event(self):
        coil = Coil(r=r, R_max=1.0, h=h, b=b, rho=rho, L=pi * (0.32**2 - r**2) / h)
        run = lp.simulate(lp.assemble(wound(coil, drive=Speed(w=-30.0))), until=3.0)
        assert run["coil.R"][0] == pytest.approx(0.32, rel=1e-12)
        bare = 2 * np.pi * 0.02 / h / 30.0
        assert [(e.time, e.component) for e in run.events] == [(pytest.approx(bare), "coil")]
        assert run["coil.state"][-1] == -1


class TestStrip:
    def system(self, **given):
        strip, body = Strip(c=4e5, **given), translation.Mass(m=100.0)
        return assemble_row(line=translation.Speed(v=0.0), strip=strip, body=body)

    def test_it_swings_with_the_frequency_of_mass_and_spring(self):
        run = lp.simulate(self.system(), until=0.02, start={"strip.s_rel": 0.01}, rtol=1e-11)
        expected = 0.01 * np.cos(np.sqrt(4e5 / 100.0) * run.t)
        assert run["strip.s_rel"] == pytest.approx(expected, abs=1e-11)

    def test_it_loses_its_tension_and_never_pushes(self):
        run = lp.simulate(self.system(d=500.0), until=0.2, start={"strip.s_rel": 0.01}, rtol=1e-10)
        released, lost = (e.time for e in run.events if e.component == "strip")
        delta = 500.0 / 200.0
        w = np.sqrt(4e5 / 100.0 - delta**2)

        # the damper is as strong as the spring from c s = -d v on, and nothing slows the body then
        def force(t):
            s = np.cos(w * t) + delta / w * np.sin(w * t)
            return 4e5 * s - 500.0 * 4e3 / w * np.sin(w * t)

        assert released == pytest.approx(brentq(force, 0.02, 0.0248, xtol=1e-15), rel=1e-8)
        assert lost - released == pytest.approx(500.0 / 4e5, rel=1e-8)
        assert run["strip.T"].min() > -1e-12  # of 4 kN
        assert run["strip.T"][run.t > released].max() < 1e-9

    def test_a_line_at_even_speed_is_stretched_by_what_the_growing_coil_winds_beyond_it(self):
        """``T = c h (w t)^2 / (4 pi)``, and the mandrel bears ``R T``."""
        w, c = 20.0, 4e5
        system = assemble_rows(
            *("line strip", "strip.flange_b coil.strip", "coil mandrel"),
            line=translation.Speed(v=w * r),
            strip=Strip(c=c),
            coil=COIL,
            mandrel=Speed(w=w),
        )
        run = lp.simulate(system, until=3.0, rtol=1e-11)
        angle = w * run.t
        expected = c * h * angle**2 / (4 * np.pi)
        assert run["strip.T"] == pytest.approx(expected, rel=1e-8, abs=1e-2)
        bearing = (r + h * angle / (2 * np.pi)) * expected
        assert -run["mandrel.flange.tau"] == pytest.approx(bearing, rel=1e-8, abs=1e-2)
        assert run["coil.T"] == pytest.approx(run["strip.T"], rel=1e-12)


JOINED = (
    *("turret.flange path.carrier", "mandrel coil", "coil.strip path.strip"),
    *("coil.tangent path.tangent", "coil.R path.R", "path.line pull.flange"),
)
"""A coil on a turret, its drives and the pull on its strip."""


class TestStripPath:
    R, r_t, d = 0.45, 1.25, 4.4

    def parts(self):
        """A coil on a turret that is turned, the strip at the roll pulled by a force."""
        return {
            "turret": Speed(w=0.5),
            "coil": Coil(r=self.R, R_max=2.0, h=h, b=b, rho=0.0),
            "path": StripPath(r_t=self.r_t, d=self.d),
            "mandrel": Speed(w=8.0),
            "pull": translation.Force(f=-8e4),
        }

    def geometry(self, run):
        """Axis of the coil, point of contact and direction of the strip, the roll being at zero."""
        alpha, R = run["path.alpha"], run["coil.R"]
        axis = np.array([self.d + self.r_t * np.cos(alpha), self.r_t * np.sin(alpha)])
        psi = run["path.psi"]
        along = np.array([np.cos(psi), np.sin(psi)])
        contact = axis + R * np.array([np.sin(psi), -np.cos(psi)])
        return axis, contact, along

    def test_the_strip_runs_from_the_roll_to_where_it_touches_the_coil(self):
        system = assemble_rows(*JOINED, keep=["path.alpha"], **self.parts())
        run = lp.simulate(system, until=12.0, grid=40)
        _, contact, along = self.geometry(run)
        assert contact == pytest.approx(run["path.length"] * along, rel=1e-12, abs=1e-12)

    @pytest.mark.parametrize("order", [1, -1])
    def test_angles_of_coil_and_turret_lead_in_any_order_of_the_parts(self, order):
        system = assemble_rows(*JOINED, **dict(list(self.parts().items())[::order]))
        assert set(system.state_names) == {"coil.theta", "path.alpha"}

    def test_the_material_at_the_roll_moves_as_that_on_the_coil(self):
        system = assemble_rows(*JOINED, keep=["path.alpha", "path.line.s"], **self.parts())
        at = np.linspace(0.0, 12.0, 4001)
        run = lp.simulate(system, until=12.0, grid=at, rtol=1e-12)
        axis, contact, along = self.geometry(run)
        v_axis = 0.5 * self.r_t * np.array([-np.sin(0.5 * at), np.cos(0.5 * at)])
        arm = contact - axis
        v_contact = v_axis + 8.0 * np.array([-arm[1], arm[0]])
        expected = (v_contact * along).sum(axis=0)
        s = run["path.line.s"]
        received = (s[2:] - s[:-2]) / (at[2:] - at[:-2])
        assert received == pytest.approx(expected[1:-1], abs=1e-4)
