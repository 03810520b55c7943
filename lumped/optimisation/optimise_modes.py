"""Parameters that put natural frequencies and damping ratios where they are wanted."""

from __future__ import annotations

import numpy as np

from lumped.errors import OptimisationError
from lumped.optimisation.design import Optimum, Task
from lumped.optimisation.spectral_search import SpectralSearch
from lumped.vibration.natural.eigen_sensitivity import EigenSensitivity, eigen_sensitivity
from lumped.vibration.natural.find_modes import modes
from lumped.vibration.natural.mode_designs import ModeDesigns
from lumped.vibration.natural.modes import Modes


def best_modes(begin: Modes, task: Task) -> Optimum:
    """The modal part of `optimise`: sequential quadratic programming with exact gradients."""
    search = _ModeSearch(begin, task)
    found = search.confirm()
    return search.optimum(search.spectrum(found[0].w).modes, *found)


class _Sensitive:
    """Modes with their derivatives."""

    def __init__(self, found: EigenSensitivity) -> None:
        self.modes, self.found = found.modes, found

    @property
    def hertz(self) -> np.ndarray:
        return self.modes.hertz

    @property
    def damping(self) -> np.ndarray:
        return self.modes.damping

    def hertz_by(self, mode: int) -> np.ndarray:
        found: np.ndarray = self.found.hertz[mode]
        return found

    def damping_by(self, mode: int) -> np.ndarray:
        found: np.ndarray = self.found.damping[mode]
        return found


class _ModeSearch(SpectralSearch):
    def __init__(self, begin: Modes, task: Task) -> None:
        point = begin.point
        super().__init__(begin, point.theta, point.parameters, task)
        self.designs = ModeDesigns(begin)
        self.last: tuple[bytes, _Sensitive] | None = None
        self.begin()

    def spectrum(self, w: np.ndarray) -> _Sensitive:
        u = w[: len(self.names)]
        if self.last is None or self.last[0] != u.tobytes():
            own = modes(self.system, at=self.designs.point(self.values_at(u)))
            if len(own.hertz) != len(self.designs.begin.hertz):
                raise OptimisationError(
                    f"{self.system.name}: at {self.text(u)} there are {len(own.hertz)} "
                    f"oscillating modes instead of {len(self.designs.begin.hertz)}: one became a "
                    "decay or the reverse. Narrow `vary`.",
                    "modes lost",
                )
            slopes = eigen_sensitivity(own, by=self.names)
            if slopes.repeated:
                raise OptimisationError(
                    f"{self.system.name}: at {self.text(u)} mode {slopes.repeated[0]} "
                    f"({own.hertz[slopes.repeated[0]]:.6g} Hz) coincides with another and has no "
                    "derivative. Begin elsewhere.",
                    "repeated modes",
                )
            self.last, self.count = (u.tobytes(), _Sensitive(slopes)), self.count + 1
        return self.last[1]
