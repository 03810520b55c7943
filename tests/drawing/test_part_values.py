"""What schematics tell of parts, against closed forms."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import (
    Brake,
    Clutch,
    ElasticPlanetary,
    GearMesh,
    IdealGear,
    Inertia,
    Planetary,
    SpringDamper,
    Stribeck,
)
from lumped.drawing.part_values import find_part_values, find_powers, part_texts, write_short

J = 3.0


class Drive(lp.Component):
    """A motor, a clutch whose force and radius follow from others, gears and a brake."""

    area: lp.Param = lp.param("m2", "area of the piston", 0.02)
    p: lp.Param = lp.param("Pa", "pressure", 1e6)
    motor = Inertia(J=J)
    clutch = Clutch(f_max=area * p, c_geo=0.25, u=1.0, characteristic=((0.0, 0.4), (10.0, 0.3)))
    hub = Inertia(J=1234.5)
    gear = IdealGear(ratio=-2.5)
    shaft = SpringDamper(c=1.2345e6, d=7.0)
    load = Inertia(J=2.0)
    brake = Brake(f_max=100.0, u=0.0, characteristic=Stribeck(0.3, 0.35, 1.0))

    def connections(self):
        yield from lp.chain(
            self.motor, self.clutch, self.hub, self.gear, self.shaft, self.load, self.brake
        )


def test_parts_tell_inertia_stiffness_ratio_and_torque():
    system = lp.assemble(Drive())
    assert part_texts(system, system.theta({})) == {
        "motor": "3 kg.m2",
        "clutch": "2000 N.m",  # 0.4 0.25 m 0.02 m2 1 MPa
        "hub": "1230 kg.m2",
        "gear": "i = -2.5",
        "shaft": "1.23 MN.m/rad",
        "load": "2 kg.m2",
        "brake": "35 N.m",  # at standstill
    }
    both = np.array([system.theta({"p": p}) for p in (1e6, 2e7)])
    assert part_texts(system, both, {"N.m": "kN.m"})["clutch"] == "2 kN.m to 40 kN.m"


def test_a_mesh_tells_its_ratio():
    mesh = GearMesh(r_a=0.1, r_b=0.35, z=20.0, c=1e8)
    system = lp.assemble(in_a_row(a=Inertia(J=1.0), mesh=mesh, b=Inertia(J=1.0)))
    assert part_texts(system, system.theta({}))["mesh"] == "i = 3.5"


def test_what_is_told_as_a_product_of_parameters():
    system = lp.assemble(Drive())
    names = list(system.parameters)
    found = find_powers(system, find_part_values(system)["clutch"])
    powers = {names[i]: k for i, k in found["powers"] if k}
    assert powers == {"area": 1.0, "p": 1.0, "clutch.c_geo": 1.0}
    assert found["factor"] == pytest.approx(0.4, rel=1e-12)

    class Sum(lp.Component):
        a: lp.Param = lp.param("kg.m2", "one", 1.0)
        rotor = Inertia(J=a + 1.0)

    told = find_part_values(system := lp.assemble(Sum()))["rotor"]
    assert find_powers(system, told) is None


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (9999.0, "N.m", "10000 N.m"),
        (12345.0, "N.m", "12.3 kN.m"),
        (-2.5e6, "N", "-2.5 MN"),
        (4.56e9, "N/m", "4.56 GN/m"),
        (277321.0, "kg.m2", "277000 kg.m2"),
        (0.10634, "1", "0.106"),
    ],
)
def test_values_have_three_digits(value: float, unit: str, text: str):
    assert write_short(value, unit) == text


ELASTIC = ElasticPlanetary(ratio=2.0, r_s=0.1, n=3, J_p=1.0, c_s=1e8, c_r=1e8)


@pytest.mark.parametrize("stage", [Planetary(ratio=3.0), ELASTIC], ids=["rigid", "elastic"])
@pytest.mark.parametrize("swap", [0, 1, 2])
def test_planetary_sets_tell_sun_carrier_and_ring(stage: lp.Component, swap: int):
    def connections(model):
        ports = [model.stage.sun, model.stage.carrier, model.stage.ring]
        for body, port in zip(model.body, ports[swap:] + ports[:swap], strict=True):
            yield lp.connect(port, body.flange_a)

    model = lp.compose(
        body=[Inertia(J=1.0) for _ in range(3)], stage=stage, connections=connections
    )
    axes = lp.schematic(model).axes[0]
    centres = {
        patch.get_gid(): patch.get_path().get_extents().get_points().mean(axis=0)
        for patch in axes.patches
        if patch.get_gid()
    }
    letters = {t.get_text(): t for t in axes.texts if len(t.get_text()) == 1}
    assert set(letters) == {"s", "c", "r"}
    for i, letter in enumerate("scr"[swap:] + "scr"[:swap]):
        at = np.array(letters[letter].get_position()) - centres["stage"]
        to = centres[f"body[{i}]"] - centres["stage"]
        others = [centres[f"body[{k}]"] - centres["stage"] for k in range(3) if k != i]
        angle = [at @ v / np.linalg.norm(v) for v in (to, *others)]
        assert angle[0] == max(angle), letter  # on the side of what is joined there
        assert letters[letter].get_fontsize() >= 8.25  # points: 11 pixels
