"""Quantities asked for as parameters that are none."""

from checks import refused
from rows import assemble_rows

import lumped as lp
from lumped.components import Constant, Inertia, Speed
from lumped.errors import UnknownNameError


def test_what_is_no_parameter_is_told_why():
    system = assemble_rows(
        "source.y speed.w", "speed body", source=Constant(k=3.0), speed=Speed(), body=Inertia(J=1.0)
    )
    for name, why in (("speed.w", "connected to a signal"), ("body.w", "the model computes it")):
        refused(UnknownNameError, lambda name=name: lp.start_point(system, free=[name]), why)
