"""The genset of a fresh user: from its data to the printed report."""

from pathlib import Path

import numpy as np
from rows import assemble_rows

import lumped as lp
from lumped.components import ElasticCoupling, Engine, Inertia, Shaft, Solid, Torque, ViscousDamper
from lumped.vibration import Limit, order_response

TABLE = Path(__file__).parents[1] / "data/torsional/02_six_cylinder_crankshaft/pressure_curve.csv"
RPM = np.pi / 30
RATED = 1000.0  # N.m
ENGINE = {
    "cylinders": 6,
    "firing_order": (1, 5, 3, 6, 2, 4),
    "J": (0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487),  # kg.m2
    "c": (1.253e6, 1.253e6, 1.678e6, 1.253e6, 1.253e6),  # N.m/rad
    "d_shaft": 30.0,  # N.m.s/rad
    "d": 0.2,
    "masses": "excitation",
    "bore": 0.105,
    "r": 0.0685,
    "L": 0.207,
    "m": 2.521,
}
CATALOGUE = {  # torque N.m and stiffness N.m/rad, relative damping
    "stiffness": ((0, 2.5e4), (1000, 4e4), (2000, 6e4), (4000, 1.2e5), (12000, 4e5)),
    "psi": 0.95,
    "w_loss": 150.0,
}


def genset(misfire=(), load=-RATED):
    degrees, megapascals = np.loadtxt(TABLE, delimiter=",", skiprows=1).T
    pressure = list(zip(np.radians(degrees), 1e6 * megapascals, strict=True))
    return assemble_rows(
        "damper engine.front",
        "engine.rear flywheel coupling shaft alternator load",
        damper=ViscousDamper(J_ring=0.06, d=25.0),
        engine=Engine(pressure=pressure, misfire=dict(misfire), **ENGINE),
        flywheel=Inertia(J=2.075),
        coupling=ElasticCoupling(**CATALOGUE),
        shaft=Shaft(sections=[Solid(d=0.085, L=0.3)], material="steel"),
        alternator=Inertia(J=6.0),
        load=Torque(tau=load),
    )


def report(path, parameters=None):
    of = ["coupling.tau", "shaft.sections[0].stress"]
    speeds = np.linspace(700, 1600, 19) * RPM
    options = {"speeds": speeds, "of": of, "shaft": "flywheel.phi", "turns": 2, "free": "load.tau"}
    responses, heat = {}, {}
    for case, miss in (("all cylinders fire", {}), ("cylinder 1 misfires", {1: "compression"})):
        found = order_response(genset(miss), **options, parameters=parameters)
        powers = {"coupling": "coupling.power", "damper": "damper.power"}
        heat[case] = {name: found.mean_power(of).sum(axis=1) for name, of in powers.items()}
        responses[case] = found
    swing = lp.ops.exp((0.2 - lp.time) / 0.05) * lp.ops.sin(100 * np.pi * (lp.time - 0.2))
    failing = genset(load=-RATED * (1 + 5 * lp.ops.where(lp.time > 0.2, swing, 0.0)))
    start = lp.start_point(failing, start={"flywheel.w": 1500 * RPM}, together=True)
    runs = {"Short circuit of the alternator": lp.simulate(failing, until=0.5, start=start)}
    limits = [
        Limit("coupling.tau", "1.5 kN.m", "vibratory torque", source="maker", speeds=(150, 165)),
        Limit("shaft.sections[0].stress", "40 MPa", "shaft", measure="sum", source="rules"),
    ]
    peak = [Limit("coupling.tau", "5 kN.m", "largest torque", source="maker")]
    limited = {**dict.fromkeys(responses, limits), **dict.fromkeys(runs, peak)}
    more = {"title": "Genset", "about": {"Plant": "Hall 3"}, "heat": heat, "runs": runs}
    more["operation"] = ("1450 rpm", "1550 rpm")
    return lp.drawing.torsional_report(responses, path, limits=limited, **more)
