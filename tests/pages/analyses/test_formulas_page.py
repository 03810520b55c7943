"""What docs/analyses/formulas.md shows is true."""

import numpy as np
import pytest
import scipy
from docutils.utils.math.latex2mathml import tex2mathml
from mill_by_hand import C1, C2, J1, J3, JR
from page_code import read_page, run_blocks

NAME = "analyses/formulas"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return run_blocks(NAME, tmp_path_factory.mktemp("formulas"))


def test_the_page_prints_what_it_shows(page):
    for lines, shown in page[1]:
        if shown:
            assert lines == shown
    latex = page[0]["closed"].polynomial.latex()
    assert f"```math\n{latex}\n```" in read_page(NAME)
    assert tex2mathml(latex, as_block=True).startswith("<math")


def test_the_frequency_equation_is_that_of_filatov(page):
    """Equation (56), with the signs that its derivation needs."""
    polynomial = page[0]["closed"].polynomial
    both, J2 = 2 * JR, J1 + J3
    a1, a2, a3 = C1 / J1 + C1 / J3, C2 / J3 + C2 / both, C2 / J2 + C2 / both
    for K in 2 * np.pi * np.array([3.0, 11.0, 29.0, 60.0]):
        expected = K**6 - K**4 * (a1 + a2 + a3)
        second = a1 * a2 + a1 * a3 + a2 * a3 - (C1 / J3) * (C2 / J3) - (C2 / both) ** 2
        last = a1 * a2 * a3 - a3 * (C1 / J3) * (C2 / J3) - a1 * (C2 / both) ** 2
        expected += K**2 * second - last
        assert polynomial({"lambda": K**2}) == pytest.approx(expected, rel=1e-9)


def test_slopes_are_those_of_differences(page):
    names = page[0]
    p = dict(names["train"].system.parameters)
    bodies = ("flywheel", "motor", "gearbox", "pinions", "rolls")
    twist = np.diff(np.eye(5), axis=0)

    def frequencies(c):
        K = twist.T @ np.diag(c) @ twist
        M = np.diag([p[f"{body}.J"] for body in bodies])
        return np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[1:])

    c = np.array([p[f"{name}.c"] for name in names["springs"]])
    w = frequencies(c)
    for k, name in enumerate(names["springs"]):
        step = 1e-3 * np.eye(4)[k] * c[k]
        near = [frequencies(c + i * step) for i in (-3, -2, -1, 1, 2, 3)]
        weights = np.array([-1, 9, -45, 45, -9, 1]) / 60
        expected = weights @ near / step[k]
        received = [names["slopes"][name](names["train"].mode(mode)) for mode in range(4)]
        assert np.abs(received - expected).max() < 1e-9 * (w / c[k]).max()
    closed = [formula() for formula in names["train"].frequencies]
    assert closed == pytest.approx(w, rel=1e-11)


def test_the_ratio_of_the_ellipses_is_the_kernel_of_poisson(page):
    """``u = 1 + 2 sum(e^k cos(k x))``; the reduced inertia that varies with it accelerates."""
    names = page[0]
    x = np.linspace(0.0, 6.0, 13)
    k = np.arange(1, 60)[:, None]
    u = 1 + 2 * (0.5**k * np.cos(k * (x - 2.18))).sum(axis=0)
    assert names["ratio"]({"crank.phi": x}) == pytest.approx(u, rel=1e-12)
    du = -2 * (k * 0.5**k * np.sin(k * (x - 2.18))).sum(axis=0)
    expected = -(u * du * 54e3) * 1.05**2 / (3e3 + u**2 * 54e3)
    formula = names["lp"].vibration.formula(names["ellipses"], "crank.a")
    assert formula({"crank.phi": x, "crank.w": 1.05}) == pytest.approx(expected, rel=1e-10)
