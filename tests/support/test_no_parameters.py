"""Quantities asked for as parameters that are none."""

from rows import assemble_rows
from test_wrong_calls import message

import lumped as lp
from lumped.components import Inertia, Speed, Torque
from lumped.errors import UnknownNameError


def test_what_is_no_parameter_is_told_why():
    class Doubled(lp.Component):
        """A signal."""

        y = lp.Output("rad/s", "speed")

        def equations(self):
            yield self.y == 2 * lp.time

    system = assemble_rows(
        "load body",
        "speed other",
        "source.y speed.w",
        load=Torque(tau=3 * lp.ops.sin(lp.time)),
        body=Inertia(J=1.0),
        source=Doubled(),
        speed=Speed(),
        other=Inertia(J=1.0),
    )

    def free(name):
        return message(lambda: lp.start_point(system, free=[name]), UnknownNameError)

    text = free("load.tau")
    assert "'load.tau' is no parameter, as it is given as the expression 3 * sin(time)" in text
    assert "give a number instead" in text
    assert "connected to a signal" in free("speed.w")
    assert "the model computes it" in free("body.w")
