"""What outputs, derivatives of states and values at the start depend on, and how."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import casadi as ca
import numpy as np
import scipy

from lumped.exchange.interface import Interface, Shown


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
        lists = _lists(self._with_modes(self._direct))
        for i, row in enumerate(self._rows):
            listed = [
                (self._columns[j], kinds.get((i, j), "dependent"))
                for j in lists[i]
                if variables[self._columns[j]].role != "parameter"
            ]
            found[row] = sorted(listed)
        return found

    def initial(self) -> dict[int, list[int]]:
        """Known variables of each unknown at the start; known are time, inputs and start values."""
        variables, switching = self._interface.variables, self._system.switching
        known = [r for r, v in enumerate(variables) if v.start is not None or v.role == "time"]
        states = _places(variables, "state")
        unknown = [r for r in (*states, *self._rows) if variables[r].start is None]
        if len(switching.first_modes) or switching.jumps:  # what meets or jumps moves other states
            return dict.fromkeys(unknown, known)
        begin = self._states_at_start()
        whole = self._with_modes(self._direct)
        count = len(states)
        later = _union(
            whole[:, :count] @ begin, whole[:, count:] @ _tail(count, len(self._columns))
        )
        found = dict(zip((*states, *self._rows), _lists(begin) + _lists(later), strict=True))
        return {r: sorted(self._columns[j] for j in found[r]) for r in unknown}

    @cached_property
    def _direct(self) -> tuple[scipy.sparse.csr_array, scipy.sparse.csr_array]:
        """Which known variables and modes the unknown ones hold."""
        return _uses(self._found, self._known), _uses(self._found, self._modes)

    def _with_modes(
        self, direct: tuple[scipy.sparse.csr_array, scipy.sparse.csr_array]
    ) -> scipy.sparse.csr_array:
        return _union(direct[0], direct[1] @ self._owners @ self._decisions)

    @cached_property
    def _owners(self) -> scipy.sparse.csr_array:
        """Which decision sets each mode: a condition, or the last one, in which all holds share."""
        switching = self._system.switching
        conditions = (*switching.timed, *switching.conditions)
        owner = np.full(self._modes.numel(), len(conditions))
        for k, condition in enumerate(conditions):
            owner[list(condition.modes)] = k
        ones = np.ones(len(owner), dtype=bool)
        shape = (len(owner), len(conditions) + 1)
        return scipy.sparse.csr_array((ones, (np.arange(len(owner)), owner)), shape=shape)

    @cached_property
    def _decisions(self) -> scipy.sparse.csr_array:
        """Which known variables each decision follows from, through other decisions too."""
        switching, in_states = self._system.switching, self._system.structure.in_states
        arguments = [c.argument for c in (*switching.timed, *switching.conditions)]
        parts = in_states(ca.vertcat(ca.SX(0, 1), *arguments))
        needed = (
            in_states(switching.collect_needed()) if len(switching.first_modes) else ca.SX(0, 1)
        )

        def uses(symbols: ca.SX) -> scipy.sparse.csr_array:
            of_holds = _any(_uses(needed, symbols))
            return _only(scipy.sparse.vstack([_uses(parts, symbols), of_holds], format="csr"))

        found, others = uses(self._known), uses(self._modes) @ self._owners
        count = -1
        while count < found.nnz:
            count = found.nnz
            found = _union(found, others @ found)
        return found

    def _states_at_start(self) -> scipy.sparse.csr_array:
        """Which known variables each state in use follows from at the start."""
        interface, system = self._interface, self._system
        form, structure = interface.form, system.structure
        count, width = len(structure.in_use), len(self._columns)
        settable = np.flatnonzero(interface.settable_states)
        all_count = form.states.numel()
        places = np.array(structure.in_use, dtype=int)
        own = scipy.sparse.csr_array(
            (np.ones(len(settable), dtype=bool), (places[settable], settable)),
            shape=(all_count, width),
        )
        given = _uses(form.states, self._known)
        found = _union(own, given)
        if len(form.columns):
            every = structure.values.states
            missed = _uses(form.miss, ca.vertcat(self._p, self._t)) @ _tail(count, width)
            decided = _uses(form.miss, self._modes) @ self._owners @ self._decisions
            missed = _union(missed, _uses(form.miss, every) @ found)
            # a condition looks at states that follow from others
            missed = _union(missed, decided[:, count:] @ _tail(count, width))
            missed = _union(missed, decided[:, :count] @ found[places])
            solved = np.zeros((all_count, 1), dtype=bool)
            solved[form.columns] = 1
            found = _union(found, scipy.sparse.csr_array(solved) @ _any(missed))
        return _only(found[places])

    def _kinds(self) -> dict[tuple[int, int], str]:
        """How what varies continuously enters: row and column of the unknown and the known."""
        variables = self._interface.variables
        inputs = [j for j, r in enumerate(self._columns) if variables[r].role == "input"]
        count = self._x.numel()
        columns = [*range(count), *inputs]
        slopes = ca.jacobian(self._found, self._known[columns])
        rows, places = (np.array(v, dtype=int) for v in slopes.sparsity().get_triplet())
        entries = slopes.nz[:]
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


def _uses(expression: ca.SX, symbols: ca.SX) -> scipy.sparse.csr_array:
    """Which symbols the entries of an expression hold."""
    rows, columns = ca.jacobian_sparsity(expression, symbols).get_triplet()
    shape = (expression.numel(), symbols.numel())
    return scipy.sparse.csr_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=shape)


def _only(found: scipy.sparse.csr_array) -> scipy.sparse.csr_array:
    """In order, and no place twice."""
    found = scipy.sparse.csr_array(found)
    found.sum_duplicates()
    return found


def _any(found: scipy.sparse.csr_array) -> scipy.sparse.csr_array:
    """One row of what any row holds."""
    columns = np.unique(found.indices)
    ones, rows = np.ones(len(columns), dtype=bool), np.zeros(len(columns), dtype=int)
    return scipy.sparse.csr_array((ones, (rows, columns)), shape=(1, found.shape[1]))


def _union(first: scipy.sparse.csr_array, second: scipy.sparse.csr_array) -> scipy.sparse.csr_array:
    return _only(first + second)


def _tail(first: int, width: int) -> scipy.sparse.csr_array:
    """Rows of the identity from one on."""
    return scipy.sparse.csr_array(scipy.sparse.eye_array(width, dtype=bool, format="csr")[first:])


def _lists(found: scipy.sparse.csr_array) -> list[list[int]]:
    ends = found.indptr.tolist()
    return [found.indices[a:b].tolist() for a, b in pairwise(ends)]
