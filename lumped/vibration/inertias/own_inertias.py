"""Inertias that components tell by their own equations, whatever the drive around them."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.flattening.flat_model import Group
from lumped.flattening.residual import VARYING, Residual
from lumped.support.arrays import Real
from lumped.timeloop.results.operating_point import OperatingPoint

_FITS = 1e-9
"""Share of a dynamic stiffness that may remain unexplained."""
_FAST = 1e3
"""Rate of exponentials by which an inertia on one shaft is found, 1/s."""
_TURNS, _ANGLES = 2, 64
"""Turns after which a component repeats, and angles of which the mean is taken."""
_STEPS = 20


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

    A damper in parallel does not count. Equations that are not linear with constant coefficients
    are left out.
    """
    found = {}
    for group in _with_flanges(system, 2):
        template = group.template
        if any((template.residual(e).kinds == VARYING).any() for e in range(template.count)):
            continue
        for i, number in enumerate(group.nodes):
            terms = _Own(system, point, group, i).shaft()
            if terms is None:
                break
            node = system.structure.tree.instances[number]
            a, b = map(str, node.layout.ports)
            found[node.path] = HeavyShaft((a, b), *terms)
    return found


def mean_inertias(system: System, point: OperatingPoint) -> dict[str, float]:
    """Means over the turns of the inertia of components on one shaft, by their paths, kg.m2.

    That of a crank drive is its mean ``J(phi)``. What depends on the angle alone, as gas pressures
    do, has no mean if it repeats.
    """
    found = {}
    for group in _with_flanges(system, 1):
        for i, number in enumerate(group.nodes):
            J = _Own(system, point, group, i).inertia()
            if J is None:
                break
            found[system.structure.tree.instances[number].path] = J
    return found


def _with_flanges(system: System, count: int) -> list[Group]:
    """Groups of components without parts that have so many flanges and no other port."""
    flat = system.structure.flat
    found = []
    for group in flat.groups:
        node = flat.tree.instances[group.nodes[0]]
        ports = 2 * len(node.layout.ports)
        units = [quantity.unit for quantity in node.layout.quantities[:ports]]
        is_closed = len(group.unknowns[0]) == group.template.count + count
        known = set(group.unknowns[0].tolist())
        is_whole = {node.first_unknown + k for k in range(ports)} <= known
        if units == ["rad", "N.m"] * count and not node.children and is_closed and is_whole:
            found.append(group)
    return found


class _Own:
    """The equations of one component: flange angles given, all else follows."""

    def __init__(self, system: System, point: OperatingPoint, group: Group, i: int) -> None:
        flat = system.structure.flat
        first = flat.tree.instances[group.nodes[i]].first_unknown
        unknowns = group.unknowns[i].tolist()
        count = len(unknowns) - group.template.count
        self.residuals = [group.template.residual(e) for e in range(group.template.count)]
        self.angles = [unknowns.index(first + 2 * k) for k in range(count)]
        self.others = [k for k in range(len(unknowns)) if k not in self.angles]
        self.torques = [self.others.index(unknowns.index(first + 2 * k + 1)) for k in range(count)]
        width = len(group.template.modes)
        modes = point.settings[group.first_mode + i * width :][:width]
        parameters = flat.parameters.all(point.theta)[group.parameters[i]]
        self.rest = parameters, point.time, modes

    def shaft(self) -> tuple[tuple[float, float], float] | None:
        """Inertias and stiffness, or None if it is nothing of the kind."""
        slopes = self._slopes(np.zeros((1, len(self.angles) + len(self.others))))
        try:
            (c,) = self._even(slopes, 0.0)
            s = 1.0
            for _ in range(2):  # the second time both have the same size
                J = np.diag(self._even(slopes, s)[0] - c) / s**2
                if not (J > 0).all() or not c[0, 0] > 0:
                    return None
                s = float(np.sqrt(c[0, 0] / J.max()))
            (even,) = self._even(slopes, 2 * s)
        except np.linalg.LinAlgError:
            return None
        apart = np.array([[1.0, -1.0], [-1.0, 1.0]])
        missed = even - c[0, 0] * apart - 4 * s**2 * np.diag(J)
        if np.abs(missed).max() > _FITS * np.abs(even).max():
            return None
        return (float(J[0]), float(J[1])), float(c[0, 0])

    def inertia(self) -> float | None:
        """Mean inertia over the turns, or None if there is none, or it does not repeat."""
        try:
            at = self._at_rest(2 * np.pi * _TURNS * np.arange(_ANGLES + 1) / _ANGLES)
            slopes = self._slopes(at)
            c, near, far = (self._even(slopes, s)[:, 0, 0] for s in (0.0, _FAST, 2 * _FAST))
        except np.linalg.LinAlgError:
            return None
        J, again = (near - c) / _FAST**2, (far - c) / (2 * _FAST) ** 2
        torques = at[:, self.others[self.torques[0]]]
        is_inertia = (np.abs(again - J) <= _FITS * (np.abs(J) + np.abs(c) / _FAST**2)).all()
        repeats = abs(torques[-1] - torques[0]) <= _FITS * np.ptp(torques)
        mean = float(J[:-1].mean())
        return mean if is_inertia and repeats and mean > 0 else None

    def _at_rest(self, angles: Real) -> Real:
        """All unknowns where the flange stands at angles, shape (angles, unknowns)."""
        at = np.zeros((len(angles), 1 + len(self.others)))
        at[:, self.angles[0]] = angles
        for _ in range(_STEPS):
            missing = np.hstack([self._evaluate(each.value, each, at) for each in self.residuals])
            matrix = self._matrix(self._slopes(at), 0.0)[:, :, self.others]
            step = np.linalg.solve(matrix, -missing[..., None])[..., 0]
            at[:, self.others] += step
            if np.abs(step).max() <= _FITS * (1 + np.abs(at).max()):
                return at
        raise np.linalg.LinAlgError

    def _even(self, slopes: list[Real], s: float) -> Real:
        """Torques at the flanges for each angle of these that varies as exp(s t), its even part.

        The odd part is damping. Shape (points, flanges, flanges).
        """
        found = []
        for sign in (1.0, -1.0):
            matrix = self._matrix(slopes, sign * s)
            solved = np.linalg.solve(matrix[:, :, self.others], -matrix[:, :, self.angles])
            found.append(solved[:, self.torques])
        return 0.5 * (found[0] + found[1])

    def _matrix(self, slopes: list[Real], s: float) -> Real:
        """Coefficients of all unknowns in all equations, shape (points, equations, unknowns)."""
        count = len(self.angles) + len(self.others)
        matrix = np.zeros((len(slopes[0]), len(slopes), count))
        for e, (each, values) in enumerate(zip(self.residuals, slopes, strict=True)):
            for column, value in zip(each.locals, (values * s**each.orders).T, strict=True):
                matrix[:, e, column] += value
        return matrix

    def _slopes(self, at: Real) -> list[Real]:
        """Partial derivatives of each equation at points, shapes (points, symbols)."""
        return [self._evaluate(each.coefficients, each, at) for each in self.residuals]

    def _evaluate(self, function: ca.Function, each: Residual, at: Real) -> Real:
        """A function of an equation where nothing moves, at points."""
        values = np.where(each.orders == 0, at[:, each.locals], 0.0)
        parameters, time, modes = self.rest
        rest = [np.tile(part, (len(at), 1)).T for part in (parameters, [time], modes)]
        return np.asarray(function(values.T, *rest)).reshape(-1, len(at)).T
