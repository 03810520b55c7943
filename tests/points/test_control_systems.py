"""Linear systems given to python-control and SciPy keep their numbers and names."""

import control
import numpy as np
import pytest
from rows import assemble_row

import lumped as lp
from lumped.components import Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptionError

J, STIFFNESS, DAMPING = 2.0, 800.0, 3.0


@pytest.fixture(scope="module")
def system():
    return assemble_row(
        motor=Torque(tau=0.0),
        mass=[Inertia(J=J)],
        shaft=SpringDamper(c=STIFFNESS, d=DAMPING),
        wall=Fixed(),
    )


def exact(w):
    """Twisting of the shaft and speed of the mass for a torque of 1 N.m."""
    angle = 1 / (STIFFNESS - J * w**2 + 1j * DAMPING * w)
    return np.array([-(STIFFNESS + 1j * DAMPING * w) * angle, 1j * w * angle])


def test_control_and_scipy_have_the_response_of_the_oscillator_and_the_names(system):
    linear = lp.linearise(system, inputs=["motor.tau"], outputs=["shaft.tau", "mass[0].w"])
    there = linear.to_control()
    w = np.array([0.3, 7.0, 19.8, 90.0])
    assert there.isctime()
    for labels, names in (
        (there.input_labels, linear.inputs),
        (there.output_labels, ("shaft.tau", "mass[0].w")),
        (there.state_labels, tuple(system.state_names)),
    ):
        assert tuple(label.replace("/", ".") for label in labels) == names
    other = linear.to_scipy()
    solved = [other.C @ np.linalg.solve(1j * x * np.eye(2) - other.A, other.B) + other.D for x in w]
    for response in (there(1j * w, squeeze=False).transpose(2, 0, 1), np.array(solved)):
        assert response[:, :, 0] == pytest.approx(exact(w).T, rel=1e-10, abs=0)


def test_frequency_response_data_has_radians_and_names(system):
    hertz = np.array([0.5, 3.0, 12.0])
    found = lp.frequency_response(
        system, inputs=["motor.tau"], outputs=["shaft.tau", "mass[0].w"], hertz=hertz
    ).to_control()
    assert isinstance(found, control.FrequencyResponseData)
    assert found.omega == pytest.approx(2 * np.pi * hertz, rel=1e-14)
    assert found.output_labels == ["shaft/tau", "mass[0]/w"]
    assert found.frdata[:, 0, :] == pytest.approx(exact(2 * np.pi * hertz), rel=1e-10, abs=0)


def test_a_system_without_inputs_and_a_name_with_a_slash_are_refused(system):
    for take in (lp.linearise(system).to_control, lp.linearise(system).to_scipy):
        with pytest.raises(OptionError, match="inputs=, outputs="):
            take()
    slashed = lp.assemble(
        lp.compose(
            mass={"a/b": Inertia(J=1.0)},
            motor=Torque(tau=0.0),
            connections=lambda m: [lp.connect(m.motor.flange, m.mass["a/b"].flange_a)],
        )
    )
    linear = lp.linearise(slashed, inputs=["motor.tau"], outputs=['mass["a/b"].w'])
    with pytest.raises(OptionError, match="slash"):
        linear.to_control()
