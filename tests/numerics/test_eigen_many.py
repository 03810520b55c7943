"""Eigenvalues of many matrices at once are those of each alone."""

import numpy as np
import pytest

from lumped.numerics.eigen import eigenpairs, eigenvalues_of_many, vectors_of_many


def chains(kind, count=40, masses=5, seed=3):
    """State matrices of chains of masses on springs between walls, of random size."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        c = 10.0 ** rng.uniform(3, 9, masses + 1)
        m = rng.uniform(0.5, 5.0, masses)
        k = np.diag(c[:-1] + c[1:]) - np.diag(c[1:-1], 1) - np.diag(c[1:-1], -1)
        if kind == "twists":  # one state for each spring and each mass: undamped, singular values
            b = np.zeros((masses + 1, masses))
            b[np.arange(masses), np.arange(masses)] = 1.0
            b[np.arange(1, masses + 1), np.arange(masses)] -= 1.0
            a = np.block(
                [
                    [np.zeros((masses + 1, masses + 1)), b],
                    [-(b.T * c) / m[:, None], np.zeros((masses, masses))],
                ]
            )
        else:
            d = (1e-5 if kind == "damped" else 0.0) * k
            a = np.block(
                [[np.zeros((masses, masses)), np.eye(masses)], [-k / m[:, None], -d / m[:, None]]]
            )
        found.append(a)
    return np.array(found)


@pytest.mark.parametrize("kind", ["twists", "positions", "damped"])
def test_values_are_those_of_each_matrix_alone(kind):
    blocks = chains(kind)
    many = eigenvalues_of_many(blocks)
    errors = []
    for block, found in zip(blocks, many, strict=True):
        alone = eigenpairs(block)[0]
        alone = alone[alone.imag > 0]
        own = found[found.imag > 0]
        alone, own = (v[np.argsort(np.abs(v))] for v in (alone, own))
        assert len(alone) == len(own)
        errors.append(np.abs(own / alone - 1).max())
    assert max(errors) < (1e-13 if kind == "twists" else 1e-7)


def test_vectors_solve_their_equations():
    blocks = chains("damped")
    values = np.array([v[v.imag > 0][0] for v in eigenvalues_of_many(blocks)])
    right, left = vectors_of_many(blocks, values)
    size = np.abs(blocks).max(axis=(1, 2))
    off_right = np.abs(np.einsum("nij,nj->ni", blocks, right) - values[:, None] * right).max(axis=1)
    scale = np.abs(left).max(axis=1)
    off_left = np.abs(
        np.einsum("nji,nj->ni", blocks, left.conj()) - values[:, None] * left.conj()
    ).max(axis=1)
    assert (off_right / size).max() < 1e-13
    assert (off_left / size / scale).max() < 1e-13
    assert np.abs((left.conj() * right).sum(axis=1) - 1).max() < 1e-12
