"""One result of each kind that has a picture."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped import functionals as fun
from lumped.components import Brake, Fixed, Inertia, SpringDamper, Torque


class Genset(lp.Component):
    """An engine that vibrates against a generator, and a brake that lets go after a while."""

    pulses: Torque = Torque(tau=5.0)
    engine: Inertia = Inertia(J=4.0)
    coupling: SpringDamper = SpringDamper(c=2e4, d=40.0)
    generator: Inertia = Inertia(J=9.0)
    shaft: SpringDamper = SpringDamper(c=5e3, d=10.0)
    end: Inertia = Inertia(J=0.5)
    brake: Brake = Brake(f_max=100.0, u=lp.ops.where(lp.time >= 0.1, 0.0, 1.0))

    def connections(self):
        drive = (self.pulses, self.engine, self.coupling, self.generator, self.shaft, self.end)
        yield from lp.chain(*drive)
        yield lp.connect(self.end.flange_b, self.brake.flange_a)


class Free(Genset):
    """The same without the brake."""

    brake: lp.Component = Inertia(J=0.1)


def held():
    return in_a_row(
        wall=Fixed(), spring=SpringDamper(c=200.0, d=1.0), body=Inertia(J=2.0), load=Torque(tau=8.0)
    )


def comparison(free):
    """A response of a somewhat softer shaft beside that of the model."""
    hertz = np.geomspace(1.0, 50.0, 60)
    ends = {"inputs": ["pulses.tau"], "outputs": ["end.w"], "hertz": hertz}
    softer = lp.frequency_response(free, **ends, parameters={"shaft.c": 4e3})
    return lp.vibration.compare_response(
        lp.frequency_response(free, **ends),
        output="end.w",
        input="pulses.tau",
        hertz=hertz,
        measured=softer["end.w", "pulses.tau"],
    )


def identified(still):
    t = np.linspace(0.0, 0.6, 61)
    start = {"body.w": 1.0}
    run = lp.simulate(still, until=0.6, grid=t, start=start, parameters={"spring.c": 240.0})
    vary = {"spring.c": (100.0, 400.0)}
    return lp.identify(still, vary=vary, t=t, measured={"body.w": run["body.w"]}, start=start)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    run = lp.simulate(lp.assemble(Genset()), until=0.3, grid=200)
    free = lp.assemble(Free())
    modes = lp.modes(free)
    orders = lp.vibration.order_response(
        free,
        excitations={"pulses.tau": {0.5: 150.0, 1.0: 100.0, 3.0: 750.0}},
        speeds=np.linspace(60.0, 180.0, 41),
        of=["coupling.tau", "engine.w"],
    )
    campbell = lp.campbell(
        free, speeds=np.linspace(0.0, 300.0, 7), orders={"unbalance": 1.0, "firing": 3.0}
    )
    turning = lp.simulate(
        lp.assemble(Free(), keep=["engine.phi"]),
        until=3.0,
        grid=2000,
        start={"engine.w": 40.0, "generator.w": 40.0},
    )
    still = lp.assemble(held())
    scene = {"until": 0.2, "start": {"body.w": 1.0}}
    limits = [
        lp.vibration.Limit("coupling.tau", "0.6 kN.m", "catalogue"),
        lp.vibration.Limit("engine.w", 100.0, "speed"),
    ]
    names = ("engine.phi", "generator.phi", "end.phi")
    return {
        "run": run,
        "file": lp.load(run.save(tmp_path_factory.mktemp("plots") / "run.npz")),
        "modes": modes,
        "response": lp.frequency_response(
            free, inputs=["pulses.tau"], outputs=["end.w"], hertz=np.geomspace(1.0, 50.0, 60)
        ),
        "campbell": campbell,
        "orders": orders,
        "tracks": lp.vibration.order_tracks(
            turning, "coupling.tau", shaft="engine.phi", turns=3, overlap=0.5, most=6.0
        ),
        "sums": lp.vibration.vector_sums(
            modes, {name: 2.0 * i for i, name in enumerate(names)}, orders=[0.5, 1.0, 1.5]
        ),
        "holzer": lp.vibration.mass_elastic(modes, shaft="engine.phi").holzer(0),
        "locus": lp.vibration.root_locus(still, along={"spring.d": np.linspace(1.0, 60.0, 9)}),
        "eigen": lp.vibration.eigen_sensitivity(modes),
        "point": lp.points.equilibrium_sensitivity(lp.equilibrium(still), of=["spring.tau"]),
        "gradient": lp.gradient(still, of=[fun.peak("spring.tau")], **scene),
        "forward": lp.sensitivity(still, of=["spring.tau"], by=["spring.c", "body.J"], **scene),
        "ensemble": lp.ensemble(
            still, over={"body.J": lp.uniform(1.0, 3.0)}, runs=50, seed=1,
            of={"peak": fun.peak("spring.tau")}, **scene,
        ),
        "precision": lp.simulation.work_precision(still, until=0.05, of=["spring.tau"]),
        "sizing": lp.simulation.sizing(
            run, of=("pulses.flange.tau", "engine.w"), rated=8.0, maximum=20.0
        ),
        "verdict": lp.vibration.verdict(orders, limits),
        "comparison": comparison(free),
        "identified": identified(still),
    }  # fmt: skip
