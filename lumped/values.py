"""Every unknown as an expression of states, parameters, time and modes, computed on demand.

Blocks are evaluated level by level; all scalar blocks of a level that solve the same template
equation for the same unknown are one vectorised CasADi call. Nothing is computed that nobody
asked for.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

import casadi as ca
import numpy as np

from lumped.diagnosis import class_names, equation_text, factors
from lumped.errors import SingularModelError
from lumped.incidence import Occurrence
from lumped.linear import Entry, SingularBlockError, solve
from lumped.reduce import Block, Reduced
from lumped.template import CONSTANT

__all__ = ["Values"]

_ITERATIONS = 5
"""Newton iterations from one step's values to the next's."""


class Values:
    """Expressions of nodes.

    Parameters
    ----------
    reduced : Reduced
        The reduced model.

    Attributes
    ----------
    states : SX, shape (n, 1)
        Symbols of the states.
    time : SX
        Symbol of the time.
    modes : SX, shape (m, 1)
        Symbols of the modes.
    implicit : list of int
        Nodes that follow from equations not linear in them (closed linkages).
    guesses : SX, shape (len(implicit), 1)
        Symbols of values near theirs, from which Newton's method starts.
    """

    def __init__(self, reduced: Reduced) -> None:
        self.reduced = reduced
        self.flat = reduced.incidence.flat
        count = int(reduced.first[-1])
        self.states = ca.SX.sym("x", len(reduced.states))
        self.time = ca.SX.sym("t")
        self.modes = ca.SX.sym("m", self.flat.mode_count)
        self._sx = ca.SX.zeros(count + 1)  # the last one is the constant zero
        self._rng = np.random.default_rng(1)
        self._number = np.zeros(count + 1)
        loops = [b for b, block in enumerate(reduced.blocks) if self._is_implicit(block)]
        self.implicit = [node for b in loops for node in reduced.blocks[b].nodes]
        self._loops = set(loops)
        self.guesses = ca.SX.sym("g", len(self.implicit))
        self._correction: dict[int, ca.SX] = {}
        if reduced.states:
            self._sx[reduced.states] = self.states
            self._number[reduced.states] = self._rng.uniform(0.01, 0.03, len(reduced.states))
        begins = {*reduced.states, *self.implicit}
        self._number[self.implicit] = self._rng.uniform(0.01, 0.03, len(self.implicit))
        for unknown, value in self.flat.start_numbers.items():
            node = reduced.node(unknown)
            if node in begins:
                self._number[node] += value * reduced.aliases.signs[unknown]
        self._parameters = self.flat.parameters.numbers
        self._mode_numbers = np.ones(self.flat.mode_count)
        self._done = np.zeros(len(reduced.blocks), dtype=bool)

    def of(self, nodes: Iterable[int]) -> ca.SX:
        """Expressions of nodes, shape (n, 1)."""
        wanted = list(nodes)
        self._compute({int(self.reduced.block_of[n]) for n in wanted} - {-1})
        return self._sx[wanted] if wanted else ca.SX(0, 1)

    def arguments(self, seen: Occurrence) -> list[ca.SX]:
        """Arguments of a template's functions, one column per instance."""
        nodes = self._nodes(seen)
        self.of(sorted({int(n) for n in nodes.ravel() if n < self.reduced.first[-1]}))
        return self._arguments(seen, nodes)[0]

    def corrections(self) -> ca.SX:
        """Last step of Newton's method for each implicit node, shape (len(implicit), 1)."""
        self.of(self.implicit)
        return ca.vertcat(ca.SX(0, 1), *(self._correction[node] for node in self.implicit))

    def _compute(self, wanted: set[int]) -> None:
        todo: set[int] = set()
        stack = [b for b in wanted if not self._done[b]]
        while stack:
            block = stack.pop()
            if block not in todo:
                todo.add(block)
                stack.extend(b for b in self.reduced.blocks[block].needs if not self._done[b])
        levels: dict[int, list[int]] = defaultdict(list)
        for block in sorted(todo):
            levels[self.reduced.blocks[block].level].append(block)
        for level in sorted(levels):
            self._level([self.reduced.blocks[b] for b in levels[level]])
            self._done[levels[level]] = True

    def _level(self, blocks: list[Block]) -> None:
        singles: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
        sums: list[tuple[int, int, int]] = []
        coupled = []
        incidence = self.reduced.incidence
        for block in blocks:
            if int(self.reduced.block_of[block.nodes[0]]) in self._loops:
                self._newton(block)
                continue
            if len(block.nodes) > 1:
                coupled.append(block)
                continue
            (row, order), node = block.equations[0], block.nodes[0]
            if row >= incidence.first_sum:
                sums.append((row, order, node))
            else:
                origin, place = incidence.place(row)
                singles[origin, order].append((place, node))
        repeated: set[int] = set()
        for (origin, order), members in singles.items():
            if incidence.stick(origin) is not None:
                repeated |= {node for _, node in members}
                continue
            places = np.array([m[0] for m in members])
            nodes = np.array([m[1] for m in members])
            repeated |= self._scalars(incidence.occurrence(origin, order, places), nodes)
        if repeated:
            coupled += [b for b in blocks if len(b.nodes) == 1 and b.nodes[0] in repeated]
        self._sums(sums)
        for block in coupled:
            self._coupled(block.equations, block.nodes)

    def _nodes(self, seen: Occurrence) -> np.ndarray:
        first = self.reduced.first
        nodes: np.ndarray = np.where(
            seen.classes >= 0, first[seen.classes] + seen.orders, first[-1]
        )
        return nodes

    def _arguments(
        self, seen: Occurrence, nodes: np.ndarray
    ) -> tuple[list[ca.SX], list[np.ndarray]]:
        """Arguments of a template's functions, one column per instance; symbols and numbers."""
        m, n = nodes.shape
        flat_nodes = nodes.ravel()
        symbols = self._sx[flat_nodes.tolist()] if m * n else ca.SX(0, 1)
        negative = np.flatnonzero(seen.signs.ravel() < 0).tolist()
        if negative and m * n:
            symbols[negative] = -symbols[negative]
        group, template = seen.group, seen.group.template
        parameters = group.parameters[seen.instances].ravel()
        modes = (
            group.first_mode
            + (
                seen.instances[:, None] * len(template.modes) + np.arange(len(template.modes))
            ).ravel()
        )
        values = self.flat.parameters.values
        return (
            [
                ca.reshape(symbols, n, m),
                ca.reshape(_picked(values, parameters), -1, m) if len(parameters) else ca.SX(0, m),
                ca.repmat(self.time, 1, m),
                ca.reshape(_picked(self.modes, modes), -1, m) if len(modes) else ca.SX(0, m),
            ],
            [
                (self._number[nodes] * seen.signs).T,
                self._parameters[group.parameters[seen.instances]].T,
                np.full((1, m), 0.7),
                self._mode_numbers[modes].reshape(m, -1).T,
            ],
        )

    def _scalars(self, seen: Occurrence, targets: np.ndarray) -> set[int]:
        """Solve equations that each determine one node; gives back those it stands in twice."""
        nodes = self._nodes(seen)
        hits = nodes == targets[:, None]
        repeated = hits.sum(axis=1) > 1
        position = hits.argmax(axis=1)
        for i in np.unique(position[~repeated]):
            mask = ~repeated & (position == i)
            part = Occurrence(
                seen.group,
                seen.residual,
                seen.instances[mask],
                seen.classes[mask],
                seen.orders[mask],
                seen.signs[mask],
            )
            symbols, numbers = self._arguments(part, nodes[mask])
            function = seen.residual.solved_for(int(i)).map(int(mask.sum()))
            self._store(targets[mask], function(*symbols), function(*numbers), part.signs[:, i])
        return {int(t) for t in targets[repeated]}

    def _store(self, targets: np.ndarray, result: ca.SX, number: object, signs: np.ndarray) -> None:
        column = ca.vec(result)
        negative = np.flatnonzero(signs < 0).tolist()
        if negative:
            column[negative] = -column[negative]
        self._sx[targets.tolist()] = column
        self._number[targets] = self._finite(np.asarray(number).ravel() * signs)

    def _finite(self, numbers: np.ndarray) -> np.ndarray:
        """The numbers, with any generic value where one is not finite."""
        return np.where(np.isfinite(numbers), numbers, self._rng.uniform(0.3, 0.9, numbers.shape))

    def _sums(self, members: list[tuple[int, int, int]]) -> None:
        by_size: dict[int, list[tuple[int, np.ndarray, np.ndarray]]] = defaultdict(list)
        for row, order, node in members:
            classes, shifts, signs = self.reduced.incidence.sum_terms(row)
            nodes = self.reduced.first[classes] + shifts + order
            own = nodes == node
            factor = -signs[~own] / signs[own].sum()
            by_size[int((~own).sum())].append((node, nodes[~own], factor))
        for size, group in by_size.items():
            m = len(group)
            nodes = np.concatenate([g[1] for g in group])
            factors = np.concatenate([g[2] for g in group])
            terms = _picked(self._sx, nodes) * ca.DM(factors) if size else ca.SX(0, 1)
            total = ca.sum1(ca.reshape(terms, size, m)) if size else ca.SX.zeros(1, m)
            number = (self._number[nodes] * factors).reshape(m, size).sum(axis=1)
            self._store(np.array([g[0] for g in group]), total, number, np.ones(m))

    def _coupled(self, equations: list[tuple[int, int]], nodes: list[int]) -> None:
        """Solve a block of several equations, linear in its unknowns."""
        self._sx[nodes] = ca.SX.zeros(len(nodes))
        self._number[nodes] = 0.0
        self._sx[nodes], self._number[nodes] = self._solved(equations, nodes)

    def _newton(self, block: Block) -> None:
        """A few iterations of Newton's method, from the guesses, as one expression."""
        nodes = block.nodes
        self._sx[nodes] = self.guesses[[self.implicit.index(node) for node in nodes]]
        for iteration in range(_ITERATIONS):
            step, _ = self._solved(block.equations, nodes)
            self._sx[nodes] = self._sx[nodes] + step
            if iteration == 0:
                self._number[nodes] = self._converged(nodes)
        self._correction.update(zip(nodes, ca.vertsplit(step), strict=True))

    def _converged(self, nodes: list[int]) -> np.ndarray:
        """Values at the generic point, if Newton's method finds any there."""
        begin = self._number[nodes]
        inputs = [self.guesses, self.states, self.flat.parameters.theta, self.time, self.modes]
        improve = ca.Function("improve", inputs, [self._sx[nodes]])
        guesses = self._number[self.implicit]
        places = [self.implicit.index(node) for node in nodes]
        rest = (
            self._number[self.reduced.states],
            self.flat.parameters.defaults,
            0.7,
            self._mode_numbers,
        )
        for _ in range(100):
            found = np.asarray(improve(guesses, *rest)).ravel()
            if not np.isfinite(found).all():
                return begin
            if np.abs(found - guesses[places]).max() <= 1e-12 * (1 + np.abs(found).max()):
                return found
            guesses[places] = found
        return begin

    def _solved(
        self, equations: list[tuple[int, int]], nodes: list[int]
    ) -> tuple[ca.SX, np.ndarray]:
        """What to add to the present values of nodes so that linearised equations hold."""
        index = {node: j for j, node in enumerate(nodes)}
        incidence = self.reduced.incidence
        rows: list[dict[int, Entry]] = [{} for _ in equations]
        right: list[tuple[ca.SX, float]] = [(ca.SX(0), 0.0)] * len(equations)
        alike: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
        last: dict[int, int] = {}
        for i, (row, order) in enumerate(equations):
            if row >= incidence.first_sum:
                rows[i], right[i] = self._sum_equation(row, order, index)
            else:
                origin, place = incidence.place(row)
                alike[origin, order].append((i, place))
                reaction = self._reaction(origin, place)
                if reaction is not None:
                    if reaction not in index:
                        raise self._unheld(row)
                    last[i] = index[reaction]
        for (origin, order), members in alike.items():
            places = np.array([place for _, place in members])
            seen = incidence.occurrence(origin, order, places)
            found = self._template_equations(seen, index)
            for (i, _), equation in zip(members, found, strict=True):
                rows[i], right[i] = equation
        try:
            result = solve(rows, right, last)
        except SingularBlockError as error:
            lost = [equations[i][0] for i in error.args[0]]
            raise self._singular(lost, nodes) from None
        return (
            ca.vertcat(*(expression for expression, _ in result)),
            self._finite(np.array([number for _, number in result])),
        )

    def _reaction(self, origin: int, place: int) -> int | None:
        """Node of the reaction, if an equation is that of a constraint that holds or slides."""
        incidence = self.reduced.incidence
        stick = incidence.stick(origin)
        if stick is None:
            return None
        group, _, instances, _ = incidence.blocks[origin]
        return self.reduced.node(int(group.unknowns[instances[place], stick.reaction[0]]))

    def _unheld(self, row: int) -> SingularModelError:
        incidence = self.reduced.incidence
        group, _, instances, _ = incidence.blocks[incidence.place(row)[0]]
        name = group.names[int(instances[incidence.place(row)[1]])] or self.flat.name
        return SingularModelError(
            f"{self.flat.name}: {name} holds and slides, but one of its sides has no inertia, so "
            "that its reaction is known and its speed is not while it slides. Put an Inertia or "
            f"Mass on each side of {name}."
        )

    def _is_implicit(self, block: Block) -> bool:
        """Whether the equations of a block are not linear in its unknowns."""
        incidence = self.reduced.incidence
        for row, order in block.equations:
            if row >= incidence.first_sum:
                continue
            origin, place = incidence.place(row)
            group, e = incidence.blocks[origin][:2]
            affine = group.template.residual(e, order).affine
            if affine.all():
                continue
            nodes = self._nodes(incidence.occurrence(origin, order, np.array([place])))[0]
            inside = np.flatnonzero(np.isin(nodes, block.nodes))
            if not affine[np.ix_(inside, inside)].all():
                return True
        return False

    def _sum_equation(
        self, row: int, order: int, index: dict[int, int]
    ) -> tuple[dict[int, Entry], tuple[ca.SX, float]]:
        """Coefficients of the unknowns in a flow sum, and minus its residual."""
        classes, shifts, signs = self.reduced.incidence.sum_terms(row)
        entries: dict[int, Entry] = {}
        total, number = ca.SX(0), 0.0
        for node, sign in zip(self.reduced.first[classes] + shifts + order, signs, strict=True):
            total -= float(sign) * self._sx[int(node)]
            number -= float(sign) * self._number[node]
            if int(node) in index:
                _add(entries, index[int(node)], Entry(ca.SX(sign), CONSTANT, float(sign)))
        return entries, (total, number)

    def _template_equations(
        self, seen: Occurrence, index: dict[int, int]
    ) -> list[tuple[dict[int, Entry], tuple[ca.SX, float]]]:
        """The same for several instances of one template equation, in one call."""
        nodes, residual = self._nodes(seen), seen.residual
        m, n = nodes.shape
        symbols, numbers = self._arguments(seen, nodes)
        coefficients, value = residual.coefficients.map(m), residual.value.map(m)
        partials = ca.vertsplit(ca.vec(coefficients(*symbols)))
        sizes = self._finite(np.asarray(coefficients(*numbers)).reshape(n, m)).T
        rests = ca.vertsplit(ca.vec(-value(*symbols)))
        rest_sizes = -np.asarray(value(*numbers)).ravel()
        found = []
        for k in range(m):
            entries: dict[int, Entry] = {}
            for i, node in enumerate(nodes[k].tolist()):
                if node in index:
                    sign = float(seen.signs[k, i])
                    partial = partials[k * n + i]
                    entry = Entry(
                        partial if sign > 0 else -partial,
                        int(residual.kinds[i]),
                        sign * float(sizes[k, i]),
                    )
                    _add(entries, index[node], entry)
            found.append((entries, (rests[k], float(rest_sizes[k]))))
        return found

    def _names(self, nodes: Iterable[int]) -> str:
        incidence = self.reduced.incidence
        found = []
        for node in nodes:
            number, order = self.reduced.class_and_order(node)
            name = class_names(incidence, number, 1)[0]
            found.append("der(" * order + name + ")" * order)
        return ", ".join(found)

    def _singular(self, rows: list[int], nodes: list[int]) -> SingularModelError:
        incidence = self.reduced.incidence
        listed = [equation_text(incidence, *incidence.origin(r)) for r in rows[:8]]
        why = "Likely two rigid paths transmit the same torque, so that its shares are unknown. "
        what = "Make one of them elastic."
        zeros = self._zero_parameters(nodes)
        if zeros:
            why = f"These parameters in its equations are zero: {', '.join(zeros[:6])}. "
            what = "Give them values, or take parts without them (a Spring for a SpringDamper)."
        return SingularModelError(
            f"{self.flat.name}: these equations determine nothing more, or contradict the rest:\n  "
            + "\n  ".join(listed)
            + f"\nUnknowns of the block: {self._names(nodes[:12])}.\n{why}{what}"
        )

    def _zero_parameters(self, nodes: list[int]) -> list[str]:
        """Parameters that are zero in the equations of the block that determines the nodes."""
        block = self.reduced.blocks[self.reduced.block_of[nodes[0]]]
        return [
            self.flat.parameters.names[number]
            for row, order in block.equations
            for number in factors(self.reduced.incidence, row, order)
            if self._parameters[number] == 0
        ]


def _picked(vector: ca.SX, indices: np.ndarray) -> ca.SX:
    return vector[[int(i) for i in indices]] if len(indices) else ca.SX(0, 1)


def _add(entries: dict[int, Entry], column: int, entry: Entry) -> None:
    old = entries.get(column)
    if old is not None:
        entry = Entry(
            old.expression + entry.expression,
            max(old.kind, entry.kind),
            old.value + entry.value,
        )
    entries[column] = entry
