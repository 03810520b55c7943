"""The genset of a fresh user: from its data to the printed report."""

from pathlib import Path

import numpy as np

import lumped as lp
from lumped.components import Cylinder, Damper, Fixed, Inertia, LossSpring, Torque
from lumped.vibration import Limit, order_response

TABLE = Path(__file__).parents[1] / "data/torsional/02_six_cylinder_crankshaft/pressure_curve.csv"
RPM = np.pi / 30
POSITIONS = (0, 4, 2, 5, 1, 3)  # of the cylinders in the firing order 1-5-3-6-2-4
INERTIAS = (0.017, 0.009, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.075)  # kg.m2
STIFFNESSES = (1.106e6, 1.631e6, 1.253e6, 1.253e6, 1.678e6, 1.253e6, 1.253e6, 1.976e6)  # N.m/rad
SIZES = {"bore": 0.105, "r": 0.0685, "L": 0.207, "m": 2.521, "masses": "excitation"}
COUPLING = {"c": 4e4, "eta": 0.15, "w_loss": 150.0}
RATED = 1000.0  # N.m


class Shaft(LossSpring):
    """A shaft with its nominal torsional stress."""

    d: lp.Param = lp.param("m", "diameter", 0.085, above=0)
    stress: lp.Var = lp.var("Pa", "nominal torsional stress")

    def equations(self):
        yield from super().equations()
        yield self.stress == 16 * self.tau_c / (np.pi * self.d**3)


def genset(misfire="none", load=-RATED):
    degrees, megapascals = np.loadtxt(TABLE, delimiter=",", skiprows=1).T
    pressure = list(zip(np.radians(degrees), 1e6 * megapascals, strict=True))
    model = lp.compose(
        mass=[Inertia(J=J) for J in INERTIAS],
        shaft=[Shaft(c=c, eta=0.035, w_loss=1300.0) for c in STIFFNESSES],
        cylinder=[
            Cylinder(pressure=pressure, misfire=f, phase=2 * np.pi / 3 * p, **SIZES)
            for f, p in zip([misfire, *5 * ["none"]], POSITIONS, strict=True)
        ],
        oil=[Damper(d=0.2) for _ in POSITIONS],
        block=[Fixed() for _ in POSITIONS],
        coupling=LossSpring(**COUPLING),
        alternator=Inertia(J=6.0),
        load=Torque(tau=load),
        connections=lambda m: [
            *lp.chain(*(x for pair in zip(m.mass, m.shaft, strict=False) for x in pair), m.mass[8]),
            *lp.chain(m.mass[8], m.coupling, m.alternator, m.load),
            *(lp.connect(m.cylinder[i].flange, m.mass[i + 2].flange_a) for i in range(6)),
            *(c for i in range(6) for c in lp.chain(m.block[i], m.oil[i], m.mass[i + 2])),
        ],
    )
    return lp.assemble(model)


def report(path, parameters=None):
    of = ["coupling.tau", "coupling.phi_rel", "shaft[7].stress", "alternator.phi"]
    speeds = np.linspace(600, 1600, 41) * RPM
    options = {"speeds": speeds, "of": of, "over": "mass[8].phi", "turns": 2, "free": "load.tau"}
    responses, heat = {}, {}
    for case, misfire in (("all cylinders fire", "none"), ("cylinder 1 misfires", "compression")):
        found = order_response(genset(misfire), **options, parameters=parameters)
        twist = np.abs(found["coupling.phi_rel"]) ** 2 @ found.orders
        heat[case] = {"coupling": 0.5 * COUPLING["c"] * COUPLING["eta"] * twist * speeds}
        responses[case] = found
    swing = lp.ops.exp((0.2 - lp.time) / 0.05) * lp.ops.sin(100 * np.pi * (lp.time - 0.2))
    failing = genset(load=-RATED * (1 + 5 * lp.ops.where(lp.time > 0.2, swing, 0.0)))
    start = lp.start_point(failing, start={"mass[8].w": 1500 * RPM}, together=True)
    runs = {"Short circuit of the alternator": lp.simulate(failing, until=0.5, start=start)}
    limits = [
        Limit("coupling.tau", "1.5 kN.m", "vibratory torque", source="maker", speeds=(150, 165)),
        Limit("shaft[7].stress", "40 MPa", "crankshaft", measure="sum", source="rules of hall 3"),
    ]
    peak = [Limit("coupling.tau", "5 kN.m", "largest torque", source="maker")]
    limited = {**dict.fromkeys(responses, limits), **dict.fromkeys(runs, peak)}
    more = {"title": "Genset", "about": {"Plant": "Hall 3"}, "heat": heat, "runs": runs}
    more["operation"] = ("1450 rpm", "1550 rpm")
    return lp.drawing.torsional_report(responses, path, limits=limited, **more)
