"""Parameters and start values by which a run is differentiated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lumped.analysis.result import Trajectory
from lumped.analysis.start import by_name, start_slopes
from lumped.errors import OptionError, SolverError
from lumped.system import Changes, System

__all__ = ["slopes_at_zero", "sources", "varied_values"]


def sources(
    system: System, names: Sequence[str], start: Changes
) -> tuple[list[int], dict[int, np.ndarray]]:
    """Places of parameters (-1: a start value); unit vectors of unknowns for start values.

    Raises
    ------
    OptionError
        If a name is nothing that can be varied.
    """
    tree, reduced = system._tree, system._reduced
    given = [*system._flat.given, *(tree.unknown(name) for name in by_name(start))]
    nodes = {reduced.node(unknown): unknown for unknown in given}
    p = system._flat.parameters
    known = {p.names[i]: place for place, i in enumerate(p.free)}
    places: list[int] = []
    varied: dict[int, np.ndarray] = {}
    for column, name in enumerate(names):
        if name in known:
            places.append(known[name])
            continue
        unknown = tree.unknown(name)
        node = reduced.node(unknown)
        if node is None or (node not in nodes and node not in system.states):
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


def slopes_at_zero(
    run: Trajectory, start: Changes, seed: np.ndarray, varied: Mapping[int, np.ndarray]
) -> np.ndarray:
    """Derivatives of the states at the time zero (see `start_slopes`), shape (n, k).

    Raises
    ------
    SolverError
        If states jump there.
    """
    x, S = start_slopes(run.system, run.theta, start, seed, varied)
    if np.abs(x - run.pieces[0].x[0]).max(initial=0.0) > 0:
        raise SolverError(
            f"{run.system.name}: bodies collide at the time zero; derivatives are not "
            "followed across that. Give start values after the impact.",
            run,
        )
    return S


def varied_values(run: Trajectory, names: Sequence[str]) -> np.ndarray:
    """Parameters, and start values of other names."""
    p = run.system._flat.parameters
    known = {p.names[i]: v for i, v in zip(p.free, run.theta.tolist(), strict=True)}
    return np.array([known[n] if n in known else float(run[n][0]) for n in names])
