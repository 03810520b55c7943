"""Parameters and start values by which a run is differentiated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, SolverError
from lumped.points.start import by_name
from lumped.points.start_slopes import start_slopes
from lumped.timeloop.leading_states import states_of
from lumped.timeloop.programs import refuse_programs
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory

TIGHTER = 3e-3
"""Accuracy of a run over that of its derivatives."""

END = "until"
"""Name by which the end of a run is varied."""

_ROUNDING = 1e-9
"""What the start of a run in redundant coordinates may differ by, relative or absolute."""


def tighten(rtol: float) -> float:
    """Tolerance of a run whose derivatives shall be right to `rtol` or a little more.

    A derivative is what larger terms leave: an instant that moves, times a rate that jumps there.
    """
    return max(TIGHTER * rtol, min(rtol, 1e-13))


def resolve_name(system: System, name: Name) -> str:
    """Name of what is varied; `END` if no parameter has this name."""
    if name == END and END not in system.parameters:
        return END
    return system.key(name)


def sources(
    system: System, names: Sequence[str], start: Changes | OperatingPoint | None
) -> tuple[list[int], dict[int, np.ndarray]]:
    """Places of parameters (-1: a start value); unit vectors of unknowns for start values.

    Raises
    ------
    OptionError
        If a name is nothing that can be varied, or the system asks programs.
    """
    refuse_programs(system, "a derivative of a run")
    tree, reduced = system.structure.tree, system.structure.reduced
    given = list[int]()  # of the states of a point none is more given than another
    if not isinstance(start, OperatingPoint):
        given = [*system.structure.flat.given, *(tree.unknown(name) for name in by_name(start))]
    nodes = {reduced.node(unknown): unknown for unknown in given}
    known = {name: place for place, name in enumerate(system.structure.parameters.free_names)}
    places: list[int] = []
    varied: dict[int, np.ndarray] = {}
    for column, name in enumerate(names):
        if name in known:
            places.append(known[name])
            continue
        unknown = tree.unknown(name)
        node = reduced.node(unknown)
        if node is None or (node not in nodes and node not in system.structure.states):
            raise OptionError(
                f"{system.name}: {name} is no parameter that can be changed, no given start "
                f"value and no state. States: {', '.join(system.state_names[:12])}."
            )
        signs, held = reduced.aliases.signs, nodes.get(node, unknown)
        places.append(-1)
        unit = np.zeros(len(names))
        unit[column] = float(signs[unknown] * signs[held])
        varied[held] = varied.get(held, 0.0) + unit
    return places, varied


def slopes_at_start(
    run: Trajectory,
    start: Changes | OperatingPoint | None,
    seed: np.ndarray,
    varied: Mapping[int, np.ndarray],
) -> np.ndarray:
    """Derivatives of the states at the start (see `start_slopes`), shape (n, k).

    Raises
    ------
    OptionError
        If a state is named whose start value is determined by others.
    SolverError
        If states jump there.
    """
    first, system = run.pieces[0], run.system.bound
    x, S = start_slopes(system, run.theta, start, float(first.t[0]), seed, varied)
    _refuse_fixed(system, varied, S)
    rounding = 0.0
    if system is not run.system:
        x, S = _free_slopes(system, run, x, S, seed)
        rounding = _ROUNDING
    if (np.abs(x - first.x[0]) > rounding * np.maximum(1.0, np.abs(x))).any():
        raise SolverError(
            f"{run.system.name}: bodies collide at the start; derivatives are not "
            "followed across that. Give start values after the impact.",
            run,
        )
    return S


def _free_slopes(
    system: System, run: Trajectory, x: np.ndarray, S: np.ndarray, seed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """States at the start of a run in redundant coordinates from those that lead; derivatives."""
    first = run.pieces[0]
    here = first.x[0], run.theta, float(first.t[0]), first.settings[0]
    _, implicit = states_of(run.system, system)(*here)
    settings = np.append(first.settings[0][: system.structure.mode_count], implicit)
    inputs = x, run.theta, float(first.t[0]), settings
    found = system.structure.values.of(run.system.structure.states)
    slopes = [ca.jacobian(found, along) for along in system.inputs[:2]]
    by_states, by_parameters = ca.Function("slopes", system.inputs, slopes)(*inputs)
    whole = by_states.sparse() @ S + by_parameters.sparse() @ seed
    return states_of(system, run.system)(*inputs)[0], whole


def _refuse_fixed(system: System, varied: Mapping[int, np.ndarray], S: np.ndarray) -> None:
    """Refuse start values of states that other given values determine."""
    reduced, tree = system.structure.reduced, system.structure.tree
    place = {node: i for i, node in enumerate(system.structure.states)}
    for unknown, unit in varied.items():
        node = reduced.node(unknown)
        if node not in place:
            continue
        own = float(reduced.aliases.signs[unknown]) * S[place[node]]
        if (np.abs(own - unit)[unit != 0] > 1e-9).any():
            given = sorted(tree.unknown_name(u) for u in system.structure.flat.given)
            raise OptionError(
                f"{system.name}: {tree.unknown_name(unknown)} cannot be varied at the start: other "
                f"start values or initial equations determine it. Vary these instead"
                f"{': ' * bool(given)}{', '.join(given[:8])}."
            )


def describe_shared(shared: Sequence[float]) -> str:
    """A line on instants at which shares of indeterminate constraints are held fixed, if any."""
    if not shared:
        return ""
    times = ", ".join(f"{t:.6g} s" for t in shared[:6])
    return f"\nshares of indeterminate constraints held fixed where they let go, t = {times}"


def read_varied_values(run: Trajectory, names: Sequence[str]) -> np.ndarray:
    """Parameters, and start values of other names."""
    free = run.system.structure.parameters.free_names
    known = dict(zip(free, run.theta.tolist(), strict=True))
    end = {END: float(run.t[-1])} if END not in known else {}
    known |= end
    return np.array([known[n] if n in known else float(run[n][0]) for n in names])
