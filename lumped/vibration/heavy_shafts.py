"""Shafts that have their inertia at both flanges, by their own equations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lumped.compiler.system import System
from lumped.flattening.flatten import Group
from lumped.flattening.template import VARYING, Residual
from lumped.timeloop.result import OperatingPoint

__all__ = ["HeavyShaft", "heavy_shafts"]

Real = NDArray[np.float64]

_FITS = 1e-9
"""Share of a dynamic stiffness that may remain unexplained."""


class HeavyShaft(NamedTuple):
    """A stiffness between two flanges, each with an inertia.

    Attributes
    ----------
    flanges : tuple of str
        Names of its ports.
    J : tuple of float
        Moments of inertia at these, kg.m2.
    c : float
        Stiffness between them, N.m/rad.
    """

    flanges: tuple[str, str]
    J: tuple[float, float]
    c: float


def heavy_shafts(system: System, point: OperatingPoint) -> dict[str, HeavyShaft]:
    """All components with the torques ``J_i der2(phi_i) + c (phi_i - phi_j)``, by their paths.

    What two flanges do to each other alone tells this, whatever the drive around them; a damper in
    parallel does not count. Equations that are not linear with constant coefficients are left out.
    """
    flat, found = system.structure.flat, {}
    parameters = flat.parameters.all(point.theta)
    tree = flat.tree
    for group in flat.groups:
        layout = tree.instances[group.nodes[0]].layout
        ports = layout.ports
        units = [layout.quantities[i].unit for i in range(2 * len(ports))]
        residuals = [group.template.residual(e) for e in range(group.template.count)]
        if units != ["rad", "N.m"] * 2 or any((r.kinds == VARYING).any() for r in residuals):
            continue
        for i, number in enumerate(group.nodes):
            terms = _terms(group, residuals, i, tree.instances[number].first_unknown, parameters)
            if terms is None:
                break
            names = tuple(str(port) for port in ports)
            found[tree.instances[number].path] = HeavyShaft((names[0], names[1]), *terms)
    return found


def _terms(
    group: Group, residuals: list[Residual], i: int, first: int, parameters: Real
) -> tuple[tuple[float, float], float] | None:
    """Inertias and stiffness of an instance, or None if it is nothing of the kind."""
    unknowns = group.unknowns[i].tolist()
    if len(unknowns) != len(residuals) + 2 or any(first + k not in unknowns for k in range(4)):
        return None
    a, torque_a, b, torque_b = (unknowns.index(first + k) for k in range(4))
    others = [k for k in range(len(unknowns)) if k not in (a, b)]
    wanted = [others.index(torque_a), others.index(torque_b)]
    own, modes = parameters[group.parameters[i]], np.zeros(len(group.template.modes))
    numbers = [
        np.asarray(each.coefficients(np.zeros(len(each.locals)), own, 0.0, modes)).ravel()
        for each in residuals
    ]

    def dynamic(s: float) -> Real:
        """Torques at the flanges for each angle of these that varies as exp(s t)."""
        matrix = np.zeros((len(residuals), len(unknowns)))
        for row, each, values in zip(matrix, residuals, numbers, strict=True):
            np.add.at(row, each.locals, values * s**each.orders)
        found: Real = np.linalg.solve(matrix[:, others], -matrix[:, [a, b]])[wanted]
        return found

    try:
        c = dynamic(0.0)
        s = 1.0
        for _ in range(2):  # the second time both have the same size
            J = np.diag(0.5 * (dynamic(s) + dynamic(-s)) - c) / s**2
            if not (J > 0).all() or not c[0, 0] > 0:
                return None
            s = float(np.sqrt(c[0, 0] / J.max()))
        apart = np.array([[1.0, -1.0], [-1.0, 1.0]])
        even = 0.5 * (dynamic(2 * s) + dynamic(-2 * s))
        missed = even - c[0, 0] * apart - 4 * s**2 * np.diag(J)
    except np.linalg.LinAlgError:
        return None
    if np.abs(missed).max() > _FITS * np.abs(even).max():
        return None
    return (float(J[0]), float(J[1])), float(c[0, 0])
