"""Formulas of textbooks, what is refused, and how formulas are written."""

import subprocess
import sys

import casadi as ca
import numpy as np
import pytest
from checks import refused
from drive_chains import in_turn
from rows import assemble_row, in_a_row

import lumped as lp
from lumped.components import Clutch, CrankSlider, Inertia, Spring, SpringDamper
from lumped.errors import OptionError, UnknownNameError
from lumped.models.reversing_mill import stand
from lumped.models.reversing_mill.stand import OpenGap, PrintedGap


def test_two_inertias_have_the_formula_of_every_textbook(two_mass):
    (formula,) = lp.vibration.symbolic(lp.assemble(two_mass)).frequencies
    assert formula.names == ("a.J", "b.J", "shaft.c")
    for a, b, c in ((1.0, 2.0, 300.0), (0.1, 77.0, 5e6)):
        received = formula({"a.J": a, "b.J": b, "shaft.c": c})
        assert received == pytest.approx(np.sqrt(c * (a + b) / (a * b)), rel=1e-14)


def test_separate_branches_without_a_damper_have_formulas():
    found = lp.vibration.symbolic(lp.assemble(OpenGap())).frequencies
    upper, lower = (
        np.sqrt(np.linalg.eigvalsh(np.diag(J**-0.5) @ K @ np.diag(J**-0.5)))[1:]
        for J, K in branches()
    )
    expected = np.sort([*upper, *lower])
    assert [formula() for formula in found] == pytest.approx(expected, rel=1e-12)
    assert "lower" not in str(found[0])


def branches():
    """Inertias and stiffnesses of both halves of the open stand."""
    C1, C2 = float(stand.C_SHAFT), float(stand.C_SPINDLE)
    J1, J3, J = float(stand.J_MOTOR), float(stand.J_GEARBOX), float(stand.J_BACKUP + stand.J_WORK)
    yield np.array([J1, J3, J]), np.array([[C1, -C1, 0], [-C1, C1 + C2, -C2], [0, -C2, C2]])
    yield np.array([J1 + J3, J]), np.array([[C2, -C2], [-C2, C2]])


def test_quantities_are_formulas_in_the_shortest_way():
    system = assemble_row(a=Inertia(J=2.0), shaft=SpringDamper(c=3.0, d=0.5), b=Inertia(J=4.0))
    torque = lp.vibration.formula(system, "shaft.tau", parameters={"shaft.phi_rel0": 0})
    numbers = {"shaft.c": 7.0, "shaft.d": 0.3, "shaft.phi_rel": 0.2, "b.w": 3.0, "a.w": 1.0}
    assert torque(numbers) == pytest.approx(7.0 * 0.2 + 0.3 * 2.0, rel=1e-15)
    function = ca.Function("f", ca.symvar(torque.casadi), [torque.casadi])
    assert function.n_in() == len(numbers)
    refused(UnknownNameError, lambda: torque({"shaft.c": 7.0}), "give values of")
    refused(UnknownNameError, lambda: torque({**numbers, "shaft.k": 1.0}), "no 'shaft.k'")


def test_terms_are_left_out_on_request_with_their_error():
    """A hundred kg.m2 beside one: the light body alone on its shaft."""
    system = assemble_row(a=Inertia(J=100.0), shaft=Spring(c=3.0), b=Inertia(J=1.0))
    (whole,) = lp.vibration.symbolic(system).frequencies
    short = whole.shorten(0.05)
    assert short.names == ("b.J", "shaft.c")
    assert short() == pytest.approx(np.sqrt(3.0), rel=1e-15)
    assert short.error == pytest.approx(1 - 1 / np.sqrt(1.01), rel=1e-9)
    assert f"{short.error:.1e}" in str(short)


def test_what_has_no_formula_is_refused():
    five = in_turn(body=[Inertia(J=1.0) for _ in range(6)], shaft=[Spring(c=1.0) for _ in range(5)])
    drive = lp.vibration.symbolic(lp.assemble(five))
    refused(OptionError, lambda: drive.frequencies, "5 modes in one part")
    refused(OptionError, lambda: drive.mode(5), "no mode 5")
    relaxing = lp.vibration.symbolic(lp.assemble(PrintedGap()))
    refused(OptionError, lambda: relaxing.K, "a twist relaxes")
    slider = CrankSlider(r=0.1, L=0.4, m=2.0)
    crank = in_a_row(wheel=Inertia(J=1.0), shaft=Spring(c=10.0), crank=slider)
    refused(OptionError, lambda: lp.vibration.symbolic(lp.assemble(crank)), "not linear")
    system = assemble_row(
        a=Inertia(J=1.0),
        clutch=Clutch(characteristic=((0.0, 0.3),), c_geo=1.0, f_max=10.0, u=1.0),
        b=Inertia(J=1.0),
    )
    refused(OptionError, lambda: lp.vibration.formula(system, "der(a.w)"), "modes")


def test_a_net_of_too_many_circles_is_refused():
    n = 12
    pairs = [(i, j) for i in range(n) for j in range(i)]
    net = lp.compose(
        body=[Inertia(J=1.0) for _ in range(n)],
        shaft=[Spring(c=1.0) for _ in pairs],
        connections=lambda m: [
            joint
            for k, (i, j) in enumerate(pairs)
            for joint in lp.chain(m.body[i].flange_a, m.shaft[k], m.body[j].flange_a)
        ],
    )
    drive = lp.vibration.symbolic(lp.assemble(net))
    refused(OptionError, lambda: drive.polynomial, "no formula to read")


def test_without_sympy_the_error_says_what_to_install():
    code = (
        "import sys; sys.modules['sympy'] = None\n"
        "import lumped as lp\nfrom lumped.models.reversing_mill.stand import OpenGap\n"
        "try: lp.vibration.symbolic(lp.assemble(OpenGap()))\n"
        "except lp.errors.OptionError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "pip install lumped[formulas]" in done.stdout


def test_names_of_parts_leave_those_of_parameters_alone():
    class Named(lp.Component):
        """Three bodies whose first inertia has the name of a part."""

        a1: lp.Param = lp.param("kg.m2", "inertia", 2.0, above=0)
        a: Inertia = Inertia(J=a1)
        one: Spring = Spring(c=30.0)
        b: Inertia = Inertia(J=3.0)
        two: Spring = Spring(c=70.0)
        d: Inertia = Inertia(J=5.0)

        def connections(self):
            yield from lp.chain(self.a, self.one, self.b, self.two, self.d)

    found = lp.vibration.symbolic(lp.assemble(Named())).frequencies
    K = np.array([[30.0, -30, 0], [-30, 100, -70], [0, -70, 70]])
    root = np.diag(np.array([2.0, 3.0, 5.0]) ** -0.5)
    expected = np.sqrt(np.linalg.eigvalsh(root @ K @ root)[1:])
    assert [formula() for formula in found] == pytest.approx(expected, rel=1e-12)
