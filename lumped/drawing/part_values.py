"""What schematics tell of parts: an inertia, a stiffness, a ratio, the torque of a clutch."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.flattening.tree import Instance
from lumped.language.expression import Expr, Ref
from lumped.language.lowering import lower
from lumped.support.display_units import Units, display
from lumped.support.text_table import number

_PREFIXES = ((1e9, 1e9, "G"), (1e6, 1e6, "M"), (1e4, 1e3, "k"))
"""From which size on forces and torques are told in larger units."""


class PartValue(NamedTuple):
    """A number that is told of a part.

    Parameters
    ----------
    head : str
        Words before it.
    unit : str
        SI unit.
    value : SX
        Of the free parameters of the system.
    """

    head: str
    unit: str
    value: ca.SX


def find_part_values(system: System) -> dict[str, PartValue]:
    """What each part without parts is rated at; else its first parameter that is not zero."""
    p, tree = system.structure.parameters, system.structure.tree
    numbers = dict(zip(p.names, p.all(p.defaults), strict=True))

    def leaf(ref: Expr, scope: Instance) -> ca.SX:
        assert isinstance(ref, Ref)
        owner = tree.find(ref.owner, scope)
        assert owner is not None
        return p.values[tree.parameter(owner.name(ref.name))]

    first: dict[str, PartValue] = {}
    for i, (name, declared) in enumerate(zip(p.names, p.declared, strict=True)):
        part, _, own = name.rpartition(".")
        if own != "peak" and numbers[name] and np.isfinite(numbers[name]):
            is_told = declared.unit.startswith(("N", "kg"))
            head = "" if is_told else f"{own.replace('ratio', 'i')} = "
            first.setdefault(part, PartValue(head, declared.unit, p.values[i]))
    found = {}
    for node in tree.instances:
        rated = None if node.children else node.component.rating()
        if rated is not None:
            unit, value = rated
            head = "i = " if unit == "1" else ""
            found[node.path] = PartValue(head, unit, lower(value, partial(leaf, scope=node)))
        elif not node.children and node.path in first:
            found[node.path] = first[node.path]
    return found


def part_texts(system: System, theta: np.ndarray, units: Units = None) -> dict[str, str]:
    """What is told of each part, for parameters or for the least and greatest of rows of them."""
    found = find_part_values(system)
    formula = ca.Function("f", [system.structure.parameters.theta], [_stack(found)])
    rows = np.array([formula(row).full()[:, 0] for row in np.atleast_2d(theta)])
    texts = {}
    ends_of = zip(rows.min(axis=0), rows.max(axis=0), strict=True)
    for (part, told), own in zip(found.items(), ends_of, strict=True):
        shown = display(part, told.unit, units)
        ends = (write_short(shown.value(float(x)), shown.unit) for x in own)
        texts[part] = told.head + " to ".join(dict.fromkeys(ends))
    return texts


def _stack(found: dict[str, PartValue]) -> ca.SX:
    return ca.vertcat(ca.SX(0, 1), *(told.value for told in found.values()))


def write_short(value: float, unit: str) -> str:
    """A value in three digits."""
    for least, factor, prefix in _PREFIXES if unit.startswith("N") else ():
        if abs(value) >= least:
            value, unit = value / factor, prefix + unit
            break
    text = number(float(number(value, 3)))
    return text if unit == "1" else f"{text} {unit}"


def find_powers(system: System, told: PartValue) -> dict[str, Any] | None:
    """Factor and powers of free parameters whose product a value is; None if it is no product."""
    theta, at = system.structure.parameters.theta, system.structure.parameters.defaults
    formula = ca.Function("f", [theta], [told.value, ca.jacobian(told.value, theta)])
    places = sorted(set(ca.jacobian_sparsity(told.value, theta).get_triplet()[1]))
    random = np.random.default_rng(0).uniform(0.5, 2.0, (3, len(at)))
    powers = []
    for point in random * np.where(at == 0, 1.0, at):
        value, slope = formula(point)
        powers.append([float(point[i] * slope[0, i] / value) for i in places])
    first = np.array(powers)
    if not np.allclose(first, first[0], rtol=0, atol=1e-9):
        return None
    exact = np.round(first[0], 9)
    factor = float(value) / float(np.prod(point[places] ** exact))
    pairs = [[int(i), float(k)] for i, k in zip(places, exact, strict=True)]
    return {"factor": factor, "powers": pairs}
