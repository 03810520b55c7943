"""Factors of sparse matrices that may be singular."""

from __future__ import annotations

from typing import Any

import scipy


def factors_of(matrix: scipy.sparse.sparray) -> Any | None:
    """LU factors of a square sparse matrix (see `scipy.sparse.linalg.splu`); None if singular.

    The structure is checked first: SuperLU would go on with a column without a pivot, and the
    libraries below it would then print to standard error.
    """
    columns = matrix.tocsc()
    if scipy.sparse.csgraph.structural_rank(columns) < columns.shape[0]:
        return None
    try:
        return scipy.sparse.linalg.splu(columns)
    except RuntimeError:  # a pivot is zero
        return None
