"""What docs/analyses/graph.md shows is true."""

import numpy as np
import pytest

from lumped.models.marine_turbine import drive

NAME = "analyses/graph"


def test_the_halves_of_the_ship_are_those_of_matrices_written_here(names):
    assert set(names["sides"][0]) == {"propeller", "blades", "load"}
    first = drive.FIRST**2
    J = [drive.J_BULL]
    c = []
    for wheel, rotor, turns, inner, outer in (
        (drive.J_LP_WHEEL, drive.J_LP, drive.LP_TURNS, drive.C_LP_FIRST, drive.C_LP),
        (drive.J_HP_WHEEL, drive.J_HP, drive.HP_TURNS, drive.C_HP_FIRST, drive.C_HP),
    ):
        c += [(0, len(J), inner * first), (len(J), len(J) + 1, outer * turns**2)]
        J += [wheel * first, rotor * turns**2]
    assert names["J"] == pytest.approx([drive.J_PROPELLER, sum(J)], rel=1e-9)
    K = np.zeros((len(J), len(J)))
    for a, b, stiffness in c:
        K[np.ix_([a, b], [a, b])] += stiffness * np.array([[1.0, -1.0], [-1.0, 1.0]])
    root = np.sqrt(J)
    w2 = np.linalg.eigvalsh(K / np.outer(root, root))
    # a shaft so soft moves the frequencies of the half by about a share of 1e-4
    assert names["table"].hertz[1:] == pytest.approx(np.sqrt(w2[1:]) / (2 * np.pi), rel=1e-4)
    assert names["table"].hertz[0] == pytest.approx(names["hertz"], rel=1e-4)
    shares = names["energies"].kinetic
    on_propeller = shares[1:, names["energies"].components.index("propeller")]
    assert on_propeller == pytest.approx(np.zeros(4), abs=1e-6)


def test_only_the_countershafts_have_a_way_round(names):
    pump = {"pump_gear", "pump", "oil"}
    on_way = names["carrying"](names["power"](names["graph"]), "motor", "cut")
    everything = set(names["parts"](names["graph"], names["graph"]))
    assert everything - set(on_way) == pump
    both = {n for n in everything if n.startswith(("upper.", "lower."))}
    assert names["alone"] & everything == everything - pump - both - {"motor", "cut"}
