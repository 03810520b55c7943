"""The most likely combination of parameters at which a limit is exceeded (design point)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy

from lumped.errors import OptionError, SolverError
from lumped.numerics.nearest_points import FURTHEST, Search, is_same, search_together
from lumped.support.arrays import Real
from lumped.tolerances.failure.limit import Limit

_NEAR = (1e-2, 1e-4)
"""Distances from a design point at which the normal is compared with itself."""
_TURNED = 0.1
"""Difference of two normals that is no kink yet."""
_ALIKE = 2.5e-3
"""Difference of the cosine of two directions from 1 below which they are one."""
_SPHERE = 1e-3
"""Difference of ``1 + beta kappa`` from 0 up to which a limit counts as a sphere."""
_AT_MEDIAN = 1e-6
"""Distance of a limit through the median."""
_AROUND = 16
"""Directions to both sides of which is looked for the limit where no search has met it."""
_STEP, _BEYOND = 0.1, 3.7
"""Distance of places on a line at which is looked for crossings, and how far beyond a point, in
squares: a thousandth of its probability lies there."""
_BESIDE = 0.01, 0.03
"""And how far beside a crossing that was found."""
_ROUNDS, _GOOD = 6, 5e-3
"""Evaluations by which a crossing is found between two of them, and distance, relative to that from
the median, below which crossings are one."""


@dataclass(frozen=True, eq=False)
class DesignPoint:
    """The most likely combination of parameters at a limit, in a neighbourhood.

    Attributes
    ----------
    beta : float
        Its distance from the median in standard normal space, the reliability index of Hasofer and
        Lind; negative if the median exceeds the limit.
    u : ndarray, shape (d,)
        The point in standard normal space.
    alpha : ndarray, shape (d,)
        Direction from the median in which the limit is exceeded, of length one.
    x : ndarray, shape (d,)
        Parameters there, in SI units.
    slopes : ndarray, shape (d,)
        Derivatives of the excess over the limit by the parameters.
    steepness : float
        Growth of the excess over a unit of standard normal space, along `alpha`.
    bend : float
        ``1 + beta kappa`` with the curvature kappa of the limit along one direction: 1 for a plane.
    """

    beta: float
    u: Real
    alpha: Real
    x: Real
    slopes: Real
    steepness: float
    bend: float

    @property
    def probability(self) -> float:
        """That the limit is exceeded, if it were plane in standard normal space."""
        return float(scipy.special.ndtr(-self.beta))

    def beta_by(self, excess_by: Real) -> Real:
        """Derivatives of beta, from those of the excess over the limit at the point itself.

        Parameters
        ----------
        excess_by : ndarray
            Derivatives by anything, with the variables of standard normal space held.
        """
        return -excess_by / self.steepness


def form(limit: Limit, begin: Real | None = None, searches: int = 4) -> tuple[DesignPoint, ...]:
    """Design points, the nearest to the median first.

    Parameters
    ----------
    limit : Limit
        What must not be exceeded.
    begin : ndarray, shape (d,), optional
        Where the first search begins in standard normal space, such as at the point of a similar
        design; default is the median.
    searches : int
        Number of searches. The second begins opposite the point that the first has found, two at
        right angles to it, the others in pairs anywhere. Further ones begin where the limit is
        crossed on the lines through what they find.

    Raises
    ------
    SolverError
        If the limit is not reached within a distance of 8, has a kink at a design point, or
        gradients fail.
    OptionError
        If the functional depends on none of the parameters.
    """
    return points_of(limit, search_all(limit, begin, searches))


def points_of(limit: Limit, every: Sequence[Search]) -> tuple[DesignPoint, ...]:
    """Design points that searches have found, checked; errors as for `form`."""
    found = [search for search in every if search.is_found]
    if not found:
        raise nothing_found(limit, every)
    points: list[DesignPoint] = []
    saddle = ""
    for search in sorted(found, key=lambda search: float(np.linalg.norm(search.u))):
        if any(_is_one(p, search) for p in points):
            continue
        point = _design_point(limit, search)
        if point.bend > _SPHERE:
            points.append(point)
        else:
            saddle = limit.combination(point.u)
    if not points:
        raise SolverError(
            f"{limit.head}: at {saddle} the limit bends around the median as a sphere or more, so "
            "combinations beside this one are as likely or more, and none that is most likely was "
            "found. Take more searches, or search='subset'."
        )
    if not any(is_entered(point.beta, limit.is_kept_by_median) for point in points):
        state, other = ("kept", "exceeded")[:: 1 if limit.is_kept_by_median else -1]
        raise SolverError(
            f"{limit.head}: the limit is {state} at the median, and at "
            f"{limit.combination(points[0].u)} a region ends in which it is {other}; where this "
            "region begins was not found. Take more searches, or search='subset'."
        )
    return tuple(points)


def _is_one(point: DesignPoint, search: Search) -> bool:
    """Whether a search has come to a point again, and not to another side of a narrow band."""
    off = search.u - point.u
    is_near = abs(point.alpha @ off) < _GOOD * (1 + abs(point.beta))
    return bool(is_near and point.alpha @ search.slope > 0 and is_same(point.u, search.u))


def search_all(limit: Limit, begin: Real | None = None, searches: int = 4) -> list[Search]:
    """Searches for design points, each at its end; arguments as for `form`."""
    first = np.zeros(limit.count) if begin is None else begin
    every = search_together(limit.slopes, [first])
    if searches > 1:
        known = [search.u for search in every if search.is_found and _is_nearest(limit, search)]
        every += search_together(limit.slopes, _others(every[0], searches - 1), known)
    return every + search_together(limit.slopes, _find_crossings(limit, every))


def _is_nearest(limit: Limit, search: Search) -> bool:
    """Whether the limit is smooth at a point and bends around the median less than a sphere."""
    try:
        return _design_point(limit, search).bend > _SPHERE
    except SolverError:
        return False


def _find_crossings(limit: Limit, every: Sequence[Search]) -> list[Real]:
    """Other crossings of the limit on the lines through the median and what was found.

    A band that is passed has a far side there, and one that ends at what was found a near side.
    """
    known: list[Real] = []
    begins: list[Real] = []
    for search in every:
        far = float(np.linalg.norm(search.u))
        if not search.is_found or far < _AT_MEDIAN:
            continue
        along = search.u / far
        if any(abs(along @ u) > (1 - _ALIKE) * np.linalg.norm(u) for u in known):
            continue
        known.append(search.u)
        places, excess = _scan_line(limit, along, far)
        is_other = (places[1:] < far) | (places[:-1] > far)
        k = np.flatnonzero(is_other & np.diff(excess > 0) & np.isfinite(np.diff(excess)))
        ends = places[k], places[k + 1], excess[k], excess[k + 1]
        roots = find_roots(partial(_values_along, limit, along), *ends, _ROUNDS)
        far_known = [found.u for found in every if found.is_found]
        begins += [u for u in np.outer(roots, along) if not any(_meets(u, v) for v in far_known)]
    return begins


def _values_along(limit: Limit, along: Real, far: Real) -> Real:
    return limit.values(np.outer(far, along))


def _scan_line(limit: Limit, along: Real, far: float) -> tuple[Real, Real]:
    """Places on a line through the median, and the excess there.

    Further places are those where the excess comes next to zero, as it may cross it twice there.
    """
    last = min(float(np.hypot(far, _BEYOND)), FURTHEST)
    beside = far + np.outer((-1, 1), _BESIDE).ravel()
    x = np.unique([*np.linspace(-last, last, 2 * int(np.ceil(last / _STEP)) + 1), *beside])
    y = _values_along(limit, along, x)
    rate = np.diff(y) / np.diff(x)
    # between two rates that turn away from zero
    turns = 1 + np.flatnonzero((rate[:-1] * y[1:-1] < 0) & (rate[1:] * y[1:-1] > 0))
    bent = (rate[turns] - rate[turns - 1]) / (x[turns + 1] - x[turns - 1])
    nearest = (x[turns] + x[turns - 1]) / 2 - rate[turns - 1] / (2 * bent)
    if not len(turns):
        return x, y
    x, order = np.unique(np.concatenate([x, nearest]), return_index=True)
    return x, np.concatenate([y, _values_along(limit, along, nearest)])[order]


def _meets(u: Real, other: Real) -> bool:
    """Whether two points where the limit is crossed are one."""
    return bool(np.linalg.norm(u - other) < _GOOD * (1 + np.linalg.norm(u)))


def find_roots(
    at: Callable[[Real], Real], low: Real, high: Real, below: Real, above: Real, rounds: int
) -> Real:
    """Roots between places on both sides of them, by regula falsi (Illinois).

    Parameters
    ----------
    at : callable
        Values at one place on each of n lines.
    low, high, below, above : ndarray, shape (n,)
        Places and the values there.
    rounds : int
    """
    for _ in range(rounds if len(low) else 0):
        middle = low + (high - low) * np.clip(below / (below - above), 0.02, 0.98)
        value = at(middle)
        value = np.where(np.isnan(value), below, value)
        is_low = (value > 0) == (below > 0)
        # the end that stays counts half
        low, high = np.where(is_low, middle, low), np.where(is_low, high, middle)
        below, above = (
            np.where(is_low, value, below / 2),
            np.where(is_low, above / 2, value),
        )
    found: Real = low + (high - low) * below / (below - above)
    return found


def is_entered(beta: float, is_kept: bool) -> bool:
    """Whether the state of the median ends at a plane, going out; else it comes back there."""
    return abs(beta) < _AT_MEDIAN or (beta > 0) == is_kept


def _others(search: Search, count: int) -> list[Real]:
    """Where further searches begin: opposite a point, at right angles to it, and anywhere."""
    far = float(np.linalg.norm(search.u)) if search.is_found else 0.0
    along = search.u / far if far else np.zeros(len(search.u))
    begins = [-search.u] if far else []
    random = np.random.default_rng(0)
    while len(begins) < count:
        aside = random.standard_normal(len(along))
        if len(along) > 1 and len(begins) < 3:
            aside -= along * (along @ aside)
        aside *= max(far, 1.0) / float(np.linalg.norm(aside))
        begins += [aside, -aside]
    return begins[:count]


def _design_point(limit: Limit, search: Search) -> DesignPoint:
    steepness = float(np.linalg.norm(search.slope))
    alpha = search.slope / steepness
    u = alpha * float(alpha @ search.u - search.g / steepness)
    beta = float(alpha @ u)
    x, slopes = limit.at(search.u)
    x = limit.scene.physical(u[None])[0]
    bend = 1 + beta * _measure_bend(limit, search.u)
    return DesignPoint(beta, u, alpha, x, slopes, steepness, bend)


def nothing_found(limit: Limit, every: Sequence[Search]) -> OptionError | SolverError:
    """Why no search has found a point."""
    known = [search for search in every if np.isfinite(search.g)]
    if not known:
        return SolverError(
            f"{limit.head}: no derivatives at the median of the parameters: {limit.reason} "
            "search='subset' needs none."
        )
    if all(search.is_flat for search in known):
        return OptionError(
            f"{limit.head} does not depend on {', '.join(limit.scene.names)} near their median: "
            "all derivatives are zero. Vary something else, or take search='subset', which needs "
            "no derivatives."
        )
    if not limit.is_crossed:
        _look_around(limit, known)
    if not limit.is_crossed:
        return limit.explain_unreached(f"within a distance of {FURTHEST:g}")
    for search in known:
        if search.is_on_surface:
            _measure_bend(limit, search.u)
    return SolverError(
        f"{limit.head}: no design point was found in {sum(s.count for s in every)} evaluations. "
        "Take tighter rtol, or search='subset', which needs no design point."
    )


def _look_around(limit: Limit, known: Sequence[Search]) -> None:
    """Evaluate the limit beyond the ends of searches, which a kink may have stopped, and around."""
    along = np.random.default_rng(0).standard_normal((_AROUND, limit.count))
    ends = np.array([search.u for search in known if search.u.any()]).reshape(-1, limit.count)
    beyond = [far * ends for far in (1.02, 1.1, 1.5)]
    ring = along / np.linalg.norm(along, axis=1, keepdims=True)
    radii = np.linspace(0, FURTHEST, 5)[1:]
    points = np.concatenate([*beyond, *(sign * r * ring for r in radii for sign in (1, -1))])
    limit.values(points[np.linalg.norm(points, axis=1) <= FURTHEST + _AT_MEDIAN])


def _measure_bend(limit: Limit, u: Real) -> float:
    """Curvature of the limit at a point, along one direction; it bends to the median if negative.

    Raises
    ------
    SolverError
        If the normal of the limit turns at once, with both normals.
    """
    aside = np.random.default_rng(1).standard_normal(len(u))
    aside /= float(np.linalg.norm(aside))
    bend = 0.0
    for far in _NEAR:
        _, slopes = limit.slopes(np.array([u - far * aside, u + far * aside]))
        if not np.isfinite(slopes).all():
            raise SolverError(
                f"{limit.head} has no derivative beside its design point at "
                f"{limit.combination(u)}: {limit.reason} search='subset' needs none."
            )
        sizes = np.linalg.norm(slopes, axis=1, keepdims=True)
        normals = slopes / np.maximum(sizes, np.finfo(float).tiny)
        middle = normals.mean(axis=0)
        tangent = aside - middle * (middle @ aside) / (middle @ middle)
        turned = normals[1] - normals[0]
        bend = -float(tangent @ turned) / (2 * far * float(tangent @ tangent) or 1.0)
        if np.linalg.norm(turned) < _TURNED:
            return bend
    first, second = (", ".join(f"{v:.3g}" for v in normal) for normal in normals)
    raise SolverError(
        f"{limit.head} has a kink at its design point, {limit.combination(u)}: on its two sides "
        f"the normals of the limit are ({first}) and ({second}), so beta says nothing about the "
        "probability. Take search='importance' or search='subset'."
    )
