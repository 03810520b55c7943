"""Leave out states that the scene does not need."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order

from lumped.values import Values

__all__ = ["independent_of", "needed_states", "uses"]


def uses(expression: ca.SX, values: Values) -> csr_array:
    """Which state stands in which element of an expression, as a sparse (elements, states)."""
    sparsity = ca.jacobian_sparsity(expression, values.states)
    rows, columns = sparsity.get_triplet()
    shape = (expression.numel(), values.states.numel())
    return csr_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=shape)


def independent_of(expression: ca.SX, columns: Sequence[int], values: Values) -> np.ndarray:
    """Whether an expression does not change with states although they stand in it.

    The derivative is evaluated at random states, parameters, times and modes; where it vanishes
    to rounding at all of them, the state cancels (Schwartz-Zippel).

    Returns
    -------
    ndarray of bool, shape (len(columns),)
    """
    parameters = values.flat.parameters
    settings = ca.vertcat(values.modes, values.guesses)
    inputs = [values.states, parameters.theta, values.time, settings]
    picked = values.states[list(columns)]
    function = ca.Function(
        "J",
        inputs,
        [ca.jacobian(expression, picked), ca.jacobian(expression, values.states)],
    )
    rng = np.random.default_rng(6)
    cancels = np.ones(len(columns), dtype=bool)
    for _ in range(3):
        own, full = function(
            rng.uniform(-2, 2, values.states.numel()),
            parameters.defaults * rng.uniform(0.8, 1.2, len(parameters.defaults))
            + 0.01 * rng.uniform(size=len(parameters.defaults)),
            rng.uniform(0, 2),
            np.concatenate(
                [
                    rng.integers(0, 2, values.modes.numel()),
                    rng.uniform(-2, 2, values.guesses.numel()),
                ]
            ),
        )
        scale = abs(csr_array(full.sparse())).max(axis=1).toarray().ravel()
        own_entries = csr_array(own.sparse()).tocoo()
        small = np.abs(own_entries.data) <= 1e-11 * scale[own_entries.row]
        cancels[own_entries.col[~small]] = False
    return cancels


def needed_states(
    values: Values, positions: set[int], outputs: ca.SX | None, kept: ca.SX
) -> list[int]:
    """Numbers of the states to integrate.

    Parameters
    ----------
    values : Values
        All expressions.
    positions : set of int
        Numbers of states that are positions of ports: left out where nothing depends on them.
    outputs : SX or None
        With outputs, only what they need is kept.
    kept : SX
        Quantities to be available in any case.
    """
    states = values.reduced.states
    rates = values.of([n + 1 for n in states])
    links = uses(rates, values)
    asked = set(uses(kept, values).indices.tolist())
    if outputs is not None:
        asked |= set(uses(outputs, values).indices.tolist())
        return _closed(links, asked)
    used = np.zeros(len(states), dtype=bool)
    used[links.indices] = True
    doubtful = [i for i in sorted(positions - asked) if used[i]]
    if doubtful:
        used[doubtful] = ~independent_of(rates, doubtful, values)
    return [i for i in range(len(states)) if used[i] or i in asked or i not in positions]


def _closed(links: csr_array, begin: set[int]) -> list[int]:
    """All states that those in `begin` need directly or indirectly."""
    n = links.shape[0]
    coo = links.tocoo()
    rows = np.concatenate([coo.row, np.full(len(begin), n)])
    columns = np.concatenate([coo.col, np.array(sorted(begin), dtype=int)])
    graph = csr_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(n + 1, n + 1))
    order = breadth_first_order(graph, n, return_predecessors=False)
    return sorted(int(i) for i in order if i < n)
