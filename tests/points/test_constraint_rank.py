"""Constraints of linkages that are redundant wherever they move."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Bar, translation
from lumped.errors import SingularModelError
from lumped.points.constraint_rank import refuse_redundant
from lumped.points.start_search import StartSearch


def cranks(places, lengths, angle):
    """Cranks on one coupler, of which each bar leads from one crank to the next."""
    count = len(places)
    parts = {f"x{i}": translation.Fixed(s0=place) for i, place in enumerate(places)}
    parts |= {f"y{i}": translation.Fixed() for i in range(count)}
    parts["crank"] = [Bar(length=length, m=1.0, J=0.1, phi=angle) for length in lengths]
    parts["coupler"] = Bar(length=places[-1] - places[0], m=1.0, J=0.1, phi=0.0)
    if count > 2:
        parts["arm"] = Bar(length=places[1] - places[0], m=1.0, J=0.1, phi=0.0)

    def connect(m):
        for i in range(count):
            yield lp.connect(getattr(m, f"x{i}").flange, m.crank[i].a_x)
            yield lp.connect(getattr(m, f"y{i}").flange, m.crank[i].a_y)
        for way in ("x", "y"):
            ends = [getattr(crank, f"b_{way}") for crank in m.crank]
            yield lp.connect(ends[0], getattr(m.coupler, f"a_{way}"))
            yield lp.connect(ends[-1], getattr(m.coupler, f"b_{way}"))
            if count > 2:
                yield lp.connect(ends[0], getattr(m.arm, f"a_{way}"))
                yield lp.connect(ends[1], getattr(m.arm, f"b_{way}"))
        if count > 2:  # the arm is fixed to the coupler
            yield lp.connect(m.arm.flange, m.coupler.flange)

    return lp.compose(connections=lambda m: list(connect(m)), **parts)


def derivatives(angles, tilt, lengths, places):
    """Of the closures of cranks 1 and 3, and 1 and 2, by the angles of all and of the coupler."""
    rows = []
    for last in (2, 1):
        matrix = np.zeros((2, 4))
        for i, sign in ((0, 1), (last, -1)):
            way = np.array([-np.sin(angles[i]), np.cos(angles[i])])
            matrix[:, i] = sign * lengths[i] * way
        reach = places[last] - places[0]
        matrix[:, 3] = reach * np.array([-np.sin(tilt), np.cos(tilt)])
        rows.append(matrix)
    return np.concatenate(rows)


def test_a_third_parallel_crank_is_refused_with_its_rank():
    places, lengths = [0.0, 0.4, 1.0], [0.5, 0.5, 0.5]
    for angle in (1.0, 2.2):
        matrix = derivatives([angle] * 3, 0.0, lengths, places)
        matrix /= np.linalg.norm(matrix, axis=1)[:, None]
        assert np.linalg.matrix_rank(matrix) == 3
    system = lp.assemble(cranks(places, lengths, 1.0))
    with pytest.raises(SingularModelError) as caught:
        lp.start_point(system)
    text = str(caught.value)
    print(text)
    assert "of 20 constraints of linkages only 19 are independent" in text
    assert "1 motions are left, not 0" in text
    assert "how crank[0], crank[1], crank[2], coupler, arm share" in text


def test_a_singular_position_is_no_redundancy():
    system = lp.assemble(cranks([0.0, 1.0], [0.5, 0.5], 0.0))
    search = StartSearch(system, system.theta(None), {}, [], 0.0)
    modes = np.zeros(system.structure.flat.mode_count)
    refuse_redundant(system, search.x, search.theta, modes, search.guesses, 0.0)


def test_two_parallel_cranks_turn_at_constant_speed():
    system = lp.assemble(cranks([0.0, 1.0], [0.5, 0.5], 1.0))
    run = lp.simulate(system, until=1.0, start={"crank[0].w": 0.7}, rtol=1e-9)
    assert run["crank[0].phi"][-1] == pytest.approx(1.7, rel=1e-8)
    assert abs(run["coupler.phi"][-1]) < 1e-8
