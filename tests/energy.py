"""Energy audit of a run: what was supplied, stored, turned into heat and lost in impacts."""

from dataclasses import dataclass

import lumped as lp
from lumped.components import (
    Fixed,
    IdealGear,
    Inertia,
    Spring,
    SpringDamper,
    translation,
)
from lumped.language.switch import Hold

ELASTIC = (Spring, SpringDamper, translation.Spring, translation.SpringDamper)
WITHOUT_POWER = (IdealGear, Fixed, translation.Fixed)


def heat(part):
    """Power that a part turns into heat, impacts apart.

    A reaction that can be an impulse turns nothing into heat but by its law of sliding.
    """
    holds = [item for item in part.equations() if isinstance(item, Hold)]
    if holds:
        forces = [h.forward if h.impulsive else h.reaction for h in holds]
        return sum((f * h.speed for f, h in zip(forces, holds, strict=True)), start=lp.time * 0)
    if "d" in part._quantities:
        rate = part.w_rel if "w_rel" in part._quantities else part.v_rel
        return part.d * rate**2
    return lp.time * 0


def work(part):
    """Power that a source puts in, at its ports."""
    total = lp.time * 0
    for name in part._ports:
        port = getattr(part, name)
        if isinstance(part._ports[name], lp.Flange):
            total -= port.tau * lp.der(port.phi)
        else:
            total -= port.f * lp.der(port.s)
    return total


def is_source(part):
    """Whether a part drives or loads: it has one flange and rests on nothing else."""
    return "flange" in part._ports and not isinstance(part, WITHOUT_POWER)


def stored(part, name, run):
    """Energy in a part at the output times."""
    if isinstance(part, ELASTIC):
        kind = "phi_rel" if isinstance(part, Spring | SpringDamper) else "s_rel"
        rest = part._values.get(f"{kind}0", 0.0)
        return 0.5 * part._values["c"] * (run[f"{name}.{kind}"] - rest) ** 2
    if isinstance(part, Inertia):
        return 0.5 * part._values["J"] * run[f"{name}.w"] ** 2
    if "m" in part._quantities:
        return 0.5 * part._values["m"] * run[f"{name}.v"] ** 2
    return 0.0 * run.t


def audited(model):
    """The model as part `rig` of one that integrates the powers of its parts."""

    def equations(self):
        parts = [part for _, part in self.rig._children()]
        yield lp.der(self.heat) == sum(map(heat, parts), start=lp.time * 0)
        yield lp.der(self.work) == sum(map(work, filter(is_source, parts)), start=lp.time * 0)

    members = {
        "rig": model,
        "heat": lp.var("J", "heat", state="always"),
        "work": lp.var("J", "energy supplied", state="always"),
        "equations": equations,
    }
    return type("Audited", (lp.Component,), members)()


@dataclass(frozen=True)
class Balance:
    """Energies of a run, J: supplied - (stored + heat + impacts), and the largest of them."""

    error: float
    turnover: float


def audit(model, **options):
    """Run a model and balance its energies."""
    system = lp.assemble(audited(model), keep=["heat", "work"])
    if "start" in options:
        options["start"] = {f"rig.{name}": value for name, value in options["start"].items()}
    run = lp.simulate(system, **options)
    energy = sum(stored(part, f"rig.{name}", run) for name, part in model._children())
    impacts = sum(event.loss for event in run.events)
    parts = [run["work"][-1], energy[-1] - energy[0], run["heat"][-1], impacts]
    error = parts[0] - sum(parts[1:])
    turnover = max(abs(run["work"]).max(), energy.max(), run["heat"][-1])
    return Balance(float(error), float(turnover))
