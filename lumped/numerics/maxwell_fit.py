"""Maxwell branches that have a dynamic stiffness and a relative damping over a band."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from lumped.errors import DeclarationError, shown

__all__ = ["MaxwellFit", "maxwell_fit"]

_POINTS = 64
"""Frequencies of the fit."""
_SLOWER, _FASTER = 100.0, 10.0
"""How far beyond the band relaxation times may lie."""
_NOTHING = 1e-6
"""Share of a branch that is left out."""
_WITHIN = 0.2
"""Largest relative error accepted; catalogues state psi to 20 %."""


@dataclass(frozen=True)
class MaxwellFit:
    """Maxwell branches and how well they meet what they were fitted to.

    Attributes
    ----------
    branches : tuple of (float, float)
        Share of the dynamic stiffness, and relaxation time, s, of each branch.
    stiffness_error, psi_error : float
        Largest relative errors of dynamic stiffness and relative damping over the band.
    """

    branches: tuple[tuple[float, float], ...]
    stiffness_error: float
    psi_error: float


def maxwell_fit(
    static: float, psi: float, band: tuple[float, float], n_branches: int
) -> MaxwellFit:
    """Shares and times of branches by least squares of both relative errors.

    A vibration of angular frequency w meets the stiffness
    ``static + sum(share j w T / (1 + j w T))`` times the dynamic one, which shall be
    ``1 + j psi / (2 pi)`` at frequencies spaced evenly on a logarithmic scale over the band. Both
    parts cannot be constant (Kramers and Kronig): over a decade with ``psi = 0.8`` the stiffness
    rises by about a fifth, so errors do not vanish with more branches. Relaxation times are at most
    ``100 / w`` of the least and at least ``0.1 / w`` of the largest frequency.

    Parameters
    ----------
    static : float
        Static over dynamic stiffness.
    psi : float
        Relative damping.
    band : (float, float)
        Least and largest angular frequency, rad/s.
    n_branches : int
        Number of branches; any that is of no use is left out.

    Returns
    -------
    MaxwellFit

    Raises
    ------
    DeclarationError
        If a number makes no sense, or an error exceeds 20 %.
    """
    _refuse(static, psi, band, n_branches)
    low, high = band
    w = np.geomspace(low, high, _POINTS)

    def errors(guess: np.ndarray) -> np.ndarray:
        x = w[:, None] * np.exp(guess[:n_branches])
        parts = guess[n_branches:] * x / (1 + x**2)
        stiffness = static + (parts * x).sum(axis=1)
        return np.append(stiffness - 1, 2 * np.pi * parts.sum(axis=1) / (psi * stiffness) - 1)

    slow, fast = np.log(_SLOWER / low), np.log(1 / (_FASTER * high))
    times = np.linspace(slow, fast, n_branches + 2)[1:-1]
    shares = np.full(n_branches, (1 - static) / n_branches)
    found = scipy.optimize.least_squares(
        errors,
        np.append(times, shares),
        bounds=(
            np.repeat([fast, 0.0], n_branches),
            np.repeat([slow, np.inf], n_branches),
        ),
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
    )
    stiffness_error, psi_error = np.abs(found.fun).reshape(2, -1).max(axis=1).tolist()
    if max(stiffness_error, psi_error) > _WITHIN:
        raise DeclarationError(
            f"n_branches = {n_branches}: with static = {static:g} and psi = {psi:g} the dynamic "
            f"stiffness is missed by {stiffness_error:.0%} and psi by {psi_error:.0%} in the band "
            f"from {low:g} to {high:g} rad/s; at most {_WITHIN:.0%} is accepted. Take a narrower "
            "band, more branches, or another static stiffness."
        )
    shares, times = found.x[n_branches:], np.exp(found.x[:n_branches])
    rows = sorted(zip(times.tolist(), shares.tolist(), strict=True), reverse=True)
    used = tuple((share, time) for time, share in rows if share > _NOTHING)
    return MaxwellFit(used, stiffness_error, psi_error)


def _refuse(static: float, psi: float, band: tuple[float, float], n_branches: int) -> None:
    """Refuse numbers that make no sense."""
    for name, value, most in (("static", static, 1.0), ("psi", psi, float("inf"))):
        if not _number(value) or not 0 < value < most:
            end = f" and below {most:g}" if most < float("inf") else ""
            raise DeclarationError(f"{name} = {shown(value)}: a number above 0{end} is needed.")
    ends = list(band) if isinstance(band, tuple | list) else []
    if len(ends) != 2 or not all(map(_number, ends)) or not 0 < ends[0] < ends[1] < float("inf"):
        raise DeclarationError(
            f"band = {shown(band)}: the least and the largest angular frequency are needed, rad/s, "
            "such as (30.0, 300.0)."
        )
    if not isinstance(n_branches, int) or isinstance(n_branches, bool) or n_branches < 1:
        raise DeclarationError(
            f"n_branches = {shown(n_branches)}: a whole number, at least 1, is needed."
        )


def _number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
