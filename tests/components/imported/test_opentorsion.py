"""Drives of openTorsion have its natural frequencies and damping ratios."""

import numpy as np
import opentorsion
import pytest
import scipy

import lumped as lp
from lumped.components import from_opentorsion
from lumped.errors import DeclarationError


def lumped_shafts():
    shafts = [opentorsion.Shaft(i, i + 1, k=k) for i, k in enumerate((3e4, 8e4, 5e3))]
    discs = [opentorsion.Disk(i, I=J) for i, J in enumerate((4.0, 1.5, 0.7, 9.0))]
    return opentorsion.Assembly(shafts, disk_elements=discs)


def shafts_with_mass():
    shafts = [opentorsion.Shaft(i, i + 1, L=400 + 100 * i, odl=90 + 5 * i) for i in range(5)]
    discs = [opentorsion.Disk(0, I=2.0), opentorsion.Disk(5, I=0.3)]
    return opentorsion.Assembly(shafts, disk_elements=discs)


def geared(elastic):
    kind = opentorsion.ElasticGear if elastic else opentorsion.Gear
    more = {"k": 2e6, "c": 0.0} if elastic else {}
    first = kind(1, I=0.2, R=50)
    second = kind(2, I=1.1, R=150, parent=first, **more)
    third = kind(4, I=0.5, R=75, parent=first, **more)
    shafts = [
        opentorsion.Shaft(0, 1, k=4e4, I=0.02),
        opentorsion.Shaft(2, 3, k=9e5),
        opentorsion.Shaft(4, 5, k=1e5),
    ]
    discs = [opentorsion.Disk(n, I=J) for n, J in ((0, 2.0), (3, 30.0), (5, 4.0))]
    gears = {"elastic_gear_elements" if elastic else "gear_elements": [first, second, third]}
    return opentorsion.Assembly(shafts, disk_elements=discs, **gears)


@pytest.mark.parametrize(
    "assembly",
    [lumped_shafts(), shafts_with_mass(), geared(False), geared(True)],
    ids=["discs", "shafts with mass", "rigid gears", "elastic gears"],
)
def test_undamped_frequencies_are_those_of_its_matrices(assembly):
    squares = scipy.linalg.eigh(assembly.K, assembly.M, eigvals_only=True)
    expected = np.sqrt(squares[1:]) / (2 * np.pi)
    modes = lp.modes(lp.assemble(from_opentorsion(assembly)))
    assert modes.rigid == 1
    assert len(modes.hertz) == len(expected)
    assert modes.hertz == pytest.approx(expected, rel=1e-9)


def test_damped_frequencies_and_ratios_are_those_of_its_analysis():
    shafts = [
        opentorsion.Shaft(i, i + 1, k=k, c=c) for i, (k, c) in enumerate(((3e4, 4), (8e4, 2)))
    ]
    discs = [opentorsion.Disk(i, I=J, c=c) for i, (J, c) in enumerate(((4, 3), (1.5, 0), (7, 1)))]
    assembly = opentorsion.Assembly(shafts, disk_elements=discs)
    w, _, ratios = assembly.modal_analysis()
    modes = lp.modes(lp.assemble(from_opentorsion(assembly)))
    error = np.abs(2 * np.pi * modes.hertz / w[2::2] - 1).max()
    lost = np.abs(modes.damping / ratios[2::2] - 1).max()
    assert error < 1e-9
    assert lost < 1e-6  # the ratios are small differences there
    # all turn together, slowed by both dampers: -(c_0 + c_2) / J, nearly
    assert modes.decays == pytest.approx([-4 / 12.5], rel=1e-3)


@pytest.mark.parametrize(
    ("assembly", "hint"),
    [
        (3, "shaft_elements"),
        (
            opentorsion.Assembly(
                [opentorsion.Shaft(0, 1, k=1e3)], [opentorsion.Disk(0, 1.0, k=5.0)]
            ),
            "node 0",
        ),
    ],
)
def test_what_it_cannot_mean_is_refused(assembly, hint):
    with pytest.raises(DeclarationError, match=hint):
        from_opentorsion(assembly)
