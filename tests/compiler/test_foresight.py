"""Whether a system knows beforehand when its functions of time change."""

import copy
import pickle

import pytest

import lumped as lp
from lumped import functionals as fun
from lumped.compiler.leads import exchange_states
from lumped.ops import sin, where


class Tooth(lp.Component):
    """A body under a load that sets in at instants that no formula tells; a spare angle."""

    x = lp.var("m", "position", 0.3)
    v = lp.var("m/s", "speed")
    spare = lp.var("rad", "on which nothing depends")

    def equations(self):
        load = where(lp.time + 0.3 * sin(5 * lp.time) > 0.4, 1.0, -1.0)
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == load - 9.0 * self.x
        yield lp.der(self.spare) == self.v


FROM_IT = {
    "itself": lambda system: system,
    "watching": lambda system: system.watching(fun.peak(abs(system.model.x)).names),
    "whole": lambda system: system.whole,
    "exchanged": lambda system: exchange_states(system, [system.structure.states[:2]]),
    "pickled": lambda system: pickle.loads(pickle.dumps(system)),
    "copied": copy.deepcopy,
}


@pytest.mark.parametrize("change", FROM_IT.values(), ids=FROM_IT)
def test_what_is_made_of_a_system_without_foresight_has_none(change):
    system = lp.assemble(Tooth(), of=["x"])
    assert len(change(system).switching.timed) == 1
    assert change(system.without_foresight()).switching.timed == []
