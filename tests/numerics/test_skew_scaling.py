import numpy as np
import pytest
import scipy

from lumped.numerics.skew_scaling import skew_scaling, symmetric_weights

N = 6


def drive(damping):
    """Matrix of speeds and twists of a row of inertias with springs and dampers."""
    random = np.random.default_rng(3)
    J, c = random.uniform(0.1, 2.0, N), 10 ** random.uniform(1, 5, N - 1)
    B = np.diff(np.eye(N), axis=0)  # twist rates of speeds
    D = B.T @ np.diag(damping * random.uniform(0.5, 2.0, N - 1)) @ B
    return np.block([[-D / J[:, None], -(B.T * c) / J[:, None]], [B, np.zeros((N - 1, N - 1))]])


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_weights_make_a_drive_symmetric_and_give_left_vectors(damping):
    a = drive(damping)
    weights = symmetric_weights(scipy.sparse.csr_array(a))
    even = weights[:, None] * a
    np.testing.assert_allclose(even, even.T, rtol=1e-12, atol=1e-12 * np.abs(even).max())
    values, right = scipy.linalg.eig(a)
    left = (weights[:, None] * right).conj()
    missed = left.conj().T @ a - values[:, None] * left.conj().T
    assert np.abs(missed).max() < 1e-11 * np.abs(values).max() * np.abs(left).max()


def test_undamped_drives_alone_become_skew_symmetric():
    scale = skew_scaling(scipy.sparse.csr_array(drive(0.0)))
    skew = scale[:, None] * drive(0.0) / scale
    np.testing.assert_allclose(skew, -skew.T, rtol=1e-12)
    assert skew_scaling(scipy.sparse.csr_array(drive(0.3))) is None


@pytest.mark.parametrize(
    "a",
    [
        [[-1.0, 2.0, 0.0], [3.0, -1.0, 1.0], [1.0, 2.0, -3.0]],  # acts one way only
        [[-1.0, 2.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -3.0]],  # ratios disagree in the loop
    ],
)
def test_other_matrices_have_no_weights(a):
    assert symmetric_weights(scipy.sparse.csr_array(np.array(a))) is None
