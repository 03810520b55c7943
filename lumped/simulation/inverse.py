"""Inverse dynamics: the drive that a prescribed motion needs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Unpack

import casadi as ca
import numpy as np

from lumped.compiler.structure import Name, Structure
from lumped.compiler.system import System
from lumped.errors import OptionError, SingularModelError, SolverError, nearest
from lumped.flattening.flatten import flatten
from lumped.flattening.tree import Tree, key_of
from lumped.language.declared import quantities_of, values_of
from lumped.language.expression import Expr, as_expr
from lumped.language.quantity import Input
from lumped.simulation.simulate import simulate
from lumped.support.arguments import checked
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run_options import Grid, RunOptions


@checked
def inverse(
    system: System,
    *,
    motion: Mapping[str, Expr | float] | Mapping[Name, Expr | float],
    drive: Name | Iterable[Name],
    until: float | str,
    grid: Grid = 500,
    rtol: float = 1e-6,
    **options: Unpack[RunOptions],
) -> Trajectory:
    """Torques, forces or voltages that bring about a prescribed motion.

    The input of each drive becomes an unknown, and each motion an equation in its place. Index
    reduction differentiates the motion as often as the drive needs: twice for rigid bodies, twice
    more for each spring between them. What the motion does not determine (another branch, a
    current, a damped twist) remains a state and is integrated from its start values. The motion
    holds from the time zero on; a drive that shall start from rest needs a motion that does.

    While a motion with dry friction stands still, nothing tells how friction shares the load with
    the drive: friction is taken as zero then, and the drive holds the load alone.

    Parameters
    ----------
    system : System
        From `assemble`.
    motion : mapping of name to expression or float
        What quantities of the model shall be: expressions of `lumped.time`, such as those of
        `lumped.profiles`, in the unit of the quantity. Any unknown will do: an angle, a speed, a
        twist, a torque.
    drive : name, or iterable of names
        Inputs that bring it about, as many as motions. Each is given to its instance
        (``Torque(tau=0)``); the value given does not count.
    until : float
        End, s.
    grid, rtol
        As for `simulate`.
    **options : RunOptions
        Of the run (see `RunOptions`).

    Returns
    -------
    Trajectory
        All quantities; its `system` is the model with the motions prescribed.

    Raises
    ------
    OptionError
        If there are not as many drives as motions, a drive is no input that is given to an
        instance, a motion is neither a number nor an expression, or a parameter is zero by which
        the inverted equations divide, such as the damping beside a stiffness.
    UnknownNameError
        If the model does not have a quantity.
    SingularModelError
        If the drives do not determine the motions: because they do not act on them, or only
        through friction, a clutch or play.
    StartError
        If start values contradict the motion.
    SolverError
        If the motion has a jump or kink that bodies would have to follow, or the drive loses its
        hold on the motion, as at a dead centre. Its `partial` holds the run up to there.
    """
    tree = system.structure.tree
    names: list[Name] = [drive] if isinstance(drive, str | Expr) else list(drive)
    drives = [_find_drive(tree, name) for name in names]
    motions = {
        system.key(name): _read_wanted(system, name, value) for name, value in motion.items()
    }
    if len(motions) != len(drives) or len(set(drives)) < len(drives) or not drives:
        raise OptionError(
            f"inverse: {len(motions)} motions ({', '.join(motions) or 'none'}) and {len(drives)} "
            f"drives ({', '.join(drives) or 'none'}); each motion needs a drive of its own."
        )
    try:
        flat = flatten(system.model, motions, frozenset(drives), tree.massless)
        inverted = System(Structure(flat, None, system.structure.recipe.kept))
        inverted.function(drives)  # refuses drives that nothing determines
    except SingularModelError as error:
        raise SingularModelError(
            f"{system.name}: {' and '.join(drives)} cannot bring about a prescribed "
            f"{' and '.join(motions)}. A drive must determine the motion at every instant: through "
            "rigid parts, springs and dampers it does; through friction, a clutch or play, or with "
            "dry friction behind a spring, it does not. With the motion prescribed in place of "
            f"the drive:\n{error}"
        ) from None
    zeros = inverted, inverted.theta(options.get("parameters")), drives
    try:
        run = simulate(inverted, until=until, grid=grid, rtol=rtol, **options)
    except SolverError:
        _refuse_zero_divisors(*zeros)
        raise
    for name in drives:
        bad = np.flatnonzero(~np.isfinite(run[name]))
        if len(bad):
            _refuse_zero_divisors(*zeros)
            end = float(run.t[bad[0]])
            raise SolverError(
                f"{system.name}: {name} = {run[name][bad[0]]} at t = {end:.9g} s: it has no hold "
                f"on {' and '.join(motions)} there, as at a dead centre. Choose a motion that "
                "avoids this point.",
                _cut(run, end),
            )
    return run


def _refuse_zero_divisors(inverted: System, theta: np.ndarray, drives: list[str]) -> None:
    """Refuse parameters that are zero and alone leave rates or drives without a value."""
    wanted = ca.vertcat(inverted.rates, inverted.expressions(drives))
    values = ca.Function("values", inverted.inputs, [wanted])
    x = np.sqrt(np.arange(2.0, 2.0 + inverted.inputs[0].numel()))
    m = np.zeros(inverted.inputs[3].numel())

    def has_values(theta: np.ndarray) -> bool:
        return bool(np.isfinite(np.asarray(values(x, theta, 0.7, m))).all())

    zero = theta == 0
    filled = np.where(zero, 1.0, theta)
    if not has_values(filled):
        return
    own = np.eye(len(theta), dtype=bool) & zero
    found = [
        f"{name} = 0"
        for name, row in zip(inverted.parameters, own, strict=True)
        if not has_values(np.where(row, 0.0, filled))
    ]
    if found:
        raise OptionError(
            f"{inverted.name}: {' and '.join(found)}: the inverted equations divide by "
            f"{'it' if len(found) == 1 else 'them'}, as without a damper the drive needs further "
            "derivatives of the motion. Take a part without this parameter, such as Spring in "
            "place of SpringDamper, or a value above zero."
        ) from None


def _cut(run: Trajectory, end: float) -> Trajectory:
    """A run up to an instant."""
    pieces = [
        replace(piece, t=piece.t[k], x=piece.x[k], settings=piece.settings[k])
        for piece in run.pieces
        if (k := piece.t <= end).any()
    ]
    events = tuple(event for event in run.events if event.time <= end)
    return replace(run, pieces=tuple(pieces), events=events, _known={})


def _find_drive(tree: Tree, name: Name) -> str:
    """Dotted name of an input that is given to its instance."""
    key = key_of(name)
    number = tree.unknown(key)
    quantity, node = tree.quantity(number), tree.node_of_unknown(number)
    given = [
        one.name(local)
        for one in tree.instances
        for local, q in quantities_of(one.component).items()
        if isinstance(q, Input) and local in values_of(one.component)
    ]
    if key not in given:
        what = "is connected" if isinstance(quantity, Input) else "is not an input"
        raise OptionError(
            f"inverse: {key} ({quantity.text}, {quantity.unit}) of {node.label} {what}; a drive is "
            f"an input that is given to its instance, as a number. {nearest(key, given)}"
        )
    return key


def _read_wanted(system: System, name: Name, value: object) -> Expr:
    quantity = system.quantity(name)
    if isinstance(value, Expr):
        return value
    try:
        number = np.nan if isinstance(value, str) else float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        number = np.nan
    if not np.isfinite(number):
        raise OptionError(
            f"inverse: {system.key(name)} = {value!r}: a finite number or an expression of "
            f"lumped.time in {quantity.unit} ({quantity.text}) is needed."
        )
    return as_expr(number)
