"""Parameters from measured curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.optimisation.design import Bounds
from lumped.optimisation.fit_search import Curves, FitSearch
from lumped.optimisation.identification import Identification
from lumped.support.arguments import checked
from lumped.timeloop.run_options import RunOptions


@checked
def identify(
    system: System,
    *,
    vary: Mapping[str, Bounds],
    t: Sequence[float] | np.ndarray,
    measured: Curves,
    sigma: Mapping[str, float] | Mapping[Name, float] | None = None,
    level: float = 0.95,
    rtol: float = 1e-8,
    searches: int = 1,
    **options: Unpack[RunOptions],
) -> Identification:
    """Parameters and start values for which runs fit measured curves best.

    Least squares by Gauss and Newton's method within a trust region, with exact derivatives from
    `sensitivity`, across events too.

    Parameters
    ----------
    system : System
        From `assemble`.
    vary : mapping of name to (low, high)
        Parameters, or start values of states, and their bounds; the search begins at the values
        of the model, of `parameters` or of `start`, and they are its scale.
    t : array_like, shape (n,)
        Instants of the measurement, s, from the begin of the runs on, increasing.
    measured : mapping of name to array_like, shape (n,)
        Curves of quantities, or of expressions of quantities.
    sigma : mapping of name to float, optional
        Standard deviation of the noise of each curve, in its unit. If not given, each curve counts
        relative to its root mean square, and the noise is estimated from what does not fit.
    level : float
        Probability of the confidence intervals.
    rtol : float
        Relative tolerance of the runs. Tighter than elsewhere: near the best fit a search compares
        runs that hardly differ.
    searches : int
        Number of searches; all but the first begin at the best of 128 designs each between the
        bounds, and the best result counts. Where another minimum fits as well, `doubts` says so.
    **options : RunOptions
        Of each run (see `RunOptions`).

    Returns
    -------
    Identification

    Raises
    ------
    OptionError
        If curves, instants, bounds or names make no sense.
    OptimisationError
        If the search does not end.
    SolverError
        If a run fails, or has no derivative.

    Notes
    -----
    Covariance ``s^2 (J^T J)^-1`` (Bard, Nonlinear Parameter Estimation, 1974, ch. 7).
    """
    if not 0 < level < 1:
        raise OptionError(f"identify: level = {level:g} must lie between 0 and 1.")
    if searches < 1:
        raise OptionError(f"identify: searches = {searches}: at least one search is needed.")
    search = FitSearch(system, vary, t, measured, sigma, rtol, options)
    return search.search_fit(level, searches)
