"""Genset of a fresh user: from its data to the printed report."""

import csv
import sys
from pathlib import Path

import numpy as np

import lumped as lp
from lumped.components import Cylinder, Damper, Fixed, Inertia, LossSpring, Torque
from lumped.vibration import Limit, order_response

DATA = Path(__file__).parents[1] / "data" / "torsional" / "02_six_cylinder_crankshaft"
RPM = np.pi / 30
FIRES = (0, 4, 2, 5, 1, 3)  # positions in the firing order 1-5-3-6-2-4
THROWS = (0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487)
CRANK = (1.106e6, 1.631e6, 1.253e6, 1.253e6, 1.678e6, 1.253e6, 1.253e6, 1.976e6)


class Shaft(LossSpring):
    """Shaft with its torsional stress."""

    d: lp.Param = lp.param("m", "diameter", 0.085, above=0)
    stress: lp.Var = lp.var("Pa", "nominal torsional stress")

    def equations(self):
        yield from super().equations()
        yield self.stress == 16 * self.tau_c / (np.pi * self.d**3)


def genset(misfiring=None):
    with (DATA / "pressure_curve.csv").open() as file:
        rows = [(np.radians(float(a)), 1e6 * float(p)) for a, p in list(csv.reader(file))[1:]]
    cylinders = [
        Cylinder(
            pressure=rows,
            masses="excitation",
            misfire="compression" if i == misfiring else "none",
            **dict(bore=0.105, r=0.0685, L=0.207, m=2.521, load=0.9),
            phase=position * 2 * np.pi / 3,
        )
        for i, position in enumerate(FIRES)
    ]
    model = lp.compose(
        mass=[Inertia(J=J) for J in (0.017, 0.009, *THROWS, 2.075)],
        shaft=[Shaft(c=c, eta=0.035, w_loss=1300.0) for c in CRANK],
        oil=[Damper(d=2.0) for _ in FIRES],
        cylinder=cylinders,
        coupling=LossSpring(c=4e4, eta=0.15, w_loss=235.0),
        alternator=Inertia(J=6.0),
        load=Torque(tau=-1000.0),
        ground=Fixed(),
        connections=lambda m: [
            *lp.chain(*(x for pair in zip(m.mass, m.shaft, strict=False) for x in pair), m.mass[8]),
            *lp.chain(m.mass[8], m.coupling, m.alternator, m.load),
            *(c for i in range(6) for c in lp.chain(m.ground, m.oil[i], m.mass[i + 2])),
            *(lp.connect(m.cylinder[i].flange, m.mass[i + 2].flange_a) for i in range(6)),
        ],
    )
    return lp.assemble(model, keep=["mass[8].phi"])


def report(path, parameters=None):
    of = ["coupling.tau", "shaft[7].stress", "alternator.phi"]
    options = dict(speeds=np.linspace(600, 1600, 41) * RPM, of=of, over="mass[8].phi", turns=2)
    options |= dict(free="load.tau", parameters=parameters)
    healthy, misfire = genset(), genset(misfiring=0)
    responses = {
        "all cylinders fire": order_response(healthy, **options),
        "cylinder 1 misfires": order_response(misfire, **options),
    }
    start = lp.start_point(healthy, start={"mass[8].w": 1500 * RPM}, together=True)
    trip = lp.simulate(healthy, until=0.5, start=start, parameters=parameters, grid=2000)
    continuous = dict(source="maker of the coupling", measure="maximum")
    limits = [
        Limit("coupling.tau", "1.5 kN.m", "vibratory torque", **continuous, speeds=(147, 168)),
        Limit("shaft[7].stress", "40 MPa", "crank shaft", source="classification society"),
    ]
    return lp.drawing.torsional_report(
        responses,
        path,
        title="Torsional vibrations of the genset",
        about={"Plant": "Emergency power, hall 3", "Author": "A. Engineer", "Sources": ["02"]},
        limits={**dict.fromkeys(responses, limits), "Load rejection": []},
        operation=("1450 rpm", "1550 rpm"),
        runs={"Load rejection": trip},
        assumptions=["The bending of the crank is not computed."],
    )


if __name__ == "__main__":
    report(sys.argv[1])
