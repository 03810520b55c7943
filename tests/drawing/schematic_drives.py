"""Drives whose schematics are examined: chains, branches, loops, composites, circuits, signals."""

import re
from operator import attrgetter
from pathlib import Path

from drive_chains import in_turn
from genset import genset
from linkages import FourBar
from random_drives import RandomDrive

import lumped as lp
from lumped import components as lib
from lumped.components import IdealGear, Inertia, SpringDamper
from lumped.language.quantity import Input
from lumped.models import MACHINES, machine

DATA = Path(__file__).parents[1] / "data" / "schematics"


class Gearbox(lp.Component):
    """Two stages of gears in a housing."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    pinion: Inertia = Inertia()
    first: IdealGear = IdealGear()
    shaft: SpringDamper = SpringDamper()
    wheel: Inertia = Inertia()

    def connections(self):
        yield lp.connect(self.flange_a, self.pinion.flange_a)
        yield from lp.chain(self.pinion, self.first, self.shaft, self.wheel)
        yield lp.connect(self.wheel.flange_b, self.flange_b)


OWN = {"FourBar": FourBar, "Gearbox": Gearbox}


def drive(text: str) -> lp.Component:
    """Parts and what is joined, a line each: ``a > b > c`` for chains, ``a.p = b.p`` for ports.

    A part has its class, of the library or of `OWN`, where it is first named, ``motor:Inertia``,
    or, if parts are declared in another order, in a first line, ``declared: motor Inertia, ...``.
    It has no values; its inputs are 0 unless joined.
    """
    declared, joints = re.fullmatch(r"(?:declared: (.*)\n)?((?:.|\n)*)", text).groups("")
    named = [pair.split() for pair in declared.split(",") if pair]
    named += re.findall(r"(\w+):((?:\w+\.)?[A-Z]\w*)", joints)
    joints = re.sub(r":(\w+\.)?[A-Z]\w*", "", joints)
    ends = {name.strip() for line in joints.splitlines() for name in line.split("=")}

    def made(name: str, kind: str) -> lp.Component:
        cls = OWN[kind] if kind in OWN else attrgetter(kind)(lib)
        quantities = cls._quantities.items()
        inputs = [key for key, quantity in quantities if isinstance(quantity, Input)]
        return cls(**{key: 0.0 for key in inputs if f"{name}.{key}" not in ends})

    def connections(model: lp.Component):
        for line in joints.splitlines():
            ends = [attrgetter(name.strip())(model) for name in re.split("[>=]", line)]
            yield from lp.chain(*ends) if ">" in line else [lp.connect(*ends)]

    return lp.compose(**{name: made(name, kind) for name, kind in named}, connections=connections)


def drives(kind: str) -> dict[str, lp.Component]:
    """Those of a file, by the names above them."""
    blocks = (DATA / f"{kind}.txt").read_text(encoding="utf-8").strip().split("\n\n")
    pairs = (block.removeprefix("[").split("]\n", 1) for block in blocks)
    return {name: drive(text) for name, text in pairs}


def long_chain(count: int) -> lp.Component:
    """So many bodies with shafts between them."""
    return in_turn(
        bodies=[Inertia() for _ in range(count)], springs=[SpringDamper() for _ in range(count - 1)]
    )


CHAINS = drives("chains")
"""Each part joined to the next, flange b to flange a."""

BRANCHED = {
    "folded chain": long_chain(18),
    "genset": genset().structure.tree.model,
    **drives("branched"),
}
"""Chains with branches, loops and second chains."""

DRIVES = {
    **CHAINS,
    **BRANCHED,
    **drives("controlled"),  # with circuits and signals
    **{name: machine(name).model() for name in MACHINES},
    **{f"random drive {seed}": RandomDrive(seed).model() for seed in (1, 4, 7, 11)},
}
