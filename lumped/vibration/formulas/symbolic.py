"""Matrices, polynomial, frequencies, responses and slopes of a linear drive as formulas."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError
from lumped.support.arguments import checked
from lumped.vibration.formulas.formula import Formula, drop_unused
from lumped.vibration.formulas.matrices import Matrices, SecondOrder, convert_named, state_matrix
from lumped.vibration.formulas.names import Names, free_name
from lumped.vibration.formulas.polynomial import (
    closed_roots,
    expanded,
    first_order_entries,
    numerator,
    polynomial_of,
    second_order_entries,
)
from lumped.vibration.formulas.to_sympy import by_squares, exact, load_sympy, shortest
from lumped.vibration.natural.symbolic import find_expression

_MOST = 4
_ZERO = 1e-6
"""Share of the largest eigenvalue below which one is that of a rigid motion."""


@checked
def formula(system: System, of: Name, *, parameters: Changes | None = None) -> Formula:
    """A quantity of a system as a formula of states, parameters and time.

    Parameters
    ----------
    system : System
        From `assemble`.
    of : str or reference
        A quantity, an expression of some, or the derivative of a state as ``der(name)``.
    parameters : mapping of name to float, optional
        Parameters that are given as numbers.

    Returns
    -------
    Formula

    Raises
    ------
    UnknownNameError
        If there is no such quantity, or it needs a state that was left out.
    OptionError
        If it depends on modes (what sticks, which branch holds), on a table, or is found by
        iteration; or SymPy is not installed.
    """
    numbers = dict(zip(system.parameters, system.theta(parameters).tolist(), strict=True))
    fixed = {
        load_sympy().Symbol(system.key(name)): exact(numbers[system.key(name)])
        for name in parameters or {}
    }
    found = convert_named(system, find_expression(system, of))[0, 0].subs(fixed)
    return Formula(str(system.key(of)), shortest(found), (), numbers)


@dataclass(frozen=True, eq=False)
class SymbolicDrive:
    """A linear drive in formulas; print them, or take `Formula.latex`, `code`, `casadi`.

    Attributes
    ----------
    system : System
        What it is.
    states : tuple of str
        States of `A`; those on which nothing depends are left out.
    coordinates : tuple of str
        Those of `M`, `C` and `K`: what has these speeds.
    """

    system: System
    states: tuple[str, ...]
    coordinates: tuple[str, ...]
    _matrices: Matrices = field(repr=False)

    @cached_property
    def A(self) -> Formula:
        """State matrix, ``der(x) = A x``."""
        return self._formula("A", self._matrices.A.applyfunc(shortest))

    @cached_property
    def M(self) -> Formula:
        """Mass matrix, by the kinetic energy that components state (``stored``)."""
        return self._formula("M", self._matrices.motion[0])

    @cached_property
    def C(self) -> Formula:
        """Damping matrix, ``M q'' + C q' + K q = 0``."""
        return self._formula("C", self._matrices.motion[1])

    @cached_property
    def K(self) -> Formula:
        """Stiffness matrix."""
        return self._formula("K", self._matrices.motion[2])

    @cached_property
    def polynomial(self) -> Formula:
        """Characteristic polynomial: in lambda = omega^2 without damping, else in s.

        Roots at zero, of motions without deformation, may be left out. Long ones are recurrences
        of named parts, each a minor.
        """
        names, value = Names(self.system.parameters), load_sympy().Integer(1)
        for own, order in self._parts:
            if self._undamped and order is None:
                continue  # turns freely
            value *= self._one_polynomial(own, order, names)
        letter = "lambda" if self._undamped else "s"
        return self._formula(f"p({letter})", value, names)

    @cached_property
    def frequencies(self) -> tuple[Formula, ...]:
        """Natural frequencies, rad/s, ascending at the values of the model.

        Those of separate parts of the drive may pass each other at other values.

        Raises
        ------
        OptionError
            If a part of the drive has more than four modes, or more than one with damping; then
            `polynomial` is what holds, and `slope` tells how its roots move.
        """
        sympy, x, found = load_sympy(), self._variable, []
        names = Names(self.system.parameters)
        for own, order in self._parts:
            if len(own) == 1:
                continue
            if order is None or (order.G.rows > 1 and not order.H.is_zero_matrix):
                raise OptionError(
                    f"{self.system.name}: with damping, natural frequencies have no short formula. "
                    "Give the damping as zero, parameters={name: 0}, or take polynomial and slope."
                )
            G = order.G
            if G.rows > _MOST:
                raise OptionError(
                    f"{self.system.name}: {G.rows} modes in one part of the drive; formulas "
                    f"are given for up to {_MOST}. polynomial is exact for all, slope too."
                )
            if G.rows == 1:
                found.append(sympy.sqrt(shortest(G[0, 0])))
                continue
            lam = sympy.Symbol("lambda") if x != sympy.Symbol("lambda") else x
            entries = second_order_entries(None, G, lam, names, alone=True)
            value = expanded(entries, G.rows)
            found += [sympy.sqrt(r) for r in closed_roots(value, G.det(), lam, names)]
        every = [self._formula("omega", value, names) for value in found]
        every.sort(key=lambda one: float(np.real(one())))
        return tuple(
            Formula(f"omega_{k}", one.expression, one.parts, one.numbers)
            for k, one in enumerate(every, 1)
        )

    @checked
    def transfer(self, input: Name, output: Name) -> Formula:
        """Transfer function from an input to an output, of the variable ``s``.

        Parameters
        ----------
        input : name
            A parameter, such as a torque.
        output : name
            A quantity.

        Returns
        -------
        Formula

        Raises
        ------
        UnknownNameError
            If a name does not exist.
        OptionError
            If the output does not depend on the input, or not linearly.
        """
        sympy, names = load_sympy(), Names(self.system.parameters)
        s = sympy.Symbol("s")
        B, C, D = self._matrices.inputs_outputs([input], [output])
        A = self._matrices.A
        name = f"{self.system.key(output)} / {self.system.key(input)}"
        total = D[0, 0]
        for own, order in self._parts:
            if B.extract(own, [0]).is_zero_matrix or C.extract([0], own).is_zero_matrix:
                continue
            if order is None or not B.extract(order.t, [0]).is_zero_matrix:
                b, c, n, direct = B.extract(own, [0]), C.extract([0], own), len(own), 0
                a = A.extract(own, own)
                facing, every = (first_order_entries(a, s, names, alone=k) for k in (True, False))
            else:
                b, n = order.act(B), order.G.rows
                c, direct = order.read(B, C, s)
                facing, every = (
                    second_order_entries(order.H, order.G, s, names, alone=k) for k in (True, False)
                )
            below = polynomial_of(facing, n, s, names)
            ends = [[shortest(value) for value in each] for each in (c, b)]
            above = numerator(every, n, (ends[0], ends[1]), names)
            total += direct + sympy.factor_terms(above) / below
        if total == 0:
            raise OptionError(f"{self.system.name}: {name} is zero.")
        return self._formula(name, total, names)

    @checked
    def slope(self, parameter: Name) -> Formula:
        """Derivative of a natural frequency (of an eigenvalue ``s`` if damped) by a parameter.

        It holds for each mode, by its own frequency and shape: ``phi.name`` are the amplitudes of
        `coordinates`, as `mode` gives them in numbers; ``psi.name`` those of the left vector, if
        the matrices are not symmetric. Without damping it is
        ``phi^T (dK/dp - omega^2 dM/dp) phi / (2 omega phi^T M phi)``.

        Parameters
        ----------
        parameter : name
            By what.

        Returns
        -------
        Formula

        Raises
        ------
        OptionError
            If M, C and K do not say all.
        UnknownNameError
            If there is no such parameter.
        """
        sympy = load_sympy()
        self.system.places([self.system.key(parameter)])
        p = sympy.Symbol(self.system.key(parameter))
        M, C, K = self._matrices.motion
        right = sympy.Matrix([sympy.Symbol(f"phi.{name}") for name in self.coordinates])
        is_symmetric = all(m == m.T for m in (M, C, K))
        left = right
        if not is_symmetric:
            left = sympy.Matrix([sympy.Symbol(f"psi.{name}") for name in self.coordinates])
        m, loss = (sympy.Symbol(free_name(x, self.system.parameters)) for x in ("m", "l"))
        w, s = sympy.Symbol("omega"), sympy.Symbol("s")

        def form(matrix: Any) -> Any:
            return by_squares((left.T * matrix * right)[0, 0])

        mass = form(M)
        if self._undamped:
            above = form(K.diff(p)) - w**2 * form(M.diff(p))
            value, parts = above / (2 * w * m), [(m, mass)]
        else:
            above = form(K.diff(p)) + s * form(C.diff(p)) + s**2 * form(M.diff(p))
            value, parts = -above / (2 * s * m + loss), [(m, mass), (loss, form(C))]
        name = f"d {'omega' if self._undamped else 's'} / d {self.system.key(parameter)}"
        return Formula(name, value, drop_unused(value, parts), self._matrices.numbers)

    @checked
    def mode(self, mode: int, *, parameters: Changes | None = None) -> dict[str, complex]:
        """Numbers of a mode for the formulas of `slope`.

        Parameters
        ----------
        mode : int
            Its number by natural frequency, from 0.
        parameters : mapping of name to float, optional
            Parameters to change.

        Returns
        -------
        dict of str to number
            ``omega`` or ``s``, and the amplitudes of all coordinates; parameters that change.

        Raises
        ------
        OptionError
            If there is no such mode.
        """
        theta = self.system.theta(parameters).tolist()
        numbers = dict(zip(self.system.parameters, theta, strict=True))
        M, C, K = (
            np.array(each({k: numbers[k] for k in each.names}), dtype=float)
            for each in (self.M, self.C, self.K)
        )
        n, keys = len(M), [self.system.key(name) for name in parameters or {}]
        changed = {key: numbers[key] for key in keys}
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, np.hstack([K, C]))]])
        values, left, right = scipy.linalg.eig(A, left=True)
        size = np.abs(values)
        kept = np.flatnonzero(values.imag > _ZERO * size.max())
        kept = kept[np.argsort(size[kept], kind="stable")]
        if not 0 <= mode < len(kept):
            raise OptionError(f"{self.system.name}: there is no mode {mode}; {len(kept)} in all.")
        k = kept[mode]
        value, shape = values[k], right[:n, k]
        shape = shape / shape[np.abs(shape).argmax()]
        other = np.linalg.solve(M.T, left[n:, k].conj())
        if self._undamped:
            known: dict[str, complex] = {"omega": float(value.imag)}
            shape, other = shape.real, other.real
        else:
            known = {"s": complex(value)}
        known |= {f"phi.{x}": v for x, v in zip(self.coordinates, shape.tolist(), strict=True)}
        if not all(m == m.T for m in self._matrices.motion):
            known |= {f"psi.{x}": v for x, v in zip(self.coordinates, other.tolist(), strict=True)}
        return {**changed, **known}

    def __repr__(self) -> str:
        kind = "undamped" if self._undamped else "damped"
        return (
            f"{self.system.name}: {kind}, {len(self.states)} states, parts of the drive: "
            f"{len(self._matrices.parts)}\n{self.polynomial}"
        )

    @cached_property
    def _parts(self) -> list[tuple[list[int], SecondOrder | None]]:
        """States of each part of the drive, and its equations of second order, if any."""
        return [(own, self._matrices.second_order(own)) for own in self._matrices.parts]

    @cached_property
    def _undamped(self) -> bool:
        return all(
            order.H.is_zero_matrix
            if order
            else len(own) == 1 and self._matrices.A[own[0], own[0]] == 0
            for own, order in self._parts
        )

    @property
    def _variable(self) -> Any:
        return load_sympy().Symbol("lambda" if self._undamped else "s")

    def _one_polynomial(self, own: list[int], order: SecondOrder | None, names: Names) -> Any:
        x = self._variable
        if order is None:
            entries = first_order_entries(self._matrices.A.extract(own, own), x, names, alone=True)
            return polynomial_of(entries, len(own), x, names)
        H = None if self._undamped else order.H
        entries = second_order_entries(H, order.G, x, names, alone=True)
        return polynomial_of(entries, order.G.rows, x, names)

    def _formula(self, name: str, value: Any, names: Names | None = None) -> Formula:
        if names is None:
            return Formula(name, value, (), self._matrices.numbers)
        parts = drop_unused(value, names.parts)
        new = names.count_anew([part for part, _ in parts])
        counted = tuple((new[part], inner.xreplace(new)) for part, inner in parts)
        return Formula(name, value.xreplace(new), counted, self._matrices.numbers)


@checked
def symbolic(system: System, *, parameters: Changes | None = None) -> SymbolicDrive:
    """Matrices, polynomial, frequencies, responses and slopes of a linear drive as formulas.

    Parameters that are zero in the model stay zero, all others are symbols, unless they are given.

    Parameters
    ----------
    system : System
        From `assemble`.
    parameters : mapping of name to float, optional
        Parameters that are given as numbers: such as ``{"shaft.d": 0}``, which leaves damping out.

    Returns
    -------
    SymbolicDrive

    Raises
    ------
    OptionError
        If the drive is not linear, or SymPy is not installed.
    """
    found = state_matrix(system, parameters)
    names = [found.states[i] for i in found.speeds]
    short = tuple(name.rpartition(".")[0] or name for name in names)
    return SymbolicDrive(system, tuple(found.states), short, found)
