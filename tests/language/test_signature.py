"""What help, inspect and IPython show of a component class."""

import inspect
import pydoc
import subprocess
import sys

import cloudpickle
import pytest

import lumped as lp
from lumped.components import Fixed, Inertia, Spring
from lumped.language.component import Made
from lumped.language.declared import text_of


class Drive(lp.Component):
    """Drive under test: ``tau = u``.

    A second paragraph.
    """

    load = lp.Flange()
    end = lp.Flange(free=True)
    housing = lp.Flange(grounded=True)
    speed = lp.Output("rad/s", "speed of the rotor")
    u: lp.Input = lp.Input("N.m", "torque")
    J: lp.Param = lp.param("kg.m2", "moment of inertia", above=0)
    r: lp.Param = lp.param("m", "radius", 0.5, min=0, below=3)
    R: lp.Param = lp.param("m", "outer radius", 2 * r, above=r, max=9)
    ratio: lp.Param = lp.param("1", "gear ratio", lambda drive: drive.turns, nonzero=True)
    k: lp.Param = lp.param("1", "factor", 1.0, min=lambda drive: drive.turns)
    turns: int = 4
    shape: str | None = None
    rotor: Inertia = Inertia(J=J)
    bodies: tuple[Inertia, ...] = (Inertia(J=J), Inertia(J=2 * J))
    ends: dict[str, Fixed] = {"left": Fixed(), "right": Fixed()}  # noqa: RUF012
    springs = Made(lambda drive: [Spring(c=1) for _ in range(drive.turns)])
    w: lp.Var = lp.var("rad/s", "speed", 2.0)
    phi: lp.Var = lp.var("rad", "angle")


DOCUMENTATION = """\
Drive under test: ``tau = u``.

A second paragraph.

Parameters
----------
turns : int, default 4
shape : str | None, default None
u : N.m, input
    torque
J : kg.m2, greater than 0
    moment of inertia
r : m, at least 0, less than 3, default 0.5
    radius
R : m, greater than r, at most 9, default 2 * r
    outer radius
ratio : 1, not 0, default follows from others
    gear ratio
k : 1, at least a value that follows from others, default 1.0
    factor
rotor : Inertia
bodies : 2 parts
ends : parts 'left', 'right'
springs : made parts

Variables
---------
w : rad/s, start 2.0
    speed
phi : rad
    angle

Outputs
-------
speed : rad/s
    speed of the rotor

Ports
-----
load : rotational flange
end : rotational flange, free if open
housing : rotational flange, at rest if open"""


def test_signature_has_each_argument_with_unit_or_type_and_default() -> None:
    received = str(inspect.signature(Drive))
    expected = (
        "(*, turns: 'int' = 4, shape: 'str | None' = None, u: 'N.m' = ..., J: 'kg.m2', "
        "r: 'm' = 0.5, R: 'm' = ..., ratio: '1' = ..., k: '1' = 1.0, rotor: 'Inertia' = ..., "
        "bodies: '2 parts' = ..., ends: \"parts 'left', 'right'\" = ..., "
        "springs: 'made parts' = ..., w: 'rad/s' = ..., phi: 'rad' = ...)"
    )
    assert received == expected


def test_documentation_lists_what_is_declared_after_what_is_written() -> None:
    received = Drive.__doc__
    expected = DOCUMENTATION
    assert received == expected


def test_what_is_written_is_found_alone() -> None:
    received = text_of(Drive)
    expected = "Drive under test: ``tau = u``.\n\nA second paragraph."
    assert received == expected


def test_a_docstring_set_afterwards_counts() -> None:
    class Late(lp.Component):
        pass

    Late.__doc__ = """Set
        afterwards."""
    received = text_of(Late)
    expected = "Set\nafterwards."
    assert received == expected


def test_help_shows_signature_and_documentation() -> None:
    received = pydoc.plain(pydoc.render_doc(Inertia)).replace("\n |  ", "\n")
    assert (
        "Inertia(*, J: 'kg.m2', phi: 'rad' = ..., w: 'rad/s' = ..., a: 'rad/s2' = ..." in received
    )
    assert "\nJ : kg.m2, greater than 0\n    moment of inertia\n" in received
    assert "\nflange_a : rotational flange, free if open\n" in received


def test_subclass_lists_what_it_inherits_and_changes() -> None:
    class Locked(Drive):
        J: lp.Param = lp.param("kg.m2", "moment of inertia, locked", 3.0)
        turns = 7

    received = inspect.signature(Locked).parameters
    assert set(received) == set(inspect.signature(Drive).parameters)
    assert (received["J"].default, received["turns"].default) == (3.0, 7)
    assert (received["turns"].annotation, text_of(Locked)) == ("int", "")
    assert "\nJ : kg.m2, default 3.0\n    moment of inertia, locked\n" in Locked.__doc__


def test_instance_has_the_documentation_of_its_class_and_no_signature() -> None:
    assert Drive(J=1).__doc__ == DOCUMENTATION
    with pytest.raises(TypeError, match="not a callable object"):
        inspect.signature(Drive(J=1))


def test_class_with_another_constructor_is_described_by_that() -> None:
    class Doubled(Inertia):
        def __init__(self, half: float) -> None:
            super().__init__(J=2 * half)

    received = str(inspect.signature(Doubled))
    expected = "(half: float) -> None"
    assert received == expected


def test_a_class_sent_to_another_process_keeps_its_documentation() -> None:
    class Local(lp.Component):
        """Local one."""

        d: lp.Param = lp.param("m", "diameter")

    code = "import pickle, sys; print(pickle.load(sys.stdin.buffer).__doc__, end='')"
    sent = cloudpickle.dumps(Local)
    done = subprocess.run([sys.executable, "-c", code], input=sent, capture_output=True, check=True)
    received = done.stdout.decode()
    expected = "Local one.\n\nParameters\n----------\nd : m\n    diameter"
    assert received == expected
