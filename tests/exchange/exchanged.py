"""Exported models whose importer integrates, call by call."""

import numpy as np
from opened import Opened


class Exchanged(Opened):
    """A unit for model exchange, from its initialisation mode on."""

    def __init__(self, path, start_values=None):
        super().__init__(path, "ModelExchange")
        if not self.new:
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
