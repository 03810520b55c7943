import numpy as np
import pytest

import lumped as lp
from lumped.components import Eccentric, GuidedRod, Position, translation
from lumped.errors import SolverError


def test_a_linkage_prescribed_beyond_its_reach_is_reported_with_its_time() -> None:
    """A rod that is shorter than crank and offset locks at r sin(phi) + e = L."""
    model = lp.compose(
        turn=Position(phi=lp.time),
        crank=Eccentric(radius=0.59, phase=-np.pi / 2),
        rod=GuidedRod(length=0.9),
        hub=[translation.Fixed(), translation.Fixed()],
        guide=translation.Fixed(s0=-0.33),
        connections=lambda m: [
            lp.connect(m.turn.flange, m.crank.flange),
            lp.connect(m.hub[0].flange, m.crank.hub_x),
            lp.connect(m.hub[1].flange, m.crank.hub_y),
            lp.connect(m.crank.pin_x, m.rod.pin_x),
            lp.connect(m.crank.pin_y, m.rod.pin_y),
            lp.connect(m.rod.guide_x, m.guide.flange),
        ],
    )
    lock = np.arcsin((0.9 - 0.33) / 0.59)
    system = lp.assemble(model, keep=["rod.flange.phi"])
    run = lp.simulate(system, until=2.0, grid=2000)
    with pytest.raises(SolverError, match=rf"rod\.flange\.phi is not a number at t = {lock:.2f}"):
        run["rod.flange.phi"]
    before = lp.simulate(system, until=0.999 * lock)
    assert np.isfinite(before["rod.flange.phi"]).all()
