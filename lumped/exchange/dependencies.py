"""What outputs, derivatives of states and values at the start depend on, and how."""

from __future__ import annotations

from functools import cached_property

import casadi as ca
import numpy as np
import scipy.sparse

from lumped.exchange.interface import Interface, Shown

__all__ = ["Dependencies"]

Uses = scipy.sparse.csr_array


class Dependencies:
    """Sparsity of the functions of a system, by the value references of an interface.

    Conditions and holds count: what a position decides depends on all that decides the position.

    Parameters
    ----------
    interface : Interface
        With its variables.
    """

    def __init__(self, interface: Interface) -> None:
        self._interface, self._system = interface, interface.system
        system = interface.system
        self._x, self._p, self._t, m = system.inputs
        self._modes = m[: system.structure.mode_count]
        self._known = ca.vertcat(self._x, self._p, self._t)
        margins = system.margins(*system.inputs)[0] if interface.margins else ca.SX(0, 1)
        self._found = ca.vertcat(system.rates, interface.output_expressions, margins)
        self._rows = _places(interface.variables, "rate", "output", "indicator")
        states = _places(interface.variables, "state")
        self._columns = [*states, *_places(interface.variables, "parameter", "input"), 0]

    def running(self) -> dict[int, list[tuple[int, str]]]:
        """Known variables of each unknown while the time goes on, and the kind of each.

        Unknown are derivatives of states, outputs and event indicators; known are the time,
        states and inputs. Kinds are those of the Functional Mock-up Interface.
        """
        variables = self._interface.variables
        kinds = self._kinds()
        found: dict[int, list[tuple[int, str]]] = {
            r: [(r, "constant")] for r in _places(variables, "state") if variables[r].is_output
        }
        whole = self._with_modes(self._direct)
        for i, row in enumerate(self._rows):
            known = [int(j) for j in whole.indices[whole.indptr[i] : whole.indptr[i + 1]]]
            listed = [
                (self._columns[j], kinds.get((i, j), "dependent"))
                for j in known
                if variables[self._columns[j]].role != "parameter"
            ]
            found[row] = sorted(listed)
        return found

    def initial(self) -> dict[int, list[int]]:
        """Known variables of each unknown at the start: time, inputs, and what has a start value."""
        variables, switching = self._interface.variables, self._system.switching
        known = [r for r, v in enumerate(variables) if v.start is not None or v.role == "time"]
        states = _places(variables, "state")
        unknown = [r for r in (*states, *self._rows) if variables[r].start is None]
        if len(switching.first_modes) or switching.jumps:  # what meets or jumps moves other states
            return {r: known for r in unknown}
        begin = self._states_at_start()
        whole = self._with_modes(self._direct)
        count = len(states)
        later = _union(whole[:, :count] @ begin, whole[:, count:] @ _tail(count, len(self._columns)))
        found = dict(zip((*states, *self._rows), _lists(begin) + _lists(later), strict=True))
        return {r: sorted(self._columns[j] for j in found[r]) for r in unknown}

    @cached_property
    def _direct(self) -> tuple[Uses, Uses]:
        """Which known variables and modes the unknown ones hold."""
        return _uses(self._found, self._known), _uses(self._found, self._modes)

    def _with_modes(self, direct: tuple[Uses, Uses]) -> Uses:
        return _union(direct[0], direct[1] @ self._of_modes)

    @cached_property
    def _of_modes(self) -> Uses:
        """Which known variables decide each mode, through other modes too."""
        structure, switching = self._system.structure, self._system.switching
        parts: list[ca.SX] = []
        owners: list[list[int]] = []
        for condition in (*switching.timed, *switching.conditions):
            parts.append(condition.argument)
            owners.append(list(condition.modes))
        of_conditions = {mode for owned in owners for mode in owned}
        held = [k for k in range(self._modes.numel()) if k not in of_conditions]
        if held:
            needed = switching.needed()
            parts += ca.vertsplit(needed)
            owners += [held] * needed.numel()
        shape = (self._modes.numel(), len(parts))
        pairs = [(mode, k) for k, owned in enumerate(owners) for mode in owned]
        if not pairs:
            return Uses((shape[0], len(self._columns)), dtype=bool)
        rows, columns = np.array(pairs).T
        decides = Uses((np.ones(len(pairs), dtype=bool), (rows, columns)), shape=shape)
        expressions = structure.in_states(ca.vertcat(*parts))
        found = _only(decides @ _uses(expressions, self._known))
        others = _only(decides @ _uses(expressions, self._modes))
        count = -1
        while count < found.nnz:
            count = found.nnz
            found = _union(found, others @ found)
        return found

    def _states_at_start(self) -> Uses:
        """Which known variables each state in use follows from at the start."""
        interface, system = self._interface, self._system
        form, structure = interface.form, system.structure
        count, width = len(structure.in_use), len(self._columns)
        settable = np.flatnonzero(interface.settable_states)
        all_count = form.states.numel()
        places = np.array(structure.in_use, dtype=int)
        own = Uses(
            (np.ones(len(settable), dtype=bool), (places[settable], settable)),
            shape=(all_count, width),
        )
        given = _uses(form.states, self._known)
        found = _union(own, given)
        if len(form.columns):
            every = structure.values.states
            missed = _uses(form.miss, ca.vertcat(self._p, self._t)) @ _tail(count, width)
            decided = _uses(form.miss, self._modes) @ self._of_modes
            missed = _union(missed, _uses(form.miss, every) @ found)
            # a condition looks at states that follow from others
            missed = _union(missed, decided[:, count:] @ _tail(count, width))
            missed = _union(missed, decided[:, :count] @ found[places])
            solved = np.zeros((all_count, 1), dtype=bool)
            solved[form.columns] = 1
            together = Uses(missed.sum(axis=0, dtype=bool).reshape(1, -1))
            found = _union(found, Uses(solved) @ together)
        return _only(found[places])

    def _kinds(self) -> dict[tuple[int, int], str]:
        """How what varies continuously enters: row and column of the unknown and the known."""
        variables = self._interface.variables
        inputs = [j for j, r in enumerate(self._columns) if variables[r].role == "input"]
        count = self._x.numel()
        columns = [*range(count), *inputs]
        slopes = ca.jacobian(self._found, self._known[columns])
        rows, places = (np.array(v, dtype=int) for v in slopes.sparsity().get_triplet())
        entries = ca.vertcat(ca.SX(0, 1), *slopes.nonzeros())
        parameters = [r - 1 for r in _places(variables, "parameter")]
        tunable = [k for k in parameters if variables[k + 1].tunable]
        fixed = [k for k in parameters if not variables[k + 1].tunable]
        p = self._p
        varying = ca.vertcat(self._x, self._t, p[[j - count for j in inputs]], self._guesses)
        kinds = np.full(len(rows), "constant", dtype=object)
        for kind, symbols in (
            ("fixed", p[fixed]),
            ("tunable", p[tunable]),
            ("discrete", self._modes),
            ("dependent", varying),
        ):
            kinds[np.unique(_uses(entries, symbols).nonzero()[0])] = kind
        pairs = zip(rows.tolist(), (columns[k] for k in places.tolist()), strict=True)
        return dict(zip(pairs, kinds.tolist(), strict=True))

    @property
    def _guesses(self) -> ca.SX:
        return self._system.inputs[3][self._modes.numel() :]


def _places(variables: list[Shown], *roles: str) -> list[int]:
    """Value references of variables of some roles."""
    return [r for r, v in enumerate(variables) if v.role in roles]


def _uses(expression: ca.SX, symbols: ca.SX) -> Uses:
    """Which symbols the entries of an expression hold."""
    rows, columns = ca.jacobian_sparsity(expression, symbols).get_triplet()
    shape = (expression.numel(), symbols.numel())
    return Uses((np.ones(len(rows), dtype=bool), (rows, columns)), shape=shape)


def _only(found: Uses) -> Uses:
    """In order, and no place twice."""
    found = Uses(found)
    found.sum_duplicates()
    return found


def _union(first: Uses, second: Uses) -> Uses:
    return _only(first + second)


def _tail(first: int, width: int) -> Uses:
    """Rows of the identity from one on."""
    return Uses(scipy.sparse.eye_array(width, dtype=bool, format="csr")[first:])


def _lists(found: Uses) -> list[list[int]]:
    return [row.tolist() for row in np.split(found.indices, found.indptr[1:-1])]
