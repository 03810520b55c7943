"""Every unknown as an expression of states, parameters, time and modes, computed on demand.

Blocks are evaluated in *waves*: first those that are formulas, then those that must be solved
and need no other of the same wave. All formulas of a wave that solve the same template equation
for the same unknown are one vectorised CasADi call, and CasADi puts one into the other. Nothing
is computed that nobody asked for.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from typing import Any

import casadi as ca
import numpy as np

from lumped.flattening.residual import CONSTANT
from lumped.flattening.tape import TapeTerm
from lumped.reduction.block_errors import singular_block, unheld
from lumped.reduction.elimination import SingularBlockError, solve
from lumped.reduction.incidence import Occurrence
from lumped.reduction.linear_equations import LinearEquations
from lumped.reduction.reduce import Block, Reduced, equations_of
from lumped.support.process_lock import process_lock

_ITERATIONS = 5
"""Newton iterations from one step's values to the next's."""

_TIME = 0.7
"""Of the generic point at which pivots are chosen."""


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
        holds = reduced.incidence.holds()
        self._holds = {row: (reduced.node(r), reduced.node(v)) for row, (r, v) in holds.items()}
        self._reactions = {row: reaction for row, (reaction, _) in self._holds.items()}
        self._joint, self._loops = reduced.find_solved_blocks(self._reactions)
        self._wave: list[int] = []
        for block in reduced.blocks:
            after = (self._wave[b] + (b in self._joint) for b in block.needs)
            self._wave.append(max(after, default=0))
        self.implicit = [node for b in sorted(self._loops) for node in reduced.blocks[b].nodes]
        self._place = {node: i for i, node in enumerate(self.implicit)}
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
        with process_lock:
            self._compute({int(self.reduced.block_of[n]) for n in wanted} - {-1})
            return self._sx[wanted] if wanted else ca.SX(0, 1)

    def arguments(self, seen: Occurrence) -> list[ca.SX]:
        """Arguments of a template's functions, one column per instance but for the time."""
        nodes = self.reduced.nodes_of(seen)
        with process_lock:
            self.of(sorted({int(n) for n in nodes.ravel() if n < self.reduced.first[-1]}))
            return self._arguments(seen, nodes)

    def residuals(self, equations: list[tuple[int, int]]) -> ca.SX:
        """What is left of equations, each differentiated some times, shape (equations, 1)."""
        left = ca.SX.zeros(len(equations))
        numbers, orders = np.array(equations, dtype=int).reshape(-1, 2).T
        for places, seen in self.reduced.incidence.alike(numbers, orders):
            left[places.tolist()] = ca.vec(seen.residual.value(*self.arguments(seen)))
        sums = np.flatnonzero(numbers >= self.reduced.incidence.first_sum)
        places, nodes, signs = self._sum_nodes(numbers[sums], orders[sums])
        terms = self.of(nodes.tolist())
        for k, place in enumerate(sums[places].tolist()):
            left[place] += float(signs[k]) * terms[k]
        return left

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
        waves: dict[int, list[int]] = defaultdict(list)
        for block in sorted(todo):
            waves[self._wave[block]].append(block)
        blocks = self.reduced.blocks
        for _, wave in sorted(waves.items()):
            self._formulas([blocks[b] for b in wave if b not in self._joint])
            self._solve_linear(
                [blocks[b] for b in wave if b in self._joint and b not in self._loops]
            )
            for b in wave:
                if b in self._loops:
                    self._newton(blocks[b])
            self._done[wave] = True

    def _arguments(self, seen: Occurrence, nodes: np.ndarray) -> list[ca.SX]:
        """The same, if the nodes are computed."""
        m, n = nodes.shape
        symbols = _pick(self._sx, nodes.ravel())
        negative = np.flatnonzero(seen.signs.ravel() < 0).tolist()
        if negative:
            symbols[negative] = -symbols[negative]
        parameters, modes = self._parameters_and_modes(seen)
        return [
            ca.reshape(symbols, n, m),
            ca.reshape(_pick(self.flat.parameters.values, parameters.ravel()), -1, m),
            self.time,
            ca.reshape(_pick(self.modes, modes.ravel()), -1, m) if modes.size else ca.SX(0, 1),
        ]

    def _numbers(self, seen: Occurrence, nodes: np.ndarray) -> list[np.ndarray | float]:
        """The same at the generic point."""
        parameters, modes = self._parameters_and_modes(seen)
        return [
            (self._number[nodes] * seen.signs).T,
            self._parameters[parameters].T,
            _TIME,
            self._mode_numbers[modes].T,
        ]

    def _parameters_and_modes(self, seen: Occurrence) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the parameters and modes of each instance."""
        group, count = seen.group, len(seen.group.template.modes)
        modes = group.first_mode + seen.instances[:, None] * count + np.arange(count)
        return group.parameters[seen.instances], modes

    def _formulas(self, blocks: list[Block]) -> None:
        """Compute the nodes of blocks that each determine one, in this order."""
        if not blocks:
            return
        incidence = self.reduced.incidence
        targets = np.array([block.nodes[0] for block in blocks])
        rows, orders = equations_of(blocks)
        found = incidence.alike(rows, orders)
        alike = [(places, seen, self.reduced.nodes_of(seen)) for places, seen in found]
        sums = np.flatnonzero(rows >= incidence.first_sum)
        terms = self._sum_nodes(rows[sums], orders[sums])
        used = np.concatenate([terms[1], *(nodes.ravel() for _, _, nodes in alike)])
        known = np.setdiff1d(used, targets)
        values = _pick(self._sx, known)
        given, symbols = ca.SX.sym("g", len(known)), ca.SX.sym("z", len(targets))
        if len(known):
            self._sx[known.tolist()] = given
        self._sx[targets.tolist()] = symbols
        meaning = ca.SX.zeros(len(targets))
        for places, seen, nodes in alike:
            self._solve_templates(meaning, places, seen, nodes, targets[places])
        self._solve_sums(meaning, sums, targets[sums], *terms)
        (solved,), _ = ca.substitute_inplace([symbols], [meaning], [])
        rest = [self.flat.parameters.theta, self.time, self.modes]
        if len(known):
            self._sx[known.tolist()] = values
        function = ca.Function("formulas", [given, *rest], [solved])
        self._sx[targets.tolist()] = function(values, *rest)
        point: list[Any] = [
            self._number[known],
            self.flat.parameters.defaults,
            _TIME,
            self._mode_numbers,
        ]
        numbers = np.asarray(function(*point)).ravel()
        if not np.isfinite(numbers).all():
            single = ca.Function("single", [symbols, given, *rest], [meaning])
            numbers = self._evaluate_in_turn(single, point, len(targets))
        self._number[targets] = numbers

    def _evaluate_in_turn(self, single: ca.Function, point: list[Any], count: int) -> np.ndarray:
        """Values of formulas one after the other, any generic value where one is not finite."""
        generic = self._rng.uniform(0.3, 0.9, count)
        last, numbers = np.zeros(count), generic
        while (last != numbers).any():
            last, found = numbers, np.asarray(single(numbers, *point)).ravel()
            numbers = np.where(np.isfinite(found), found, generic)
        return numbers

    def _solve_templates(
        self,
        meaning: ca.SX,
        places: np.ndarray,
        seen: Occurrence,
        nodes: np.ndarray,
        targets: np.ndarray,
    ) -> None:
        """Enter instances of a template equation solved for their targets."""
        position = (nodes == targets[:, None]).argmax(axis=1)
        for i in np.unique(position):
            mask = position == i
            part = seen.pick(mask)
            function = seen.residual.solve_for(int(i))
            result = ca.vec(function(*self._arguments(part, nodes[mask])))
            if (part.signs[:, i] < 0).any():
                result = result * ca.DM(part.signs[:, i])
            meaning[places[mask].tolist()] = result

    def _finite(self, numbers: np.ndarray) -> np.ndarray:
        """The numbers, with any generic value where one is not finite."""
        return np.where(np.isfinite(numbers), numbers, self._rng.uniform(0.3, 0.9, numbers.shape))

    def _sum_nodes(
        self, rows: np.ndarray, orders: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Terms of flow sums: position of the sum in `rows`, node, coefficient."""
        places, classes, shifts, signs = self.reduced.incidence.sum_terms(rows)
        return places, self.reduced.first[classes] + shifts + orders[places], signs

    def _solve_sums(
        self,
        meaning: ca.SX,
        sums: np.ndarray,
        targets: np.ndarray,
        places: np.ndarray,
        nodes: np.ndarray,
        signs: np.ndarray,
    ) -> None:
        """Enter flow sums solved for their targets."""
        own = nodes == targets[places]
        divisor = np.bincount(places[own], signs[own], len(sums))
        places, nodes, factors = places[~own], nodes[~own], -signs[~own]
        counts = np.bincount(places, minlength=len(sums))
        for count in np.unique(counts[counts > 0]):
            mask = counts[places] == count
            some = ca.DM(factors[mask] / divisor[places[mask]])
            terms = ca.reshape(_pick(self._sx, nodes[mask]) * some, int(count), -1)
            meaning[sums[counts == count].tolist()] = ca.sum1(terms).T

    def _solve_linear(self, blocks: list[Block]) -> None:
        """Solve blocks linear in their unknowns."""
        nodes = [node for block in blocks for node in block.nodes]
        if nodes:
            self._sx[nodes] = ca.SX.zeros(len(nodes))
            self._number[nodes] = 0.0
            self._sx[nodes], self._number[nodes] = self._solve_linearised(blocks)

    def _newton(self, block: Block) -> None:
        """A few iterations of Newton's method, from the guesses, as one expression."""
        nodes, known = block.nodes, self._find_known(block)
        guesses = self.guesses[[self._place[node] for node in nodes]]
        values, given = _pick(self._sx, known), ca.SX.sym("g", len(known))
        self._sx[nodes], self._sx[known.tolist()] = guesses, given
        step, _ = self._solve_linearised([block])
        self._sx[known.tolist()] = values
        rest = [self.flat.parameters.theta, self.time, self.modes]
        improve = ca.Function("improve", [guesses, given, *rest], [guesses + step])
        self._number[nodes] = self._converge(improve, self._number[nodes], self._number[known])
        self._sx[nodes] = improve(guesses, values, *rest)
        for _ in range(_ITERATIONS - 1):
            step, _ = self._solve_linearised([block])
            self._sx[nodes] = self._sx[nodes] + step
        self._correction.update(zip(nodes, ca.vertsplit(step), strict=True))

    def _find_known(self, block: Block) -> np.ndarray:
        """Nodes in the equations of a block that others determine."""
        rows, orders = equations_of([block])
        used = [
            self.reduced.nodes_of(seen) for _, seen in self.reduced.incidence.alike(rows, orders)
        ]
        sums = np.flatnonzero(rows >= self.reduced.incidence.first_sum)
        used.append(self._sum_nodes(rows[sums], orders[sums])[1])
        return np.setdiff1d(
            np.concatenate([n.ravel() for n in used]), [*block.nodes, len(self._number) - 1]
        )

    def _converge(self, improve: ca.Function, begin: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Values at the generic point, if Newton's method finds any there."""
        rest = known, self.flat.parameters.defaults, _TIME, self._mode_numbers
        guesses = begin
        for _ in range(100):
            found = np.asarray(improve(guesses, *rest)).ravel()
            if not np.isfinite(found).all():
                return begin
            if np.abs(found - guesses).max() <= 1e-12 * (1 + np.abs(found).max()):
                return found
            guesses = found
        return begin

    def _solve_linearised(self, blocks: list[Block]) -> tuple[ca.SX, np.ndarray]:
        """What to add to the present values of nodes so that linearised equations hold."""
        linear = self._linearise(blocks)
        tape = linear.tape
        found: list[tuple[TapeTerm, float]] = []
        for block in blocks:
            own = slice(len(found), len(found) + len(block.nodes))
            try:
                found += solve(linear.rows[own], linear.right[own], tape, self._last(block))
            except SingularBlockError as error:
                lost = [block.equations[i][0] for i in error.args[0]]
                holds = [row for row, _ in block.equations if row in self._reactions]
                raise singular_block(self.reduced, lost, block.nodes, holds) from None
        return (
            tape.expressions([term for term, _ in found]),
            self._finite(np.array([number for _, number in found])),
        )

    def _linearise(self, blocks: list[Block]) -> LinearEquations:
        """Linear equations for what to add to the present values of nodes."""
        incidence, linear = self.reduced.incidence, LinearEquations(blocks)
        numbers, orders = equations_of(blocks)
        for places, seen in incidence.alike(numbers, orders):
            self._template_equations(seen, places, linear)
        sums = np.flatnonzero(numbers >= incidence.first_sum)
        self._sum_equations(sums, numbers[sums], orders[sums], linear)
        return linear

    def _last(self, block: Block) -> dict[int, int]:
        """Equations of constraints that hold or slide, and the place of the reaction of each."""
        if not self._reactions:
            return {}
        place = {node: j for j, node in enumerate(block.nodes)}
        reactions = {i: self._reactions.get(row) for i, (row, _) in enumerate(block.equations)}
        try:
            return {i: place[node] for i, node in reactions.items() if node is not None}
        except KeyError:
            raise unheld(self.reduced, self._holds, self.of) from None

    def _sum_equations(
        self, sums: np.ndarray, numbers: np.ndarray, orders: np.ndarray, linear: LinearEquations
    ) -> None:
        """Enter coefficients of the unknowns in flow sums, and minus their residuals."""
        places, nodes, signs = self._sum_nodes(numbers, orders)
        terms = linear.tape.add_terms(-_pick(self._sx, nodes) * ca.DM(signs))
        factors = linear.tape.add_terms(ca.SX(ca.DM(signs)))
        parts = zip(sums[places].tolist(), nodes.tolist(), signs.tolist(), strict=True)
        for k, (i, node, sign) in enumerate(parts):
            total, number = linear.right[i]
            linear.right[i] = (total + terms[k], number - sign * self._number[node])
            linear.add(i, node, factors[k], CONSTANT, sign)

    def _template_equations(
        self, seen: Occurrence, places: np.ndarray, linear: LinearEquations
    ) -> None:
        """The same for several instances of one template equation, in one call."""
        nodes, residual = self.reduced.nodes_of(seen), seen.residual
        m, n = nodes.shape
        symbols, numbers = self._arguments(seen, nodes), self._numbers(seen, nodes)
        coefficients, value = residual.coefficients, residual.value
        partials = linear.tape.add_terms(ca.vec(coefficients(*symbols) * ca.DM(seen.signs.T)))
        sizes = self._finite(np.asarray(coefficients(*numbers)).reshape(n, m)).T * seen.signs
        rests = linear.tape.add_terms(ca.vec(-value(*symbols)))
        rest_sizes = -np.asarray(value(*numbers)).ravel()
        kinds = residual.kinds.tolist()
        for k, i in enumerate(places.tolist()):
            linear.right[i] = (rests[k], float(rest_sizes[k]))
            own = nodes[k].tolist(), partials[k * n : k * n + n], kinds, sizes[k].tolist()
            for node, partial, kind, size in zip(*own, strict=True):
                linear.add(i, node, partial, kind, size)


def _pick(vector: ca.SX, indices: np.ndarray) -> ca.SX:
    return vector[indices.tolist()] if len(indices) else ca.SX(0, 1)
