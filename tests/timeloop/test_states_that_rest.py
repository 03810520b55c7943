"""States whose derivatives are zero keep their bits through steps, events and output points."""

import numpy as np
import pytest
from checks import in_all_engines
from rows import assemble_one

import lumped as lp


def counter():
    """Turns are counted; a stiff state makes implicit steps long beside the turns."""

    def equations(self):
        yield lp.der(self.x) == 100.0
        yield lp.der(self.stiff) == -1e4 * self.stiff
        yield lp.der(self.turns) == 0
        yield lp.der(self.odd) == 0
        yield lp.when(lp.ops.sin(self.x) > 0.5, {self.turns: self.turns + 1})

    quantities = {
        "x": lp.var("rad", "angle"),
        "stiff": lp.var("1", "decays", 1.0),
        "turns": lp.var("1", "turns counted"),
        "odd": lp.var("1", "no binary fraction", 0.1),
    }
    return assemble_one(equations=equations, **quantities)


@pytest.mark.parametrize("method", ["explicit", "implicit", "steps", "taylor"])
def test_a_counter_stays_a_whole_number(method):
    run = lp.simulate(counter(), until=5.0, grid=997, method=method)
    # sin x passes 0.5 upwards at pi/6 + 2 pi k
    expected = np.floor((100.0 * run.t - np.pi / 6) / (2 * np.pi)) + 1
    at_events = np.isin(run.t, [event.time for event in run.events])
    assert (run["turns"] == expected)[~at_events].all()
    assert set(run["turns"].tolist()) == set(range(int(expected[-1]) + 1))
    assert set(run["odd"].tolist()) == {0.1}


def test_all_engines_give_the_same_bits():
    system = counter()
    first, *others = in_all_engines(
        lambda: lp.simulate(system, until=0.2, grid=97, method="implicit")
    )
    for run in others:
        assert run.t.tobytes() == first.t.tobytes()
        assert run.x.tobytes() == first.x.tobytes()
