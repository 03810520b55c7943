"""Frequency responses against closed forms and impedance matrices written here."""

import numpy as np
import pytest
from differences import slope
from drive_chains import Geared
from rows import assemble_row, in_a_row

import lumped as lp
from lumped.components import (
    Fixed,
    IdealGear,
    Inertia,
    Position,
    Speed,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.errors import OptionError, SolverError, UnknownNameError

RIG = in_a_row(
    motor=Torque(tau=0.0),
    a=Inertia(J=2.0),
    shaft=SpringDamper(c=300.0, d=1.5),
    b=Inertia(J=1.0),
)
"""A motor drives a load through a shaft."""


def stiffness(w):
    return 300.0 + 1.5j * w


def torsion(w):
    return -0.5 / (-(w**2) + stiffness(w) * 1.5)


def test_two_inertias_answer_as_the_closed_form_says():
    hertz = np.linspace(0.1, 20.0, 173)
    received = lp.frequency_response(
        lp.assemble(RIG), inputs=["motor.tau"], outputs=["shaft.tau", "b.w"], hertz=hertz
    )
    w = 2 * np.pi * hertz
    torque = stiffness(w) * torsion(w)
    assert received["shaft.tau", "motor.tau"] == pytest.approx(torque, rel=1e-11)
    assert received["b.w", "motor.tau"] == pytest.approx(-torque / (1j * w), rel=1e-11)
    assert received.magnitude("shaft.tau", "motor.tau") == pytest.approx(np.abs(torque), rel=1e-11)
    # static: the load takes its share J_b / (J_a + J_b) of the torque
    received_factor = received.amplification("shaft.tau", "motor.tau")
    assert received_factor == pytest.approx(np.abs(torque) * 3.0, rel=1e-6)


def test_a_reference_names_an_input_and_an_output():
    received = lp.frequency_response(
        lp.assemble(RIG), inputs=[RIG.motor.tau], outputs=[RIG.shaft.phi_rel], hertz=[3.0]
    )
    expected = torsion(2 * np.pi * 3.0)
    assert received[RIG.shaft.phi_rel, RIG.motor.tau] == pytest.approx([expected], rel=1e-12)


@pytest.mark.parametrize("zeta", [1e-4, 0.01, 0.3])
def test_the_peak_of_a_damped_oscillator_has_its_closed_form(zeta):
    w0 = np.sqrt(800.0 / 2.0)
    model = in_a_row(
        drive=Torque(tau=0.0),
        body=Inertia(J=2.0),
        shaft=SpringDamper(c=800.0, d=2 * zeta * w0 * 2.0),
        wall=Fixed(),
    )
    received = lp.frequency_response(
        lp.assemble(model),
        inputs=["drive.tau"],
        outputs=["shaft.phi_rel"],
        hertz=np.linspace(0.0, 8.0, 161),
    )
    (peak,) = received.peaks("shaft.phi_rel", "drive.tau")
    assert peak.hertz == pytest.approx(w0 * np.sqrt(1 - 2 * zeta**2) / (2 * np.pi), rel=1e-7)
    expected = 1 / 800.0 / (2 * zeta * np.sqrt(1 - zeta**2))
    assert peak.magnitude == pytest.approx(expected, rel=1e-7)
    # static twist at 0 Hz; far above the resonance the body is turned against its torque
    assert received["shaft.phi_rel", "drive.tau"][0] == pytest.approx(-1 / 800.0, rel=1e-12)
    phase = received.phase("shaft.phi_rel", "drive.tau")
    w = 2 * np.pi * 8.0
    lag = np.arctan2(2 * zeta * w0 * w, w0**2 - w**2)
    assert phase[0] - phase[-1] == pytest.approx(lag, rel=1e-9)


def test_a_long_geared_drive_answers_as_its_impedance_matrix():
    drive = Geared.random(60, seed=11)
    places = {"first": 0, "second": 30}
    model = drive.model({name: (Torque(tau=0.0), "body", i) for name, i in places.items()})
    hertz = np.linspace(0.5, 60.0, 40)
    outputs = ["body[59].w", "shaft[17].tau", "body[4].w"]
    received = lp.frequency_response(
        lp.assemble(model), inputs=["first.tau", "second.tau"], outputs=outputs, hertz=hertz
    )
    M, D, K = drive.matrices()
    for k, f in enumerate(hertz):
        s = 2j * np.pi * f
        angles = np.linalg.solve(s**2 * M + s * D + K, np.eye(60)[:, [0, 30]])
        torque = (drive.c[17] + s * drive.d[17]) * (drive.twist[17] @ angles)
        expected = np.array([s * angles[59], torque, s * angles[4]])
        assert received.values[k] == pytest.approx(expected, rel=1e-8, abs=0)


def test_a_stiffness_that_varies_is_an_input_too():
    """At a static twist of 3 N.m / c a change of c acts as a torque."""
    system = assemble_row(
        drive=Torque(tau=3.0), body=Inertia(J=2.0), shaft=Spring(c=800.0), wall=Fixed()
    )
    received = lp.frequency_response(
        system, inputs=["shaft.c"], outputs=["body.w"], hertz=[1.0, 2.0], at=lp.equilibrium(system)
    )
    s = 2j * np.pi * np.array([1.0, 2.0])
    expected = -s * (3.0 / 800.0) / (2.0 * s**2 + 800.0)
    assert received["body.w", "shaft.c"] == pytest.approx(expected, rel=1e-11)


def test_a_drive_without_states_answers_at_once():
    model = in_a_row(drive=Torque(tau=0.0), gear=IdealGear(ratio=4.0), wall=Fixed())
    received = lp.frequency_response(
        lp.assemble(model), inputs=["drive.tau"], outputs=["wall.flange.tau"], hertz=[1.0, 9.0]
    )
    # the torque on the wall, and the wall as part of the drive train
    assert received["wall.flange.tau", "drive.tau"] == pytest.approx([4.0, 4.0], rel=1e-14)


class Shaker(lp.Component):
    """Motion by its acceleration."""

    flange = lp.Flange()
    a = lp.Input("rad/s2", "acceleration")
    phi: lp.Var = lp.var("rad", "angle")
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self):
        yield self.flange.phi == self.phi
        yield lp.der(self.phi) == self.w
        yield lp.der(self.w) == self.a


def driven_by(base):
    return assemble_row(base=base, shaft=SpringDamper(c=800.0, d=3.0), body=Inertia(J=2.0))


def test_a_prescribed_angle_is_refused_and_its_acceleration_answers():
    with pytest.raises(OptionError, match=r"response to base\.phi would need its rate of change"):
        lp.frequency_response(
            driven_by(Position(phi=0.0)), inputs=["base.phi"], outputs=["body.w"], hertz=[1.0]
        )
    received = lp.frequency_response(
        driven_by(Shaker(a=0.0)), inputs=["base.a"], outputs=["body.w"], hertz=[1.0]
    )
    s = 2j * np.pi
    expected = (800.0 + 3.0 * s) / (2.0 * s**2 + 3.0 * s + 800.0) / s
    assert received["body.w", "base.a"] == pytest.approx([expected], rel=1e-12)


def test_a_prescribed_speed_varies_only_where_its_acceleration_does_not_matter():
    def driven(*parts):
        named = {f"part{i}": part for i, part in enumerate(parts)}
        return assemble_row(base=Speed(w=10.0), **named)

    asked = {"inputs": ["base.w"], "outputs": ["part1.w"], "hertz": [1.0]}
    received = lp.frequency_response(driven(SpringDamper(c=800.0, d=3.0), Inertia(J=2.0)), **asked)
    s = 2j * np.pi
    expected = (800.0 + 3.0 * s) / (2.0 * s**2 + 3.0 * s + 800.0)
    assert received["part1.w", "base.w"] == pytest.approx([expected], rel=1e-12)
    with pytest.raises(OptionError, match=r"base\.w would need its rate"):
        lp.frequency_response(
            driven(Inertia(J=1.0), Spring(c=1.0), Inertia(J=2.0)),
            inputs=["base.w"],
            outputs=["base.flange.tau"],
            hertz=[1.0],
        )


def test_what_drifts_freely_has_no_static_response():
    system = lp.assemble(RIG)
    asked = {"inputs": ["motor.tau"], "outputs": ["a.w"]}
    with pytest.raises(SolverError, match="no finite response at 0 Hz: what moves freely"):
        lp.frequency_response(system, **asked, hertz=[0.0, 1.0])
    free = lp.frequency_response(system, **asked, hertz=[1.0, 2.0])
    with pytest.raises(OptionError, match=r"a\.w has no static response to motor\.tau"):
        free.amplification("a.w", "motor.tau")


@pytest.mark.parametrize("hertz", [[], [2.0, 1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, np.nan]])
def test_frequencies_must_ascend(hertz):
    with pytest.raises(OptionError, match=r"ascending and not negative|finite numbers"):
        lp.frequency_response(lp.assemble(RIG), inputs=["motor.tau"], outputs=["b.w"], hertz=hertz)


def test_unknown_names_are_answered_with_the_nearest():
    system = lp.assemble(RIG)
    with pytest.raises(UnknownNameError, match=r"'a\.w' is not a parameter.*"):
        lp.frequency_response(system, inputs=["a.w"], outputs=["b.w"], hertz=[1.0])
    received = lp.frequency_response(system, inputs=["motor.tau"], outputs=["b.w"], hertz=[1.0])
    with pytest.raises(UnknownNameError, match=r"'a\.w' is no output of this response"):
        received.magnitude("a.w", "motor.tau")
    with pytest.raises(OptionError, match="at least one input"):
        lp.frequency_response(system, inputs=[], outputs=["b.w"], hertz=[1.0])


def test_the_picture_shows_magnitude_and_phase():
    received = lp.frequency_response(
        lp.assemble(RIG), inputs=["motor.tau"], outputs=["shaft.tau"], hertz=np.linspace(1, 9, 50)
    )
    size, angle = received.plot().axes
    assert (size.get_title(), size.get_ylabel()) == ("shaft.tau", "magnitude")
    expected = np.abs(stiffness(2 * np.pi * received.hertz) * torsion(2 * np.pi * received.hertz))
    assert size.lines[0].get_ydata() == pytest.approx(expected, rel=1e-11)
    assert size.get_yscale() == "log"
    assert angle.get_xlabel() == "frequency, Hz"
    assert "shaft.tau / motor.tau" in repr(received)


def test_a_response_has_the_derivatives_of_its_closed_form():
    hertz = np.array([0.5, 2.0, 4.5, 20.0])
    response = lp.frequency_response(
        lp.assemble(RIG), inputs=["motor.tau"], outputs=["b.w", "a.w"], hertz=hertz
    )
    to = ["a.J", "b.J", "shaft.c", "shaft.d"]
    found = lp.vibration.response_sensitivity(response, by=to)
    s = 2j * np.pi * hertz

    def closed(J_a, J_b, c, d):
        """Speeds of b and a for each N.m on a."""
        k = d + c / s
        under = (J_a * s + k) * (J_b * s + k) - k**2
        return np.array([k / under, (J_b * s + k) / under])

    # complex amplitudes leave no room for a complex step: differences of sixth order
    point = np.array([2.0, 1.0, 300.0, 1.5])
    for i, name in enumerate(to):
        step = 3e-3 * point[i] * np.eye(4)[i]
        expected = slope(lambda share, step=step: closed(*(point + share * step)), 0.0, 1.0)
        expected = expected / (3e-3 * point[i])
        assert found["b.w", "motor.tau", name] == pytest.approx(expected[0], rel=1e-8)
        assert found["a.w", "motor.tau", name] == pytest.approx(expected[1], rel=1e-8)
        size = np.abs(closed(*point)[0])
        along = (closed(*point)[0].conj() * expected[0]).real / size
        assert found.magnitude("b.w", "motor.tau", name) == pytest.approx(along, rel=1e-7)
    with pytest.raises(UnknownNameError):
        found["b.w", "motor.tau", "motor.tau"]
    with pytest.raises(OptionError):
        lp.vibration.response_sensitivity(response, by=[])
