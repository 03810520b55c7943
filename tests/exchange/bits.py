"""Exported models driven step by step, and compared with `simulate` to the last bit."""

import shutil

import fmpy
import fmpy.fmi2
import fmpy.fmi3
import numpy as np

import lumped as lp

STEPS = {"auto": "steps", "explicit": "explicit", "implicit": "implicit"}
"""Methods of `simulate` by those of a unit."""


class Unit:
    """A unit for co-simulation, between its start and its end."""

    def __init__(
        self, path, *, stop, rtol=None, start_values=None, event_mode=False, early_return=False
    ):
        facts = fmpy.read_model_description(str(path))
        self.folder = fmpy.extract(str(path))
        self.told = []
        self.place = {v.name: v.valueReference for v in facts.modelVariables}
        self.new = facts.fmiVersion.startswith("3")
        options = {
            "guid": facts.guid,
            "unzipDirectory": self.folder,
            "modelIdentifier": facts.coSimulation.modelIdentifier,
            "instanceName": "one",
        }
        if self.new:
            self.fmu = fmpy.fmi3.FMU3Slave(**options)
            self.fmu.instantiate(
                logMessage=lambda *message: self.told.append(message[-1]),
                eventModeUsed=event_mode,
                earlyReturnAllowed=early_return,
            )
            times = {"startTime": 0.0, "stopTime": stop, "tolerance": rtol}
        else:
            self.fmu = fmpy.fmi2.FMU2Slave(**options)
            callbacks = fmpy.fmi2.fmi2CallbackFunctions()
            callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(
                lambda *message: self.told.append(message[-1].decode())
            )
            callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.fmi2.calloc)
            callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.fmi2.free)
            self.fmu.instantiate(callbacks=callbacks)
            self.fmu.setupExperiment(startTime=0.0, stopTime=stop, tolerance=rtol)
            times = {}
        self.set(start_values or {})
        self.fmu.enterInitializationMode(**times)
        self.fmu.exitInitializationMode()
        if event_mode:
            self.fmu.updateDiscreteStates()
            self.fmu.enterStepMode()

    def set(self, values):
        if values:
            names = [self.place[name] for name in values]
            put = self.fmu.setFloat64 if self.new else self.fmu.setReal
            put(names, list(values.values()))

    def get(self, names):
        references = [self.place[name] for name in names]
        found = (self.fmu.getFloat64 if self.new else self.fmu.getReal)(references)
        return np.array(found)

    def step(self, begin, end):
        """Go on from one time to another; steps are chosen so that they end there exactly."""
        length = end - begin
        while begin + length != end:
            length = np.nextafter(length, np.inf if begin + length < end else -np.inf)
        self.fmu.doStep(currentCommunicationPoint=begin, communicationStepSize=length)

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


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
