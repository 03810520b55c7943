"""Rotors of ROSS have its torsional natural frequencies.

``tests/data/ross/rotors.json`` was written with ROSS 2.3.0: attributes of the elements of two
rotors, the torsional parts of their matrices, and the torsional modes that `run_modal` finds.
"""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy

import lumped as lp
from lumped.components import from_ross
from lumped.errors import DeclarationError

FILE = Path(__file__).parents[2] / "data" / "ross" / "rotors.json"
REFERENCE = json.loads(FILE.read_text())


def element(**attributes):
    if "material" in attributes:
        attributes["material"] = SimpleNamespace(**attributes["material"])
    return SimpleNamespace(**attributes)


def rotor(name, **changes):
    """A rotor with the attributes of ROSS; the first shaft element has some changed."""
    found = REFERENCE[name]
    first, *others = found["shaft_elements"]
    return SimpleNamespace(
        shaft_elements=[element(**one) for one in (first | changes, *others)],
        disk_elements=[element(**one) for one in found["disk_elements"]],
        bearing_elements=[SimpleNamespace(n=0, kxx=1e7)],
    )


@pytest.mark.parametrize("name", ["stepped", "coupled"])
def test_frequencies_are_those_of_torsional_modes_and_matrices(name):
    found = REFERENCE[name]
    squares = scipy.linalg.eigh(found["K"], found["M"], eigvals_only=True)
    modes = lp.modes(lp.assemble(from_ross(rotor(name))))
    received = 2 * np.pi * modes.hertz
    assert modes.rigid == 1
    errors = [
        np.abs(received / np.array(expected) - 1).max()
        for expected in (np.sqrt(squares[1:]), found["torsional_rad_per_s"])
    ]
    assert errors[0] < 1e-9
    assert errors[1] < 1e-7  # of the whole matrix with its bending modes


def test_damping_in_proportion_to_stiffness_is_that_of_a_matrix():
    """Of one element between discs: beta w / 2."""
    found = REFERENCE["coupled"]["shaft_elements"][0] | {"beta": 2e-6}
    one = SimpleNamespace(
        shaft_elements=[element(**found)],
        disk_elements=[element(n=0, Ip=0.2), element(n=1, Ip=0.5)],
    )
    modes = lp.modes(lp.assemble(from_ross(one)))
    c = 81.2e9 * np.pi / 32 * 0.08**4 / 0.4
    m = 7810 * np.pi / 32 * 0.08**4 * 0.4 / 6
    M = np.array([[0.2 + 2 * m, m], [m, 0.5 + 2 * m]])
    w = np.sqrt(scipy.linalg.eigh(c * np.array([[1, -1], [-1, 1]]), M, eigvals_only=True)[1])
    assert modes.damping == pytest.approx([1e-6 * w], rel=1e-9)
    assert abs(modes.eigenvalues[0]) == pytest.approx(w, rel=1e-9)


@pytest.mark.parametrize(
    ("given", "hint"),
    [
        (3, "Rotor of ROSS"),
        (SimpleNamespace(shaft_elements=[], rotors={}), "each of its rotors"),
        (rotor("stepped", alpha=0.1), r"node 0 to 1.*alpha = 0.1"),
        (
            SimpleNamespace(
                shaft_elements=[element(kr_z=0.0, cr_z=0.0, Ip_l=1, Ip_r=1, n_l=4, n_r=5)],
                disk_elements=[],
            ),
            "node 4 to 5 has no torsional",
        ),
    ],
)
def test_what_it_cannot_mean_is_refused(given, hint):
    with pytest.raises(DeclarationError, match=hint):
        from_ross(given)
