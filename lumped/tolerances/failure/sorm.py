"""Probability that a limit which is curved at its design point is exceeded (second order)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from lumped.errors import SolverError
from lumped.support.arrays import Real
from lumped.tolerances.evaluated import curvatures_along
from lumped.tolerances.failure.form import DesignPoint
from lumped.tolerances.failure.limit import Limit
from lumped.tolerances.scene import Scene

_WIDE = 12.0
"""Beyond this imaginary part the integrand has fallen below 1e-30 of itself."""

_SCORE = 1e-4
"""Difference of scores over which second derivatives of parameters are taken."""

Source = Literal["second derivatives", "gradients around it"]


@dataclass(frozen=True, eq=False)
class Curved:
    """A limit at one design point to second order.

    Attributes
    ----------
    curvatures : ndarray, shape (d - 1,)
        Principal curvatures of the limit in standard normal space; positive where it bends away
        from the median.
    breitung, hohenbichler, tvedt : float
        Probability that the limit is exceeded: asymptotic, improved, and exact for the paraboloid.
    source : {"second derivatives", "gradients around it"}
        From what the curvatures follow.
    """

    curvatures: Real
    breitung: float
    hohenbichler: float
    tvedt: float
    source: Source


def find_curvature(limit: Limit, point: DesignPoint) -> Curved:
    """A limit at a design point to second order.

    Raises
    ------
    SolverError
        If the limit bends around the median more than a sphere, or gradients fail.

    Notes
    -----
    K. Breitung: Asymptotic approximations for multinormal integrals. Journal of Engineering
    Mechanics 110 (1984) 357-366. M. Hohenbichler, R. Rackwitz: Improvement of second-order
    reliability estimates by importance sampling. Journal of Engineering Mechanics 114 (1988)
    2195-2199. L. Tvedt: Distribution of quadratic forms in normal space. Journal of Engineering
    Mechanics 116 (1990) 1183-1197.
    """
    bent, source = _derive_twice(limit, point)
    kappa = np.linalg.eigvalsh(-bent / point.steepness).astype(float)
    beta = point.beta
    # of the side on which the median does not lie
    sign = 1.0 if beta >= 0 else -1.0
    rare = float(scipy.special.ndtr(-abs(beta)))
    hazard = math.exp(-beta * beta / 2) / math.sqrt(2 * math.pi) / rare
    least = min((1 + slope * kappa).min(initial=np.inf) for slope in (beta, sign * hazard))
    if least <= 0:
        raise SolverError(
            f"{limit.head}: at the design point {limit.combination(point.u)} the limit bends "
            f"around the median nearly as a sphere or more (1 + beta kappa = {least:.3g}), so it "
            "has no probability to second order. Take search='importance' or search='subset'."
        )
    estimates = [rare / math.sqrt(np.prod(1 + slope * kappa)) for slope in (beta, sign * hazard)]
    plain, better = (p if sign > 0 else 1 - p for p in estimates)
    return Curved(kappa, plain, better, paraboloid(beta, kappa), source)


def paraboloid(beta: float, kappa: Sequence[float] | Real) -> float:
    """Probability of ``u_n - sum kappa_i v_i^2 / 2 > beta``, all variables standard normal.

    The inverse of the moment generating function, integrated along a parallel to the imaginary axis
    through the saddle point.
    """
    bends = np.asarray(kappa, dtype=float)
    end = 1 / max(float(-bends.min(initial=0.0)), 1e-3)

    def exponent(s: complex) -> complex:
        whole: complex = s * s / 2 - s * beta - np.log(s) - np.log(1 + bends * s).sum() / 2
        return whole

    saddle = float(
        scipy.optimize.minimize_scalar(
            lambda s: exponent(s).real, bounds=(1e-9 * end, (1 - 1e-9) * end), method="bounded"
        ).x
    )
    top = exponent(saddle).real
    share, _ = scipy.integrate.quad(
        lambda y: np.exp(exponent(complex(saddle, y)) - top).real,
        0.0,
        _WIDE,
        epsabs=1e-12,
        limit=200,
    )
    return float(share * math.exp(top) / math.pi)


def _derive_twice(limit: Limit, point: DesignPoint) -> tuple[Real, Source]:
    """Second derivatives of the excess along the limit, by the standard normal variables."""
    around = scipy.linalg.null_space(point.alpha[None]).T
    own = limit.curvature(point.x)
    if own is not None:
        bent = _derive_by_scores(limit.scene, point, own)
        return around @ bent @ around.T, "second derivatives"
    if not len(around):
        return np.zeros((0, 0)), "gradients around it"
    found = curvatures_along(lambda u: limit.slopes(u)[1], point.u, around, limit.scene.error)
    if not np.isfinite(found).all():
        raise SolverError(
            f"{limit.head}: no derivatives around the design point {limit.combination(point.u)}: "
            f"{limit.reason} search='subset' needs none."
        )
    return found, "gradients around it"


def _derive_by_scores(scene: Scene, point: DesignPoint, curvature: Real) -> Real:
    """Second derivatives of the excess by the independent normal variables, from others.

    Parameters
    ----------
    curvature : ndarray, shape (d, d)
        Second derivatives by the parameters.
    """
    by, mixing = scene.physical_slopes(point.u[None])[0], scene.marginals.mixing
    # each parameter has one score, a mixture of the variables: second derivatives by that
    sides = np.array([_SCORE, -_SCORE])
    slopes = [
        law.at_score(score + sides)[1]
        for law, score in zip(scene.marginals.laws, mixing @ point.u, strict=True)
    ]
    bent = np.array([(after - before) / (2 * _SCORE) for after, before in slopes])
    found: Real = by.T @ curvature @ by + mixing.T @ np.diag(point.slopes * bent) @ mixing
    return found
