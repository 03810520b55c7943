"""Coefficients of DOP853 (Hairer, Norsett, Wanner), as SciPy publishes them."""

from scipy.integrate import DOP853

__all__ = ["A", "A_EXTRA", "B", "C", "C_EXTRA", "D", "E3", "E5"]

A, B, C, D, E3, E5 = DOP853.A, DOP853.B, DOP853.C, DOP853.D, DOP853.E3, DOP853.E5
A_EXTRA, C_EXTRA = DOP853.A_EXTRA, DOP853.C_EXTRA
