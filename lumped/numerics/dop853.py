"""Coefficients of DOP853 (Hairer, Norsett, Wanner), as SciPy publishes them."""

from scipy.integrate import DOP853

__all__ = ["A_EXTRA", "C_EXTRA", "E3", "E5", "E6", "A", "B", "C", "D"]

A, B, C, D, E3, E5 = DOP853.A, DOP853.B, DOP853.C, DOP853.D, DOP853.E3, DOP853.E5
A_EXTRA, C_EXTRA = DOP853.A_EXTRA, DOP853.C_EXTRA

E6 = (
    *(-0.0022358123565670153, 0.0, 0.0, 0.0, 0.0, 0.6070328897520046, 0.18735227557219802),
    *(-0.7644785856545234, 0.06370729189533206, -0.08895619338362687, -0.002421865824806669),
    *(0.0, 0.0),
)
"""The only combination of the first thirteen stages that meets all 37 conditions of order six, so
that it vanishes with the sixth power of the step; its size is that of the others. The estimate of
Hairer is quadratic in the one of fifth order, and both vanish together at some steps; this one is
linear, and vanishes at others."""
