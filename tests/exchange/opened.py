"""Units of FMI that are opened by FMPy, call by call."""

import shutil

import fmpy
import fmpy.fmi2
import fmpy.fmi3
import numpy as np


class Opened:
    """A unit of one kind that is made.

    Parameters
    ----------
    kind : {"ModelExchange", "CoSimulation"}
    **options
        Of making it, in version 3.0.

    Attributes
    ----------
    told : list of str
        Its messages.
    place : dict of str to int
        References of its variables.
    """

    def __init__(self, path, kind, **options):
        self.facts = fmpy.read_model_description(str(path))
        self.folder = fmpy.extract(str(path))
        self.told = []
        self.place = {v.name: v.valueReference for v in self.facts.modelVariables}
        self.new = self.facts.fmiVersion.startswith("3")
        is_exchanged = kind == "ModelExchange"
        own = self.facts.modelExchange if is_exchanged else self.facts.coSimulation
        given = {
            "guid": self.facts.guid,
            "unzipDirectory": self.folder,
            "modelIdentifier": own.modelIdentifier,
            "instanceName": "one",
        }
        if self.new:
            make = fmpy.fmi3.FMU3Model if is_exchanged else fmpy.fmi3.FMU3Slave
            self.fmu = make(**given)
            self.fmu.instantiate(logMessage=self._note, **options)
            return
        self.fmu = (fmpy.fmi2.FMU2Model if is_exchanged else fmpy.fmi2.FMU2Slave)(**given)
        callbacks = fmpy.fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(self._note)
        callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.fmi2.calloc)
        callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.fmi2.free)
        self.fmu.instantiate(callbacks=callbacks)

    def _note(self, *message):
        self.told.append(message[-1].decode())

    def set(self, values):
        if values:
            put = self.fmu.setFloat64 if self.new else self.fmu.setReal
            put([self.place[name] for name in values], list(values.values()))

    def get(self, names):
        found = self.fmu.getFloat64 if self.new else self.fmu.getReal
        return np.array(found([self.place[name] for name in names]))

    def close(self):
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)
