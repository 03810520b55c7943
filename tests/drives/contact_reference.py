"""What contacts bear, and how they collide, by enumeration; knows no `lumped`.

Newton's impact law for several contacts at once: the speeds after an impact are the projection of
those before on ``{W v >= least, D v == 0}`` in the kinetic metric, with ``least = e |W v before|``
for contacts that approach and zero for those that touch or go away (Moreau; Glocker, Set-Valued
Force Laws, 2001): impulses push, and a contact that leaves faster takes none. If all contacts
approach or touch, the loss ``sum p (1 - e) |u| / 2`` is never negative. A contact that goes away
and is caught, as a freewheel may be, can make it negative, or leave no such speeds at all; there
the law says nothing.
"""

import itertools
from functools import lru_cache

import numpy as np


class OpenLawError(Exception):
    """The law leaves open what happens."""


def impact(
    J: np.ndarray, v: np.ndarray, W: np.ndarray, least: np.ndarray, D: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Speeds after an impact and impulses: ``W v >= least``, ``D v == 0``, complementary.

    Enumeration of the contacts that take impulses, each set linearly independent beside D.
    """
    for count in range(len(W) + 1):
        for active in itertools.combinations(range(len(W)), count):
            rows = np.concatenate([W[list(active)].reshape(count, len(J)), D])
            after, p = v, np.zeros(0)
            if len(rows):
                missing = np.concatenate([least[list(active)], np.zeros(len(D))]) - rows @ v
                p = np.linalg.pinv(rows / J @ rows.T, 1e-12) @ missing
                after = v + rows.T @ p / J
                if np.abs(rows @ (after - v) - missing).max() > 1e-9:
                    continue
            if (p[:count] >= -1e-10).all() and (W @ after >= least - 1e-10).all():
                impulses = np.zeros(len(W))
                impulses[list(active)] = p[:count]
                return after, impulses
    raise OpenLawError("Newton's law asks for speeds that contacts forbid")


def poisson(
    J: np.ndarray, v: np.ndarray, W: np.ndarray, e: np.ndarray, D: np.ndarray
) -> np.ndarray:
    """Speeds after an impact by Poisson's law, for where Newton's law says nothing.

    Compression ends where nothing approaches; expansion gives back e times the impulses of
    compression, and more where contacts would approach (Glocker and Pfeiffer, Nonlinear Dynamics 7
    (1995) 471). That is the least kinetic energy of all impulses of at least that size, those of
    compression among them, so there is always an answer and never a gain.
    """
    none = np.zeros(len(W))
    compressed, p = impact(J, v, W, none, D)
    return impact(J, compressed + W.T @ (e * p) / J, W, none, D)[0]


def lost(J: np.ndarray, before: np.ndarray, after: np.ndarray) -> float:
    return float(J @ (before**2 - after**2)) / 2


def facets(rows: np.ndarray, ranges: list, carried: np.ndarray) -> tuple[list, list]:
    """Margins of ``carried == rows' r`` with each r in its range, and the contacts in each.

    `ranges` holds rows for the least and the greatest reaction, None for infinite ones; `carried`
    is the sum of all reactions as rows.
    """
    found, owners = [], []
    for normal, along in borders(rows.shape, rows.tobytes()):
        here = np.flatnonzero(along)
        ends = [ranges[i][int(along[i] > 0)] for i in here]
        if all(end is not None for end in ends):
            most = sum(along[i] * end for i, end in zip(here, ends, strict=True))
            found.append(most - normal @ carried)
            owners.append(here)
    return found, owners


@lru_cache(maxsize=4096)
def borders(shape: tuple[int, int], content: bytes) -> list[tuple[np.ndarray, np.ndarray]]:
    """Normals of all borders of what contacts can carry, and the rows of contacts along them.

    Each border is spanned by rows of contacts, one less than their rank.
    """
    rows = np.frombuffer(content).reshape(shape)
    _, size, V = np.linalg.svd(rows)
    rank = int((size > 1e-9 * size[0]).sum())
    basis, found = V[:rank].T, {}
    inner = rows @ basis
    for chosen in itertools.combinations(range(len(rows)), rank - 1):
        _, size, V = np.linalg.svd(inner[list(chosen)].reshape(rank - 1, rank))
        if rank > 1 and size[-1] < 1e-9:
            continue
        for normal in (V[-1], -V[-1]):
            along = inner @ normal
            along[np.abs(along) < 1e-9] = 0.0
            found[tuple(np.round(along, 7) + 0.0)] = basis @ normal, along
    return list(found.values())
