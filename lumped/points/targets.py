"""What must hold at the start, met by free states and parameters."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Container

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import StartError
from lumped.flattening.residual import CONSTANT
from lumped.points.target_values import Matrix, target_values
from lumped.reduction.state_selection import RANK, select_dependent
from lumped.support.made_once import made_once
from lumped.timeloop.settings import close_settings

TOLERANCE = 1e-9
_ROUNDING = 1e-12
"""Largest miss that counts as rounding, relative to the terms that cancel."""
_INFINITE = 1e12
"""Size of unknowns that went to infinity, as a speed that a slider shall have at a dead centre."""
_SMALL = 1e-4  # part of a way, or of what is wanted


class Targets:
    """Given quantities that are no states, and initial equations.

    Parameters
    ----------
    system : System
        From `assemble`.
    given : dict of int to (int, float)
        Unknown and value wanted for each node; the complement of an unknown stands for its rate.
    fixed : dict of int to int
        Unknown that fixes each of those states that must keep their values.
    free : list of int
        Places of the parameters to be found.
    guesses : ndarray
        Where the search for implicit quantities begins.
    time : float
        Instant, s.
    text : callable
        An unknown with its start value, as texts show it.

    Attributes
    ----------
    modes : ndarray
        Positions of all conditions and holds in which the targets are met.
    have_positions : bool
        Whether the targets depend on them.
    """

    def __init__(
        self,
        system: System,
        given: dict[int, tuple[int, float]],
        fixed: dict[int, int],
        free: list[int],
        guesses: np.ndarray,
        time: float,
        text: Callable[[int], str],
    ) -> None:
        self.system, self.fixed, self.free = system, fixed, free
        self.guesses, self.time, self._given_text = guesses, time, text
        self.modes = np.zeros(0)
        self.unknowns = [unknown for unknown, _ in given.values()]
        self.count = len(system.structure.reduced.states)
        self._evaluate = found = target_values(system, tuple(given), tuple(free))
        self.places, self.have_positions = found.places, found.has_positions
        self._last: tuple[np.ndarray, np.ndarray, tuple[np.ndarray, Matrix]] | None = None
        wanted = [value for _, value in given.values()]
        self.wanted = np.array(wanted + [0.0] * len(self.places))

    def meet(self, x: np.ndarray, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States and parameters that meet all targets in these positions, found from those given.

        Raises
        ------
        StartError
            If there are none, or free parameters are not determined.
        """
        self.theta = theta.copy()
        begin = np.concatenate([x, theta[self.free]])
        met = self._directly(begin)
        if met is None:
            begin, columns, rows = self._generic(begin)
            last, found = self._newton(begin, self.wanted, columns, rows)
            continued = None if found else self._continue(begin, columns, rows)
            met = last if continued is None else continued
            self._check(met, rows)
        return met[: self.count], self._parameters(met)

    def slopes(
        self, x: np.ndarray, S: np.ndarray, seed: np.ndarray, wanted: np.ndarray
    ) -> np.ndarray:
        """Derivatives of states that meet the targets, as the implicit function theorem has them.

        Parameters
        ----------
        x : ndarray, shape (n,)
            States that meet the targets.
        S : ndarray, shape (n, k)
            Derivatives of those that the targets do not determine.
        seed : ndarray, shape (parameters, k)
            Derivatives of the parameters.
        wanted : ndarray, shape (given, k)
            Derivatives of the wanted values.
        """
        _, matrix = self._at(x)
        columns, rows = self._columns(matrix)
        settings = self._settings(x, self.theta)
        by_parameters = self._evaluate.by_parameters(x, self.theta, self.time, settings).sparse()
        found = S.copy()
        found[columns] = 0.0
        miss = -(by_parameters @ seed) - matrix @ found
        miss[: len(wanted)] += wanted
        part = scipy.sparse.csc_array(matrix)[rows][:, columns].toarray()
        found[columns] = np.linalg.lstsq(part, miss[rows])[0]
        return found

    def find_idle(self, x: np.ndarray, theta: np.ndarray) -> tuple[np.ndarray, bool, int, float]:
        """Which targets are missed, and whether there is one of them that nothing changes.

        Then how many there are that nothing changes, met or not, and how far all are missed.
        """
        self.theta = theta
        z = np.concatenate([x, theta[self.free]])
        value, matrix = self._at(z)
        miss = value - self.wanted
        missed = self._mark_missed(miss, self.wanted, matrix, z)
        usable = self._columns(matrix, complain=False)[1]
        far = float(np.linalg.norm(miss / np.maximum(1.0, np.abs(self.wanted))))
        return missed, bool(np.delete(missed, usable).any()), len(miss) - len(usable), far

    def residual(self, x: np.ndarray, theta: np.ndarray) -> tuple[float, str]:
        """How far the worst target is missed, as `_miss` says, and its name if any is missed."""
        self.theta = theta
        return self._residual(np.concatenate([x, theta[self.free]]))

    def _residual(self, z: np.ndarray) -> tuple[float, str]:
        miss = self._miss(z)
        far, worst = float(miss.max(initial=0.0)), -1
        if not (far <= TOLERANCE and np.abs(z).max(initial=0.0) <= _INFINITE):  # nan too
            value, matrix = self._at(z)
            missed = self._mark_missed(value - self.wanted, self.wanted, matrix, z)
            worst = int(np.argmax(np.where(missed, miss, -1.0))) if missed.any() else -1
        return far, self._text(worst) if worst >= 0 else ""

    @property
    def value(self) -> ca.SX:
        """What the targets are, as an expression of all states, parameters, time and settings."""
        return self._evaluate.expression

    def regular(self, z: np.ndarray) -> tuple[list[int], list[int]]:
        """Targets and as many states that they determine near states that meet them."""
        columns, rows = self._columns(self._at(z)[1])
        return rows.tolist(), list(columns)

    def _parameters(self, z: np.ndarray) -> np.ndarray:
        theta = self.theta.copy()
        theta[self.free] = z[self.count :]
        return theta

    def _at(self, z: np.ndarray) -> tuple[np.ndarray, Matrix]:
        """What the targets are, and their derivatives."""
        if self._last is None or self._last[0] is not z or self._last[1] is not self.modes:
            x, theta = z[: self.count], self._parameters(z)
            found = self._evaluate(x, theta, self.time, self._settings(x, theta))
            self._last = z, self.modes, found
        return self._last[2]

    def _miss(self, z: np.ndarray) -> np.ndarray:
        """How far each target is missed, relative to what is wanted if that is above one."""
        x, theta = z[: self.count], self._parameters(z)
        value = self._evaluate.values(x, theta, self.time, self._settings(x, theta))
        miss: np.ndarray = np.abs(value - self.wanted) / np.maximum(1.0, np.abs(self.wanted))
        return miss

    def _settings(self, x: np.ndarray, theta: np.ndarray) -> np.ndarray:
        used = x[self.system.structure.in_use]
        return close_settings(self.system, used, theta, self.time, self.modes, self.guesses)

    @staticmethod
    def _mark_missed(
        miss: np.ndarray, goal: np.ndarray, matrix: Matrix, z: np.ndarray
    ) -> np.ndarray:
        size = np.maximum(1.0, np.abs(goal))
        rounding = np.minimum(_ROUNDING * abs(matrix) @ abs(z), _SMALL * size)
        missed: np.ndarray = ~(np.abs(miss) <= np.maximum(TOLERANCE * size, rounding))
        missed |= (abs(matrix) > 0) @ (abs(z) > _INFINITE).astype(float) > 0
        return missed

    def _directly(self, begin: np.ndarray) -> np.ndarray | None:
        """Newton's method with the unknowns that determine the targets where it begins."""
        if not self.free and self._miss(begin).max(initial=0.0) <= _ROUNDING:
            return begin
        columns, rows = self._columns(self._at(begin)[1], complain=False)
        if not set(range(self.count, self.count + len(self.free))) <= set(columns):
            return None
        last, found = self._newton(begin, self.wanted, columns, rows)
        return last if found and not self._residual(last)[1] else None

    def _generic(self, begin: np.ndarray) -> tuple[np.ndarray, list[int], np.ndarray]:
        """A point nearby where nothing vanishes by chance, and what determines the targets there.

        At a dead centre, or for a stiffness without twist, the first guess tells too little.
        """
        rng = np.random.default_rng(5)
        moved = 0.1 * rng.uniform(0.5, 1.5, len(begin))
        moved[self.count :] *= np.abs(begin[self.count :]) + 0.1
        moved[list(self.fixed)] = 0.0
        columns = self._columns(self._at(begin + moved)[1], complain=False)[0]
        moved[np.setdiff1d(np.arange(len(begin)), columns)] = 0.0
        return (begin + moved, *self._columns(self._at(begin + moved)[1]))

    def _newton(
        self,
        begin: np.ndarray,
        goal: np.ndarray,
        columns: list[int],
        rows: np.ndarray,
        most: int = 50,
    ) -> tuple[np.ndarray, bool]:
        """The last point reached, and whether these targets have these values there."""
        z = last = begin
        for _ in range(most):
            try:
                value, matrix = self._at(z)
            except StartError:  # a linkage that cannot be closed here
                break
            last, miss = z, value - goal
            if not self._mark_missed(miss, goal, matrix, z)[rows].any():
                return z, True
            step = _solve_equations(matrix[rows][:, columns], miss[rows])
            if not np.isfinite(step).all():
                break
            z = z.copy()
            z[columns] -= step
        return last, False

    def _continue(
        self, begin: np.ndarray, columns: list[int], rows: np.ndarray
    ) -> np.ndarray | None:
        """The same by moving the wanted values from what they are to what they shall be."""
        z, reached, length = begin, 0.0, 0.25
        first = self._at(begin)[0]
        while reached < 1.0:
            trial = min(1.0, reached + length)
            goal = first + trial * (self.wanted - first)
            last, found = self._newton(z, goal, columns, rows, most=8)
            if found:
                z, reached, length = last, trial, 2 * length
            elif length < _SMALL:
                return None
            else:
                length /= 4
        return z

    def _columns(self, matrix: Matrix, complain: bool = True) -> tuple[list[int], np.ndarray]:
        """Unknowns that the targets determine, the least wanted first, and targets that do so."""
        key = (matrix[self._evaluate.entries].tobytes(), tuple(self.fixed))
        known = self._evaluate.known
        if known is not None and known[0] == key and not self.free:
            return known[1]
        dependent, usable = find_determined(self.system, matrix, self.fixed, self._evaluate.entries)
        for k, place in enumerate(self.free):
            if complain and self.count + k not in dependent:
                name = self.system.structure.parameters.free_names[place]
                raise StartError(
                    f"The free parameter {name} is not determined by the start values. Give one "
                    "more start value or initial equation that depends on it, for example an "
                    "acceleration."
                )
        self._evaluate.known = key, (dependent, usable)
        return dependent, usable

    def _text(self, row: int) -> str:
        if row < len(self.unknowns):
            return self._given_text(self.unknowns[row])
        place = self.places[row - len(self.unknowns)]
        return f"the initial equation {self.system.structure.flat.initial_text(*place)}"

    def _check(self, z: np.ndarray, searched: np.ndarray) -> None:
        """Refuse the start if a target is missed."""
        value, matrix = self._at(z)
        miss = value - self.wanted
        missed = np.flatnonzero(self._mark_missed(miss, self.wanted, matrix, z))
        if not len(missed):
            return
        matrix = scipy.sparse.csc_array(matrix)
        unsearched = np.setdiff1d(missed, searched)
        row = int(unsearched[0] if len(unsearched) else missed[0])
        given = row < len(self.unknowns)
        text = self._text(row)
        if row in searched:
            raise StartError(
                f"No start state was found near the defaults with {text}. Give start values of "
                "the angles or positions near the ones that are meant."
            )
        touching = matrix[[row]].tocoo()
        if not touching.nnz and given:
            unknown = self.unknowns[row]
            sign = float(self.system.structure.reduced.aliases.signs[max(unknown, ~unknown)])
            raise StartError(
                f"{text} cannot hold: supports, sources or loads of the model make it "
                f"{sign * value[row]:.6g} at the start. Remove the start value, or change them."
            )
        if not touching.nnz:
            raise StartError(
                f"T{text[1:]} cannot hold: no state or free parameter changes it, and its sides "
                f"differ by {value[row]:.6g}. Remove it, or change the model."
            )
        others = self._find_repeated(matrix, row)
        held = np.unique(matrix[[row, *others]].tocoo().col)
        involved = [self._given_text(self.fixed[j]) for j in held.tolist() if j in self.fixed]
        involved += [self._text(i) for i in others]
        names = ", ".join(involved[:6]) + f" and {len(involved) - 6} more" * (len(involved) > 6)
        head = "Start values contradict each other" if given else "Too much is asked of the start"
        raise StartError(
            f"{head}: {text} cannot hold together with {names or 'the rest of the model'}. Give "
            f"fewer start values{'' if given else ' or initial equations'}, or make them fit."
        )

    def _find_repeated(self, matrix: scipy.sparse.csc_array, row: int) -> list[int]:
        """Targets of which multiples add up to the effect of one on what is not fixed."""
        rows = np.setdiff1d(np.arange(matrix.shape[0]), row)
        movable = matrix[:, np.setdiff1d(np.arange(matrix.shape[1]), list(self.fixed))].T
        wanted = movable[:, [row]].toarray().ravel()
        solved = scipy.sparse.linalg.lsqr(movable[:, rows], wanted, atol=1e-12, btol=1e-12)
        share = np.abs(solved[0])
        return list(rows[share > 1e-6 * share.max(initial=0.0)].tolist())


def find_determined(
    system: System,
    matrix: Matrix,
    fixed: Container[int],
    entries: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[list[int], np.ndarray]:
    """Unknowns that targets determine, the least wanted first, and targets that do so.

    Parameters
    ----------
    system : System
        From `assemble`.
    matrix : array, shape (targets, states + free parameters)
        Derivatives of the targets.
    fixed : container of int
        States that are given.
    entries : tuple of ndarray, optional
        Rows and columns of the derivatives that are not always zero.
    """
    where = np.nonzero(matrix) if entries is None else entries
    rows: list[dict[int, tuple[float, int]]] = [{} for _ in range(matrix.shape[0])]
    places = (k.tolist() for k in where)
    for i, j, v in zip(*places, matrix[where].tolist(), strict=True):
        if j not in fixed and v:
            rows[i][j] = (v, CONSTANT)
    states = system.structure.reduced.states
    rank = [_rank(system, n) for n in states] + [-1] * (matrix.shape[1] - len(states))
    dependent, _, unused = select_dependent(rows, np.array(rank))
    return dependent, np.setdiff1d(np.arange(matrix.shape[0]), unused)


def _rank(system: System, node: int) -> int:
    """Wish to stay at its default; slip speeds yield to the speeds of bodies."""
    unknown = system.structure.members.get(node)
    if unknown is None or node in _slips(system):
        return RANK["avoid"]
    return RANK[system.structure.tree.quantity(unknown).wish]


@made_once
def _slips(system: System) -> set[int]:
    """Speeds that holds stop and that are not those of a flange."""
    reduced, tree = system.structure.reduced, system.structure.tree
    held = {node for node in system.switching.speeds if node >= 0}
    classes = {reduced.class_and_order(node)[0]: node for node in held}
    for part in tree.instances if held else ():
        for i, quantity in enumerate(part.layout.quantities):
            if quantity.kind == "potential":
                number = int(reduced.aliases.classes[part.first_unknown + i])
                classes.pop(number, None)
    return set(classes.values())


def _solve_equations(matrix: Matrix, right: np.ndarray) -> np.ndarray:
    """Solution of linear equations; not finite where there is none."""
    if isinstance(matrix, np.ndarray):
        try:
            return np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            return np.full(len(right), np.nan)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", scipy.sparse.linalg.MatrixRankWarning)
        return np.atleast_1d(scipy.sparse.linalg.spsolve(scipy.sparse.csc_array(matrix), right))
