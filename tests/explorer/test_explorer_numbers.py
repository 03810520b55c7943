"""What the page shows, as numbers: compared with closed forms."""

from typing import Any

import numpy as np
import pytest
from drive_chains import in_turn
from rows import assemble_row

import lumped as lp
from lumped.components import Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptionError
from lumped.explorer.sliders import Slider, slider
from lumped.explorer.study import Moment, Study, effects_on_run, most_effective
from lumped.explorer.views import Shown, views
from lumped.models import MACHINES, machine
from lumped.models.reversing_mill.scenes import SKIDS
from lumped.models.turbine_generator.scenes import FREE
from lumped.vibration import Limit

J_A, J_B, C = 2.0, 1.0, 300.0  # of `two_mass`
TORQUE, J = 3.0, 2.0  # of `driven_mass`
D = 4.0


def study(model: lp.Component | lp.System, **options: Any) -> Study:
    return Study(model if isinstance(model, lp.System) else lp.assemble(model), **options)


def seen(what: Study, title: str, values: dict[str, float], *names: str) -> Shown:
    (view,) = (view for view in views(what) if view.title.startswith(title))
    theta = what.system.theta(values)
    return view.compute(Moment(what, values), [slider(what.system, theta, n) for n in names])


# -- pictures ------------------------------------------------------------------------------------


@pytest.mark.parametrize("stiffness", [300.0, 1200.0])
def test_modes_are_those_of_two_masses(two_mass, stiffness):
    found = seen(study(two_mass), "Natural", {"shaft.c": stiffness})
    expected = np.sqrt(stiffness * (1 / J_A + 1 / J_B)) / (2 * np.pi)
    assert found["hertz"]["hertz"] == pytest.approx([expected], rel=1e-12)
    assert found["parts"]["name"] == ["a.phi", "b.phi"]
    assert found["shapes"]["y"][0] == pytest.approx([J_B / J_A, -1.0], rel=1e-12)


def test_sensitivities_are_those_of_the_formula(two_mass):
    """``f`` grows with ``sqrt(c (1/J_a + 1/J_b))``."""
    found = seen(study(two_mass), "Sensitivities", {}, "a.J", "b.J", "shaft.c")["effects"]
    assert found.pop("name") == ["a.J", "b.J", "shaft.c"]
    expected = [-0.5 * J_B / (J_A + J_B), -0.5 * J_A / (J_A + J_B), 0.5]
    assert found == {"frequency 1": pytest.approx(expected, rel=1e-9)}


def test_without_modes_sensitivities_are_those_of_the_run(driven_mass):
    """The speed is ``tau t / J``: with J one per cent larger it falls by 1/1.01."""
    what = study(driven_mass, until=2.0, of=("body.w",))
    expected = {"drive.tau": 1.0, "body.J": (1 - 1 / 1.01) / 0.01}
    assert effects_on_run(Moment(what, {}), expected) == pytest.approx(expected, rel=1e-6)
    found = seen(what, "Sensitivities", {}, *expected)["effects"]
    assert dict(zip(found["name"], found["run"], strict=True)) == pytest.approx(expected)
    with pytest.raises(OptionError, match="no oscillating mode"):
        seen(what, "Natural", {})


def test_run_follows_the_closed_form(two_mass):
    """A twist that is let go: ``twist cos(w t)``."""
    what = study(two_mass, until=0.5, of=("shaft.tau",), start={"shaft.phi_rel": 0.01})
    found = seen(what, "Run", {"b.J": 4.0})["curves"]
    w = np.sqrt(C * (1 / J_A + 1 / 4.0))
    expected = 0.01 * C * np.cos(w * np.array(found["t"]))
    assert np.abs(np.array(found["shaft.tau"]) - expected).max() <= 1e-5 * 0.01 * C


def test_start_values_may_follow_the_parameters(two_mass):
    what = study(
        two_mass,
        until=0.1,
        of=("shaft.tau",),
        start=lambda values: {"shaft.phi_rel": 6.0 / values["shaft.c"]},
    )
    for stiffness in (150.0, 600.0):
        found = seen(what, "Run", {"shaft.c": stiffness})["curves"]
        assert found["shaft.tau"][0] == pytest.approx(6.0, rel=1e-12)


def test_limits_are_compared_with_the_run(driven_mass):
    what = study(driven_mass, until=2.0, of=("body.w",), limits=(Limit("body.w", 4.0, name="top"),))
    found = seen(what, "Limits", {"body.J": 1.0})["limits"]
    assert found["used"] == pytest.approx([TORQUE * 2.0 / 1.0 / 4.0], rel=1e-9)
    assert found["permitted"] == ["4 rad/s"]


def test_response_is_that_of_a_damped_rotor():
    excited = assemble_row(
        drive=Torque(tau=0.0), rotor=Inertia(J=J), shaft=SpringDamper(c=C, d=D), wall=Fixed()
    )
    what = study(excited, of=("rotor.phi",), inputs=("drive.tau",))
    found = seen(what, "Response", {"rotor.J": 3.0})["curves"]
    w = 2 * np.pi * np.array(found["x"][0])
    expected = 1 / np.abs(C - 3.0 * w**2 + 1j * D * w)
    assert found["y"][0] == pytest.approx(expected.tolist(), rel=1e-9)
    assert w[0] < np.sqrt(C / 3.0) < w[-1]


def test_campbell_diagrams_and_order_responses_are_drawn(two_mass):
    system = lp.assemble(two_mass)

    def campbell(values: dict[str, float]) -> lp.vibration.Campbell:
        point = lp.start_point(system, parameters=values)
        return lp.campbell(system, speeds=[0.0, 20.0], orders=[2.0], at=point)

    found = seen(study(system, analyses={"Campbell": campbell}), "Campbell", {"shaft.c": 100.0})
    hertz = np.sqrt(100.0 * (1 / J_A + 1 / J_B)) / (2 * np.pi)
    assert found["critical"]["y"] == pytest.approx([hertz], rel=1e-9)
    assert found["critical"]["x"] == pytest.approx([60 * hertz / 2], rel=1e-9)
    assert found["rays"]["label"] == ["2"]
    wrong = study(system, analyses={"Wrong": lambda values: 3.0})
    with pytest.raises(OptionError, match=r"'Wrong'\] gave a float"):
        seen(wrong, "Wrong", {})


def test_schematic_tells_the_values_of_parts(two_mass):
    found = seen(study(two_mass), "Schematic", {"shaft.c": 1234.0})["texts"]
    assert found == {"a": "2 kg.m2", "shaft": "1230 N.m/rad", "b": "1 kg.m2"}


def test_events_of_the_mill_are_told_at_their_instants():
    """The instants are those of modal sums between the events (`SKIDS`)."""
    mill = machine("reversing_mill")
    run = mill.scene(0.4, grid=1)
    what = study(
        run.system,
        until=0.4,
        of=("gap.w_rel",),
        start=lambda values: mill.begin(run.system, values),
    )
    found = seen(what, "Run", {})
    told = [text for text in found["told"]["text"] if " gap: " in text]
    received = [float(text.partition(" ms")[0]) for text in told]
    assert received == pytest.approx([1e3 * t for t in SKIDS], abs=0.02)


def test_a_moved_load_begins_steadily():
    """Steam drives what the grid takes, and what the resistance of the stator loses, by phasors.

    Before the fault all torques stay what they are, so those of the shafts are shares of the steam.
    """
    chosen = machine("turbine_generator")
    system = lp.assemble(chosen.model())
    model = system.parameters
    P, Q, V = 0.6 * model["gen.P_0"], 1.5 * model["gen.Q_0"], 1.03 * model["gen.V_0"]
    shafts = {"turbine.hp_ip.tau": 0.30, "turbine.ip_lpa.tau": 0.56, "turbine.lpa_lpb.tau": 0.78}
    what = study(
        system, until=0.019, of=("gen.tau", *shafts), start=lambda v: chosen.begin(system, v)
    )
    moved = {"gen.P_0": P, "gen.Q_0": Q, "gen.V_0": V, "gen.v_f": model["gen.v_f"]}
    moment = Moment(what, moved)
    current = np.hypot(P, Q) / (1.5 * V)  # amplitudes of a phase
    w = 2 * np.pi * model["bus.f"] / model["gen.pairs"]
    steam = (-P + 1.5 * model["gen.R_s"] * current**2) / w
    found = seen(what, "Run", moved)["curves"]
    for name, share in ({"gen.tau": 1.0} | shafts).items():
        assert np.abs(found[name]) == pytest.approx(share * steam, rel=1e-6), name
    assert moment.follows.keys() == set(FREE)
    assert moment.parameters["turbine.steam"] == pytest.approx(steam, rel=1e-9)


def test_sliders_do_not_move_what_follows_from_the_start(two_mass):
    """The torsion at the start determines the stiffness that keeps a given torque."""

    class Twisted(type(two_mass)):
        """The shaft carries 6 N.m at the start."""

        def initial_equations(self):
            yield self.shaft.tau == 6.0

    system = lp.assemble(Twisted())

    def start(values: dict[str, float]) -> lp.OperatingPoint:
        first = {"shaft.phi_rel": 0.01}
        return lp.start_point(system, start=first, parameters=values, free=["shaft.c"])

    what = study(system, start=start, until=0.1, of=("shaft.tau",))
    assert names(most_effective(what)) == {"a.J", "b.J"}
    moment = Moment(what, {"a.J": 3.0, "shaft.c": 100.0})
    assert moment.follows == pytest.approx({"shaft.c": 600.0})
    assert moment.modes.hertz == pytest.approx([np.sqrt(600.0 * (1 / 3.0 + 1 / J_B)) / (2 * np.pi)])
    refused = Moment(study(system, start=lambda _: lp.start_point(lp.assemble(two_mass))), {})
    with pytest.raises(OptionError, match="not of the system that is explored"):
        seen(refused.study, "Natural", {})


CHANGED = {"reversing_mill": "upper.shaft.c", "rotary_arm": "arm.g", "marine_turbine": "shaft.c"}


@pytest.mark.parametrize("name", MACHINES)
def test_machines_begin_as_their_scenes(name):
    """With a changed parameter, where start values follow from parameters."""
    chosen, short = machine(name), 0.05
    first = chosen.scene(short, grid=1)
    system, model = first.system, first.system.parameters
    values = dict(zip(model, first.theta.tolist(), strict=True))
    values |= {key: 1.1 * values[key] for key in [CHANGED.get(name)] if key}
    given = {key: value for key, value in values.items() if key not in FREE}
    scene = chosen.scene(short, parameters=given, grid=400)
    what = study(system, until=short, start=lambda values: chosen.begin(system, values))
    received = Moment(what, values).run
    for state in system.state_names:
        assert received[state] == pytest.approx(scene[state], rel=1e-9, abs=1e-12), state


# -- which parameters ----------------------------------------------------------------------------


def names(found: tuple[Slider, ...]) -> set[str]:
    return {each.name for each in found}


def test_sliders_are_those_with_most_effect(two_mass, driven_mass):
    assert names(most_effective(study(two_mass))) == {"a.J", "b.J", "shaft.c"}
    run = study(driven_mass, until=1.0, of=("body.w",))
    assert names(most_effective(run)) == {"drive.tau", "body.J"}


def test_no_more_than_ten_sliders_at_first():
    bodies = [Inertia(J=100.0), *(Inertia(J=1.0) for _ in range(11))]
    shafts = [SpringDamper(c=50.0, d=0.0) for _ in range(11)]
    found = most_effective(study(in_turn(bodies=bodies, springs=shafts)))
    assert len(found) == 10
    assert all(each.default for each in found)
