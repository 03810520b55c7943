import numpy as np
import pytest

import lumped as lp
from lumped.components import CrankSlider, Position
from lumped.errors import SolverError


def test_a_linkage_prescribed_beyond_its_reach_is_reported_with_its_time() -> None:
    """A rod that is shorter than crank and offset locks at sin(q) = (L + e) / r."""
    model = lp.compose(
        turn=Position(phi=lp.time),
        crank=CrankSlider(r=0.59, L=0.9, e=-0.33),
        connections=lambda m: [lp.connect(m.turn.flange, m.crank.flange)],
    )
    # L sin(psi) = e - r sin(q) reaches -L
    lock = np.arcsin((0.9 - 0.33) / 0.59)
    system = lp.assemble(model)
    run = lp.simulate(system, until=2.0, grid=2000)
    with pytest.raises(SolverError, match=rf"crank\.v is not a number at t = {lock:.2f}"):
        run["crank.v"]
    before = lp.simulate(system, until=0.999 * lock)
    assert np.isfinite(before["crank.v"]).all()
