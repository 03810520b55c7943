"""Exported models driven step by step, and compared with `simulate` to the last bit."""

import numpy as np
from opened import Opened

import lumped as lp

STEPS = {"auto": "steps", "explicit": "explicit", "implicit": "implicit"}
"""Methods of `simulate` by those of a unit."""


class Unit(Opened):
    """A unit for co-simulation, between its start and its end."""

    def __init__(
        self, path, *, stop, rtol=None, start_values=None, event_mode=False, early_return=False
    ):
        options = {"eventModeUsed": event_mode, "earlyReturnAllowed": early_return}
        super().__init__(path, "CoSimulation", **options)
        times = {"startTime": 0.0, "stopTime": stop, "tolerance": rtol}
        if not self.new:
            self.fmu.setupExperiment(**times)
        self.set(start_values or {})
        self.fmu.enterInitializationMode(**(times if self.new else {}))
        self.fmu.exitInitializationMode()
        if event_mode:
            self.fmu.updateDiscreteStates()
            self.fmu.enterStepMode()

    def step(self, begin, end):
        """Go on from one time to another; steps are chosen so that they end there exactly."""
        length = end - begin
        while begin + length != end:
            length = np.nextafter(length, np.inf if begin + length < end else -np.inf)
        self.fmu.doStep(currentCommunicationPoint=begin, communicationStepSize=length)

    def close(self):
        self.fmu.terminate()
        super().close()


def reachable(times):
    """Times at which a step from the one before can end; a few move by one rounding."""
    found = [times[0]]
    for t in times[1:]:
        found.append(found[-1] + (t - found[-1]))
    return np.array(found)


def states_of_unit(path, system, times, *, rtol=None, start_values=None):
    """States at communication points, shape (k, n)."""
    unit = Unit(path, stop=float(times[-1]), rtol=rtol, start_values=start_values)
    names = system.state_names
    try:
        rows = [unit.get(names)]
        for begin, end in zip(times[:-1].tolist(), times[1:].tolist(), strict=True):
            unit.step(begin, end)
            rows.append(unit.get(names))
    except Exception as fault:
        raise RuntimeError(unit.told[-1] if unit.told else str(fault)) from fault
    finally:
        unit.close()
    return np.array(rows)


def states_of_run(system, times, *, method="auto", **options):
    """The same by `simulate`, and its run."""
    run = lp.simulate(system, until=times[-1], grid=times, method=STEPS[method], **options)
    rows = np.vstack([piece.x for piece in run.pieces])
    assert np.array_equal(np.concatenate([piece.t for piece in run.pieces]), times)
    return rows, run
