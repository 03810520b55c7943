"""What type checkers say of the library's constructors; a mark names the error of a line."""

from typing import assert_type

import numpy as np
import pint

import lumped as lp
from lumped.components import (
    Belt,
    Clutch,
    DCMotor,
    Engine,
    HarmonicTorque,
    Inertia,
    NonlinearSpring,
    Table,
    Torque,
    translation,
)

wheel = Inertia(J=1.2, phi=0, w=3)
assert_type(wheel.w, lp.Expr)
assert_type(wheel.flange_a, lp.Flange)
assert_type(Inertia.J, lp.Param)
assert_type(wheel.with_({"J": 2.0}), Inertia)

Inertia()
Inertia(J=2)
Inertia(J="3 kg.m2", w="300 rpm")
Inertia(J=np.float64(3), phi=np.int64(1), w=np.float32(2))
Inertia(J=np.linspace(1, 2, 5)[0])
Inertia(J=pint.UnitRegistry().Quantity(3.0, "kg*m**2"))
Inertia(J=2 * wheel.J, w=-wheel.w / 2)
Torque(tau=5.0)
Torque(tau=5 * lp.ops.sin(lp.time))
Torque(tau=lp.ops.table(np.array([0, 1]), [0, 5]))
Belt(crossed=True, r_a=0.1)
HarmonicTorque(harmonics=[(1, 2.0, 0.0)])
HarmonicTorque(harmonics=np.ones((4, 3)))
NonlinearSpring(characteristic=[(0, 0), (0.1, 50)])
NonlinearSpring(characteristic=np.ones((4, 2)))
NonlinearSpring(characteristic=lambda twist: 5 * twist**3)
Table(times=[0, 1], values=np.zeros(2))
Engine(cylinders=4, J=[1, 2, 2, 1], d=0.5, misfire={3: "no gas"}, shape="smooth")
translation.Mass(m="2 t", v=1)

Inertia(K=3.0)  # error: call-arg, reportCallIssue
Inertia(1.2)  # error: call-arg, reportCallIssue
Inertia(J=[1, 2])  # error: arg-type, reportArgumentType
Inertia(J=None)  # error: arg-type, reportArgumentType
Inertia(J=3j)  # error: arg-type, reportArgumentType
Inertia(J=np.ones(3))  # error: arg-type, reportArgumentType
Inertia(J=wheel)  # error: arg-type, reportArgumentType
Inertia(J=wheel.w == 3)  # error: arg-type, reportArgumentType
Inertia(J=lp.normal(3, 0.1))  # error: arg-type, reportArgumentType
Inertia(w=[1])  # error: arg-type, reportArgumentType
Inertia(flange_a=lp.Flange())  # error: call-arg, reportCallIssue
Torque(tau=lambda t: 5 * t)  # error: arg-type, reportArgumentType
Torque(w=3.0)  # error: call-arg, reportCallIssue
Clutch(capacity=3)  # error: call-arg, reportCallIssue
Belt(crossed="yes")  # error: arg-type, reportArgumentType
Belt(F=3)  # error: call-arg, reportCallIssue
NonlinearSpring(characteristic="steep")  # error: arg-type, reportArgumentType
Table(times=3, values=[1])  # error: arg-type, reportArgumentType
Engine(shape="round")  # error: arg-type, reportArgumentType
DCMotor(V=3)  # error: call-arg, reportCallIssue
translation.Mass(J=2)  # error: call-arg, reportCallIssue
wheel.J = 3  # error: arg-type, reportAttributeAccessIssue
assert wheel.inertia  # error: attr-defined, reportAttributeAccessIssue
