"""How likely a functional passes a limit when parameters scatter, and what makes it do so."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, Literal, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.ensembles.variants import Over
from lumped.errors import Interrupted, OptionError, SolverError
from lumped.support.arguments import checked
from lumped.timeloop.run_options import RunOptions
from lumped.tolerances.failure.directions import compare_directions
from lumped.tolerances.failure.form import DesignPoint, form, points_of, search_all
from lumped.tolerances.failure.limit import Limit
from lumped.tolerances.failure.reliability_outcome import Influence, Kind, Reliability
from lumped.tolerances.failure.samples import Sampled, around, centres, subset
from lumped.tolerances.failure.sorm import Curved, find_curvature
from lumped.tolerances.failure.unions import join_points
from lumped.tolerances.scene import Scattered, scene_of

_RUNS, _STARTS = 1000, 4
_PLANE = 0.1
"""Difference of ``1 + beta kappa`` from 1 up to which a limit counts as plane."""
_CURVED = (
    "the limit is curved beside the design point (1 + beta kappa = {:.3g} along one direction, 1 "
    "for a plane); compare with search='sorm'"
)

Search = Literal["form", "sorm", "importance", "subset"]


@checked
def reliability(
    what: Scattered,
    of: Any,
    *,
    over: Over,
    above: float | str | None = None,
    below: float | str | None = None,
    search: Search = "form",
    until: float | str | None = None,
    by: Iterable[Name] = (),
    runs: int | None = None,
    seed: int = 0,
    searches: int | None = None,
    rtol: float = 1e-6,
    workers: int | None = None,
    **options: Unpack[RunOptions],
) -> Reliability:
    """How likely a functional passes a limit when parameters scatter.

    The parameters are functions of independent standard normal variables. In the space of these
    the point of the limit nearest to the median is the most likely combination at which the limit
    is passed, the design point; its distance is the reliability index beta.

    ================ ===================================================== =======================
    search           probability from                                      does not apply
    ================ ===================================================== =======================
    ``"form"``       a plane limit at each design point, whose gradients   to a kink there
                     are exact
    ``"sorm"``       a paraboloid there, by exact second derivatives of    to a kink there, or a
                     modes, else by gradients around it                    limit that bends around
                                                                           the median
    ``"importance"`` samples around the design points                      where no gradient leads
                                                                           to the limit
    ``"subset"``     samples, level by level, without derivatives          to probabilities below
                                                                           1e-15
    ================ ===================================================== =======================

    Each says so where it does not apply.

    Parameters
    ----------
    what : System, Modes or OrderResponse
        A system, to be run for each set of parameters; or modes or an order response of the
        nominal drive, which are found again for each.
    of : functional
        From `lumped.functionals`, such as ``peak("shaft.tau")``; of modes `frequency`, `damping`
        and `clearance`; of an order response `order_peak` and `separation` too.
    over : mapping of name to distribution, or Correlated
        What scatters (see `lumped.distributions`).
    above, below : float or str
        The limit: the probability that the functional is above it, or below it. In the SI unit of
        the functional or with a unit; one of both.
    search : {"form", "sorm", "importance", "subset"}
        See above.
    until : float or str, optional
        For a system: end of each run, s.
    by : iterable of names, optional
        Parameters that do not scatter, by which beta is differentiated too.
    runs : int, optional
        Samples: of ``"importance"`` all, of ``"subset"`` those of each level; default is 1000.
    seed : int
        Of their random numbers.
    searches : int, optional
        Searches for design points: from the median, from opposite the point that is found, and from
        both sides of it; default is 4.
    rtol
        For a system, as for `ensemble`.
    workers : int, optional
        Threads, or processes for gradients; default is one for each core.
    **options : RunOptions
        For a system: of each run (see `RunOptions`).

    Returns
    -------
    Reliability

    Raises
    ------
    OptionError
        If an option makes no sense, something cannot scatter, or the functional has no derivative
        or depends on nothing that scatters.
    UnknownNameError
        If a name does not exist.
    UnitError
        If the limit has a unit of another dimension.
    ParameterError
        If a distribution is out of the range of its parameter.
    SolverError
        If no combination within reach passes the limit, or all do; or where the method does not
        apply.
    Interrupted
        After Ctrl-C; `partial` is the result of the first samples of ``"importance"``, or the
        levels that ``"subset"`` has reached, whose last probability is an upper estimate.

    Notes
    -----
    O. Ditlevsen, H. O. Madsen: Structural Reliability Methods. Wiley, 1996. Sources of the methods
    are in their modules (`lumped.tolerances.failure.form` and those beside it).
    """
    by = tuple(by)
    _check(search, runs, seed, searches, by)
    scene = scene_of(
        what,
        over=over,
        of=[of],
        until=until,
        rtol=rtol,
        workers=workers,
        analysis="reliability",
        **options,
    )
    limit, others = Limit(scene, above, below), scene.others(by)
    try:
        return _analyse(limit, search, others, runs or _RUNS, seed, searches or _STARTS)
    except KeyboardInterrupt as error:
        known = getattr(error, "partial", None)
        raise Interrupted(
            f"{limit.head}: interrupted after {limit.evaluations} evaluations",
            known if isinstance(known, Reliability | tuple) else None,
        ) from None


def _analyse(
    limit: Limit, search: Search, others: dict[str, float], runs: int, seed: int, searches: int
) -> Reliability:
    scene, (means, deviations) = limit.scene, limit.scene.moments
    stopped: Interrupted | None = None
    bent: tuple[Curved, ...] = ()
    if search in ("form", "sorm"):
        points = form(limit, searches=searches)
        bent = tuple(find_curvature(limit, point) for point in points) if search == "sorm" else ()
        sampled = _compute_probability(limit, points, bent)
    else:
        points, sampled, stopped = _sample_probability(limit, search, runs, seed, searches)
    found = Reliability(
        system=scene.system.name,
        event=limit.event,
        label=limit.label,
        unit=limit.unit,
        bound=limit.bound,
        method=search,
        names=scene.names,
        units=scene.parameter_units,
        means=means,
        deviations=deviations,
        sampled=replace(sampled, notes=(*scene.notes, *sampled.notes)),
        points=points,
        importance=_importance(limit, points),
        influences=_influences(limit, points, others, means, deviations),
        second_order=bent,
        evaluations=limit.evaluations,
        gradients=limit.gradients,
    )
    if stopped is not None:
        raise Interrupted(str(stopped), found)
    return found


def _check(
    search: str, runs: int | None, seed: int, searches: int | None, by: tuple[Name, ...]
) -> None:
    """Refuse options that belong to other methods, or make no sense."""
    is_sampled, has_points = search in ("importance", "subset"), search != "subset"
    if runs is not None and not is_sampled:
        raise OptionError(
            f"reliability: runs = {runs} is for samples; take search='importance' or "
            f"search='subset', or leave it out for {search!r}."
        )
    if runs is not None and runs < 100:
        raise OptionError(f"reliability: runs = {runs}: at least 100 samples are needed.")
    if seed < 0:
        raise OptionError(f"reliability: seed = {seed}: a whole number is needed, zero or more.")
    if searches is not None and (not has_points or searches < 1):
        raise OptionError(
            f"reliability: searches = {searches}: searches for design points, at least one; "
            "search='subset' has none."
        )
    if by and not has_points:
        raise OptionError(
            "reliability: by = is for derivatives at the design point, which search='subset' does "
            "not look for; take another method."
        )


def _compute_probability(
    limit: Limit, points: tuple[DesignPoint, ...], bent: tuple[Curved, ...]
) -> Sampled:
    """Probability from design points, of a curved limit if its curvatures are known."""
    each, bend = [one.tvedt for one in bent] or None, points[0].bend
    found = join_points(points, limit.is_kept_by_median, each)
    notes = (_CURVED.format(bend),) if not bent and abs(bend - 1) > _PLANE else ()
    return Sampled.from_computation(found, notes + compare_directions(limit, points, found))


def _sample_probability(
    limit: Limit, search: Search, runs: int, seed: int, searches: int
) -> tuple[tuple[DesignPoint, ...], Sampled, Interrupted | None]:
    """Design points, if there are any, a probability from samples, and what has cut these short."""
    stopped: Interrupted | None = None
    points: tuple[DesignPoint, ...] = ()
    notes: list[str] = []
    if search == "subset":
        found = subset(limit, runs, seed)
    else:
        every = search_all(limit, searches=searches)
        middle = centres(limit, every)
        try:
            points = points_of(limit, every)
        except SolverError as error:
            notes.append(f"{error} (the samples lie around the nearest points that were found)")
        try:
            found = around(limit, middle, runs, seed)
        except Interrupted as error:
            if not isinstance(error.partial, Sampled):
                raise
            found, stopped = error.partial, error
    if found.failed:
        notes.append(f"why one failed: {limit.reason}")
    return points, replace(found, notes=(*notes, *found.notes)), stopped


def _importance(limit: Limit, points: tuple[DesignPoint, ...]) -> np.ndarray:
    """Share of each parameter in the variance of the linearised functional, with its direction.

    A. Der Kiureghian: First- and second-order reliability methods, in: Engineering Design
    Reliability Handbook, CRC Press, 2005 (gamma for parameters that depend on each other).
    """
    if not points:
        return np.zeros(0)
    along = limit.scene.physical_slopes(points[0].u[None])[0]
    shares = points[0].slopes * np.linalg.norm(along, axis=1)
    found: np.ndarray = np.sign(shares) * shares**2 / (shares @ shares)
    return found


def _influences(
    limit: Limit,
    points: tuple[DesignPoint, ...],
    others: dict[str, float],
    means: np.ndarray,
    deviations: np.ndarray,
) -> tuple[Influence, ...]:
    """Derivatives of beta, and of the probability to first order."""
    if not points:
        return ()
    scores = np.array([(point.x - means) / deviations for point in points])
    shifted = [point.beta_by(point.slopes) for point in points]
    tables: list[tuple[Kind, tuple[str, ...], np.ndarray, np.ndarray]] = [
        ("mean", limit.scene.names, deviations, np.array(shifted)),
        ("deviation", limit.scene.names, deviations, scores * np.array(shifted)),
    ]
    if others:
        own = np.array([p.beta_by(limit.at_by_others(p.u, others)) for p in points])
        tables.append(("value", tuple(others), np.abs(list(others.values())), own))
    density = np.exp([-(point.beta**2) / 2 for point in points]) / np.sqrt(2 * np.pi)
    return tuple(
        Influence(name, kind, float(size), float(column[0]), float(-density @ column))
        for kind, names, sizes, betas in tables
        for name, size, column in zip(names, sizes, betas.T, strict=True)
    )
