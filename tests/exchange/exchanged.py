"""Exported models whose importer integrates, call by call."""

import shutil

import fmpy
import fmpy.fmi2
import fmpy.fmi3
import numpy as np


class Exchanged:
    """A unit for model exchange, from its initialisation mode on."""

    def __init__(self, path, start_values=None):
        self.facts = fmpy.read_model_description(str(path))
        self.folder = fmpy.extract(str(path))
        self.told = []
        self.place = {v.name: v.valueReference for v in self.facts.modelVariables}
        self.new = self.facts.fmiVersion.startswith("3")
        options = {
            "guid": self.facts.guid,
            "unzipDirectory": self.folder,
            "modelIdentifier": self.facts.modelExchange.modelIdentifier,
            "instanceName": "one",
        }
        if self.new:
            self.fmu = fmpy.fmi3.FMU3Model(**options)
            self.fmu.instantiate(logMessage=lambda *message: self.told.append(message[-1].decode()))
        else:
            self.fmu = fmpy.fmi2.FMU2Model(**options)
            callbacks = fmpy.fmi2.fmi2CallbackFunctions()
            callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(
                lambda *message: self.told.append(message[-1].decode())
            )
            callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.fmi2.calloc)
            callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.fmi2.free)
            self.fmu.instantiate(callbacks=callbacks)
            self.fmu.setupExperiment()
        self.set(start_values or {})
        self.fmu.enterInitializationMode()

    def integrate(self):
        """Go on to the mode in which the importer integrates."""
        self.fmu.exitInitializationMode()
        if self.new:
            self.fmu.updateDiscreteStates()
        else:
            self.fmu.newDiscreteStates()
        self.fmu.enterContinuousTimeMode()
        return self

    def set(self, values):
        if values:
            put = self.fmu.setFloat64 if self.new else self.fmu.setReal
            put([self.place[name] for name in values], list(values.values()))

    def get(self, names):
        found = self.fmu.getFloat64 if self.new else self.fmu.getReal
        return np.array(found([self.place[name] for name in names]))

    def forward(self, unknown, known, seed):
        """Derivatives along a direction."""
        rows, columns = ([self.place[name] for name in names] for names in (unknown, known))
        return np.array(self.fmu.getDirectionalDerivative(rows, columns, list(seed)))

    def jacobian(self, unknown, known):
        columns = np.eye(len(known))
        return np.array([self.forward(unknown, known, c) for c in columns]).T.reshape(
            -1, len(known)
        )

    def reverse(self, unknown, known, seed):
        rows, columns = ([self.place[name] for name in names] for names in (unknown, known))
        return np.array(self.fmu.getAdjointDerivative(rows, columns, list(seed), len(known)))

    def close(self):
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)
