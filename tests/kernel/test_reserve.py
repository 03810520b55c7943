"""The reserve of constraints that share a load, against SciPy's linear programmes."""

import numpy as np
import pytest
from scipy.optimize import linprog

from lumped.kernel.instant_search import Reserve
from lumped.kernel.instants.reserve import largest_reserve


class Shares:
    """Random reactions, limits, and stresses that move nothing; limits may follow them."""

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        self.n = n = int(rng.integers(1, 9))
        self.r = r = int(rng.integers(0, n + 1))
        self.upper, self.lower = rng.uniform(0.5, 4.0, n), -rng.uniform(0.5, 4.0, n)
        pushes = rng.random(n) < 0.3
        self.upper[pushes], self.lower[pushes] = 0.0, -np.inf
        self.carried = rng.uniform(-5.0, 5.0, n)
        self.stress = rng.uniform(-1.0, 1.0, (r, 3, n))
        self.stress[:, 1:] *= 0.1 * rng.integers(0, 2)
        self.stress[:, 1, pushes] = 0.0

    def found(self):
        programme = Reserve({"holds": self.n})
        programme.size, programme.stresses = self.n, self.r
        programme.upper[:], programme.lower[:] = self.upper, self.lower
        programme.carried[:] = self.carried
        programme.stress[: self.stress.size] = self.stress.ravel()
        reserve = largest_reserve(programme, self.n)
        return reserve, np.array(programme.carried), np.array(programme.blocks)

    def expected(self):
        """Largest s, and prices of all limits: s w + (r - limit) <= room."""
        finite = [x[np.isfinite(x)] for x in (self.upper, self.lower, self.carried)]
        size = max(np.abs(x).max(initial=0.0) for x in finite)
        A, b, owner = [np.append(np.zeros(self.r), 1.0)], [1.0], [(-1, 0)]
        for sign, part, limits in ((1, 1, self.upper), (-1, 2, self.lower)):
            for i in np.flatnonzero(np.isfinite(limits)):
                weight = abs(limits[i]) / size if limits[i] else 1.0
                moved = sign * (self.stress[:, 0, i] - self.stress[:, part, i]) / size
                A.append(np.append(moved, weight))
                b.append(sign * (limits[i] - self.carried[i]) / size)
                owner.append((i, sign))
        aim = np.append(np.zeros(self.r), -1.0)
        solved = linprog(aim, np.array(A), b, bounds=(None, None), method="highs")
        return -solved.fun, solved.ineqlin.marginals, owner, np.array(A), np.array(b)


@pytest.mark.parametrize("seed", range(200))
def test_the_reserve_and_what_blocks_it_are_those_of_another_solver(seed):
    shares = Shares(seed)
    reserve, carried, blocks = shares.found()
    expected, prices, owner, A, b = shares.expected()
    assert reserve == pytest.approx(expected, rel=1e-9, abs=1e-9)
    if expected < 0.1:  # above that, both limits of one constraint may block
        blocking = {o for o, price in zip(owner, prices, strict=True) if price < -1e-6}
        received = {(i, int(blocks[i])) for i in np.flatnonzero(blocks)}
        assert received <= blocking
        assert {i for i, _ in received} == {i for i, _ in blocking}
    # what is carried is the old with stresses only, and leaves that reserve to each limit
    more = carried - shares.carried
    y = np.linalg.lstsq(shares.stress[:, 0].T, more, rcond=None)[0] if shares.r else np.zeros(0)
    assert shares.stress[:, 0].T @ y == pytest.approx(more, abs=1e-9)
    if shares.r == np.linalg.matrix_rank(shares.stress[:, 0]):
        assert (A @ np.append(y, reserve) <= b + 1e-9).all()
