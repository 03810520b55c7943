"""Motors, circuits and their control."""

from lumped.components import (
    CascadeControl,
    DCMotor,
    Ground,
    InductionMotor,
    Inertia,
    Latch,
    LimitedPI,
    PositionSequencer,
    QuasiStaticDCMotor,
    Resistor,
    SampledPI,
    SlipCoupling,
    SpeedProfile,
    SquirrelCageMotor,
    SynchronousMotor,
    VoltageSource,
)
from lumped.errors import ConnectError, EquationError, ParameterError, SingularModelError
from tests.helpers.rows import assemble_row, assemble_rows

from . import Table
from .parts import build

drives = Table("Electric drives")


CAGE = {"R_s": 0.4, "R_r": 0.8, "L_m": 0.07, "L_lr": 2e-3, "J": 0.1, "V": 180.0}


def fed(motor):
    """Assemble a motor on a battery."""
    return assemble_rows(
        "battery.p motor.p",
        "battery.n motor.n ground.pin",
        battery=VoltageSource(v=48.0),
        motor=motor,
        ground=Ground(),
    )


@drives(ParameterError, "motor.L = 0 H", "QuasiStaticDCMotor", "greater than 0")
def motor_without_inductance():
    """A motor is given no inductance."""
    fed(DCMotor(k=0.5, R=0.2, L=0.0, J=0.01))


@drives(ParameterError, "motor.R = 0 Ohm", "greater than 0")
def motor_without_inductance_and_resistance():
    """A motor has neither inductance nor resistance, so that nothing limits its current."""
    fed(QuasiStaticDCMotor(k=0.5, R=0.0, J=0.01))


@drives(ParameterError, "motor.w_s = 0 rad/s", "motor.tau_k = -60 N.m", "motor.s_k = 1.2")
def induction_motor_out_of_range():
    """A torque curve of Kloss is given impossible values."""
    build(motor=InductionMotor(w_s=0.0, tau_k=-60.0, s_k=1.2, J=0.05))


@drives(SingularModelError, "bus.v = 48", "battery.v = 24", "at bus.p = battery.p", "resistor")
def two_sources_of_voltage_in_parallel():
    """Two ideal sources of voltage feed the same wires."""
    assemble_rows(
        "bus.p battery.p",
        "bus.n battery.n ground.pin",
        bus=VoltageSource(v=48.0),
        battery=VoltageSource(v=24.0),
        ground=Ground(),
    )


@drives(SingularModelError, "source.v = 48", "source.p = source.n", "Likely", "resistor")
def source_short_circuited():
    """Both pins of an ideal source of voltage are on the ground."""
    assemble_rows("source.p source.n ground.pin", source=VoltageSource(v=48.0), ground=Ground())


@drives(SingularModelError, "left.pin.v = 0", "right.pin.v = 0", "Remove one")
def grounded_twice():
    """Two grounds are on one wire."""
    assemble_rows(
        "source.p load.p",
        "source.n load.n left.pin right.pin",
        source=VoltageSource(v=48.0),
        load=Resistor(R=1.0),
        left=Ground(),
        right=Ground(),
    )


@drives(ParameterError, "pi.y_max = -12", "greater than pi.y_min = 12")
def limits_crossed():
    """The limits of a controller are in the wrong order."""
    build(pi=LimitedPI(k=2.0, T_i=0.1, y_min=12.0, y_max=-12.0, wanted=1.0, measured=0.0))


@drives(ParameterError, "safety.static = 30 N.m", "at least safety.kinetic = 50 N.m")
def limits_of_a_slip_coupling_exchanged():
    """A coupling holds less at rest than it carries while it slips."""
    assemble_row(
        motor=Inertia(J=1.0),
        safety=SlipCoupling(static=30.0, kinetic=50.0, u=1.0),
        load=Inertia(J=1.0),
    )


@drives(ParameterError, "switch.off = 1", "greater than switch.on = 2")
def latch_that_opens_before_it_closes():
    """A position switch opens before it closes."""
    build(switch=Latch(on=2.0, off=1.0, u=0.0))


@drives(EquationError, "profile (SpeedProfile)", "increase", "3 -> 2")
def sections_in_the_wrong_order():
    """The sections of a speed profile are not in the order of the way."""
    build(profile=SpeedProfile(sections=((0.0, 0.2), (3.0, 1.0), (2.0, 0.2)), a=1.0, u=0.0))


@drives(EquationError, "profile (SpeedProfile)", "speed -0.2", "not negative")
def section_for_the_way_back():
    """A speed profile is to serve for the way back, too."""
    build(profile=SpeedProfile(sections=((0.0, 1.0), (3.0, -0.2)), a=1.0, u=0.0))


@drives(ParameterError, "pi.k = -2 (gain)", "pi.T_s = 0 s (sampling time)")
def sampling_time_of_zero():
    """A controller has a negative gain and samples without end."""
    build(pi=SampledPI(k=-2.0, T_i=0.1, T_s=0.0, wanted=1.0, measured=0.0))


@drives(ParameterError, "motor.L_ls = 0 H", "leakage", "motor.pairs = 0 (pole pairs)")
def cage_without_leakage():
    """A squirrel-cage motor has no leakage and no pole pairs."""
    build(motor=SquirrelCageMotor(**CAGE, L_ls=0.0, pairs=0.0, f=50.0))


@drives(ConnectError, "motor.f: the input (frequency of the supply, Hz)")
def cage_without_frequency():
    """A squirrel-cage motor is given a voltage but no frequency."""
    build(motor=SquirrelCageMotor(**CAGE, L_ls=2e-3, pairs=2.0))


@drives(ParameterError, "servo.psi = 0 V.s", "magnets", "servo.L_q = -0.004 H")
def servo_without_magnets():
    """A synchronous motor has no magnets and a negative inductance."""
    build(
        servo=SynchronousMotor(
            psi=0.0, R=0.3, L_d=4e-3, L_q=-4e-3, pairs=3.0, J=0.01, v_d=0.0, v_q=20.0
        )
    )


@drives(ParameterError, "axis.v_max = -2 1/s", "axis.a = 0 1/s2", "greater than 0")
def cascade_with_negative_limits():
    """A cascade control has a negative limit of the speed and no deceleration."""
    loop = {"wanted": 1.0, "measured": 0.0, "v_measured": 0.0, "v_feed": 0.0, "f_feed": 0.0}
    build(axis=CascadeControl(K=5.0, a=0.0, v_max=-2.0, k=10.0, T_i=0.1, f_max=8.0, **loop))


@drives(EquationError, "order (PositionSequencer)", "targets = (0.5, None)", "finite number")
def target_that_is_none():
    """A sequence of positions holds something that is no number."""
    build(order=PositionSequencer(targets=(0.5, None), tolerance=0.01, dwell=0.2, measured=0.0))


@drives(ParameterError, "order.tolerance = 0", "order.dwell = -1 s", "greater than 0")
def sequence_without_tolerance():
    """A sequence of positions wants them exactly, and a negative dwell."""
    build(order=PositionSequencer(targets=(0.5,), tolerance=0.0, dwell=-1.0, measured=0.0))
