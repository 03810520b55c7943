"""One axis of a synchronous machine in per unit, from its standard parameters."""

import numpy as np


def axis(X, T, X_l, R_a, w):
    """Reactances and resistances of the stator and each winding of the rotor.

    Classical expressions: ``X' = X_l + X_a || X_f``, ``T'o = (X_a + X_f) / (w R_f)``, and so on.
    """
    leakages, resistances = [X_l], [R_a]
    for before, after, clock in zip(X[:-1], X[1:], T, strict=True):
        leakages.append(1 / (1 / (after - X_l) - 1 / (before - X_l)))
        resistances.append((leakages[-1] + before - X_l) / (w * clock))
    return X[0] - X_l + np.diag(leakages), np.array(resistances)
