"""Steps of a run in stretches, and functions between their ends."""

import numpy as np
import pytest
from derivative_drives import DRIVES

from lumped.gradients import legs
from lumped.gradients.legs import stretches
from lumped.simulation.simulate import simulate


@pytest.mark.parametrize("name", ["play_with_rigid_flanks", "stick_slip_with_stribeck"])
@pytest.mark.parametrize("rows", [1, 3, 17, 10**6])
def test_each_step_and_each_change_is_in_one_stretch(name, rows, monkeypatch):
    system, _, _, until = DRIVES[name]()
    own = legs.legs_of(simulate(system, until=until, grid=None))
    width = sum(len(side) for side in own[0].side(0)) + 1
    monkeypatch.setattr(legs, "_MADE_BYTES", 8 * width * rows)
    found = stretches(own)
    steps, changes = [], []
    for stretch in found:
        span = stretch.span(own)
        assert stretch.ends == len(span.t)
        assert (np.diff(span.t)[span.is_step == 0] == 0).all()
        steps += span.t[:-1][span.is_step == 1].tolist()
        changes += span.t[:-1][span.is_step == 0].tolist()
    assert steps == [t for leg in own for t in leg.t[:-1].tolist()]
    assert changes == [leg.t[0] for leg in own[1:]]
    for number, leg in enumerate(own):
        for t in leg.t.tolist():
            places = [stretch.place(own, number, t) for stretch in found]
            (place,) = (p for p in places if p is not None)
            (stretch,) = (s for s, p in zip(found, places, strict=True) if p is not None)
            assert stretch.span(own).t[place] == t
    assert len(found) == 1 if rows == 10**6 else len(found) > 1
