"""Modes of a drive under control are those of its equations."""

import numpy as np
from checks import worst

import lumped as lp
from lumped.components import (
    AngleSensor,
    CascadeControl,
    ElastoBacklash,
    Inertia,
    SpeedSensor,
    Torque,
)

J_M, J_L, C, D, K, GAIN, T_I = 0.05, 0.1, 2e4, 8.0, 40.0, 6.0, 0.2


class Axis(lp.Component):
    """Motor and load under position and speed control whose limits are far away."""

    control: CascadeControl = CascadeControl(
        wanted=0.0, K=K, v_max=1e3, k=GAIN, T_i=T_I, f_max=1e4, v_feed=0.0, f_feed=0.0
    )
    drive: Torque = Torque()
    motor: Inertia = Inertia(J=J_M)
    teeth: ElastoBacklash = ElastoBacklash(c=C, d=D, b=0.0)
    load: Inertia = Inertia(J=J_L)
    tacho: SpeedSensor = SpeedSensor()
    scale: AngleSensor = AngleSensor()

    def connections(self):
        yield from lp.chain(self.drive, self.motor, self.teeth, self.load)
        yield lp.connect(self.motor.flange_b, self.tacho.flange)
        yield lp.connect(self.load.flange_b, self.scale.flange)
        yield lp.connect(self.tacho.w, self.control.v_measured)
        yield lp.connect(self.scale.phi, self.control.measured)
        yield lp.connect(self.control.y, self.drive.tau)


def test_what_acts_only_while_no_limit_is_reached_counts_in_modes():
    modes = lp.modes(lp.assemble(Axis()))
    # phi and w of the load, phi and w of the motor, integral part; at rest no limit is reached
    matrix = np.array(
        [
            [0, 1, 0, 0, 0],
            [-C / J_L, -D / J_L, C / J_L, D / J_L, 0],
            [0, 0, 0, 1, 0],
            [(C - GAIN * K) / J_M, D / J_M, -C / J_M, -(D + GAIN) / J_M, GAIN / J_M],
            [-K / T_I, 0, 0, -1 / T_I, 0],
        ]
    )
    expected = np.sort(np.linalg.eigvals(matrix))
    received = np.sort(np.r_[modes.eigenvalues, modes.eigenvalues.conj(), modes.decays])
    assert len(received) == len(expected)
    assert worst(received, expected) < 1e-12
