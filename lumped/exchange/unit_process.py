"""A unit of FMI in a process of its own, so that a crash of its binary ends nothing else.

It is run as a script: it gets orders through its input and answers through its output. It imports
nothing of lumped, so that it starts quickly.

Source: Functional Mock-up Interface 2.0.5, sections 3.2 and 4.2; 3.0.2, sections 3 and 4.
"""

from __future__ import annotations

import math
import os
import pickle
import signal
import struct
import sys
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import IO, Any

Variable = tuple[int, str, int]
"""Value reference, type and number of values."""

_SIGNALS = ("parameters", "inputs", "outputs")
_MOST_UPDATES = 1000
"""Rounds of an event after which it counts as endless."""


class EndError(Exception):
    """The unit ends the simulation, or cannot go on."""


class _Unit:
    """What units of all versions and kinds have.

    Parameters
    ----------
    facts : dict
        Folder, version, kind, identifier, token, tolerance, and variables of the unit
        (`lumped.exchange.unit_description`).
    tell : callable
        Takes messages of the unit.
    """

    def __init__(self, facts: dict[str, Any], tell: Callable[[str], None]) -> None:
        self.facts, self.version, self.t = facts, facts["version"], 0.0
        self._tell, self._is_begun, self._next_event = tell, False, math.inf
        self._groups = {which: _group(facts[which]) for which in _SIGNALS}
        from fmpy.simulation import instantiate_fmu

        own = SimpleNamespace(modelIdentifier=facts["identifier"])
        self.unit = instantiate_fmu(
            facts["folder"],
            SimpleNamespace(
                guid=facts["token"],
                fmiVersion=f"{self.version}.0",
                coSimulation=own,
                modelExchange=own,
            ),
            self._kind,
            logger=self._log,
            early_return_allowed=facts["has_events"],
            event_mode_used=facts["has_events"],
        )

    _kind = ""

    def _log(self, *message: Any) -> None:
        """Tell a message; versions put different things before its status."""
        status, _, text = message[-3:]
        if status > 0 and text:
            self._tell(text.decode("utf-8", "replace").strip())

    def begin(self, t: float, parameters: Sequence[float], inputs: Sequence[float]) -> list[float]:
        """Begin anew at a time; gives the outputs."""
        if self._is_begun:
            self.unit.reset()
        self._is_begun = True
        self.t, tolerance = t, self.facts["tolerance"]
        for reference, kind, value in self.facts["fixed"]:
            getattr(self.unit, "set" + _find_stored_type(kind, self.version))([reference], [value])
        self.set("parameters", parameters)
        if self.version == 3:
            self.unit.enterInitializationMode(tolerance=tolerance, startTime=t)
        else:
            self.unit.setupExperiment(tolerance=tolerance, startTime=t)
            self.unit.enterInitializationMode()
        self.set("inputs", inputs)
        self.unit.exitInitializationMode()
        return self._finish_begin()

    def _finish_begin(self) -> list[float]:
        return self.outputs()

    def go_on(self, to: float, inputs: Sequence[float]) -> list[float]:
        """Go to a time with the inputs as they are, then take new ones; gives the outputs."""
        raise NotImplementedError

    def set(self, which: str, values: Sequence[float]) -> None:
        """Set parameters or inputs."""
        for kind, references, places in self._groups[which]:
            own = [_convert(kind, values[k]) for k in places]
            getattr(self.unit, "set" + _find_stored_type(kind, self.version))(references, own)

    def outputs(self) -> list[float]:
        """Values of the outputs."""
        found = [0.0] * sum(count for *_, count in self.facts["outputs"])
        for kind, references, places in self._groups["outputs"]:
            read = getattr(self.unit, "get" + _find_stored_type(kind, self.version))
            own = read(references, len(places)) if self.version == 3 else read(references)
            for k, value in zip(places, own, strict=True):
                found[k] = float(value)
        return found

    def _update(self) -> None:
        """Bring an event to its end."""
        read = self.unit.updateDiscreteStates if self.version == 3 else self.unit.newDiscreteStates
        for _ in range(_MOST_UPDATES):
            again, ends, _, _, has_next, following = read()
            if ends:
                raise EndError("it asks to end the simulation")
            self._next_event = following if has_next else math.inf
            if not again:
                return
        raise EndError(f"its event does not end within {_MOST_UPDATES} updates")


class _Slave(_Unit):
    """Co-simulation."""

    _kind = "CoSimulation"

    def _finish_begin(self) -> list[float]:
        if not self.facts["has_events"]:
            return self.outputs()
        self._update()
        found = self.outputs()
        self.unit.enterStepMode()
        return found

    def go_on(self, to: float, inputs: Sequence[float]) -> list[float]:
        if self.version == 2:
            self.unit.doStep(self.t, to - self.t)
            self.t = to
        else:
            self._step_to(to)
        if self.facts["has_events"]:
            self.unit.enterEventMode()
            self.set("inputs", inputs)
            self._update()
            found = self.outputs()
            self.unit.enterStepMode()
            return found
        self.set("inputs", inputs)
        return self.outputs()

    def _step_to(self, to: float) -> None:
        while self.t < to:
            end = min(to, self._next_event)
            if end > self.t:
                event, ends, early, last = self.unit.doStep(self.t, end - self.t)
                if ends:
                    raise EndError("it asks to end the simulation")
                if early and not event and last <= self.t:
                    raise EndError("it returned early without an event and without a step")
                self.t = last if early else end
            else:
                event = True
            if self.t < to and self.facts["has_events"] and (event or self.t >= self._next_event):
                self.unit.enterEventMode()
                self._update()
                self.unit.enterStepMode()


class _Model(_Unit):
    """Model exchange: its states are integrated here, by CVode."""

    _kind = "ModelExchange"

    def _finish_begin(self) -> list[float]:
        self._update()
        self.unit.enterContinuousTimeMode()
        from fmpy.sundials import CVodeSolver

        unit = self.unit
        self._solver = CVodeSolver(
            nx=self.facts["states"],
            nz=self.facts["indicators"],
            get_x=unit.getContinuousStates,
            set_x=unit.setContinuousStates,
            get_dx=unit.getContinuousStateDerivatives if self.version == 3 else unit.getDerivatives,
            get_z=unit.getEventIndicators,
            get_nominals=unit.getNominalsOfContinuousStates,
            set_time=unit.setTime,
            input=_HeldInputs(),
            startTime=self.t,
            relativeTolerance=self.facts["tolerance"],
            maxNumSteps=100_000,
        )
        return self.outputs()

    def go_on(self, to: float, inputs: Sequence[float]) -> list[float]:
        while self.t < to:
            end = min(to, self._next_event)
            is_event = end <= self.t
            if not is_event:
                is_event, _, self.t = self._solver.step(self.t, end)
                self.unit.setTime(self.t)
            if self.facts["tells_steps"]:
                is_step_event, ends = self.unit.completedIntegratorStep()
                if ends:
                    raise EndError("it asks to end the simulation")
                is_event = is_event or is_step_event
            if self.t < to and (is_event or self.t >= self._next_event):
                self._event(None)
        self.t = to
        return self._event(inputs)

    def _event(self, inputs: Sequence[float] | None) -> list[float]:
        self.unit.enterEventMode()
        if inputs is not None:
            self.set("inputs", inputs)
        self._update()
        self.unit.enterContinuousTimeMode()
        self._solver.reset(self.t)
        return [] if inputs is None else self.outputs()


def _group(variables: Sequence[Variable]) -> list[tuple[str, list[int], list[int]]]:
    """Variables of each type: the type, their references, and the places of their values."""
    groups: dict[str, tuple[list[int], list[int]]] = {}
    place = 0
    for reference, kind, count in variables:
        references, places = groups.setdefault(kind, ([], []))
        references.append(reference)
        places += range(place, place + count)
        place += count
    return [(kind, *held) for kind, held in groups.items()]


class _HeldInputs:
    """Inputs stay as they are between samples."""

    def apply(self, time: float) -> None:
        """Nothing changes."""


def _find_stored_type(kind: str, version: int) -> str:
    """Type by which values of another are set and read."""
    if kind != "Enumeration":
        return kind
    return "Int64" if version == 3 else "Integer"


def _convert(kind: str, value: float) -> Any:
    """A number as a unit takes it."""
    if kind in ("Real", "Float64", "Float32"):
        return value
    return value > 0.5 if kind == "Boolean" else round(value)


def read(stream: IO[bytes]) -> Any:
    """The next message; None where there are no more."""
    head = stream.read(4)
    if len(head) < 4:
        return None
    data = stream.read(struct.unpack("<I", head)[0])
    return pickle.loads(data)


def write(stream: IO[bytes], message: Any) -> None:
    """Send a message."""
    data = pickle.dumps(message)
    stream.write(struct.pack("<I", len(data)) + data)
    stream.flush()


def _serve() -> None:
    """Do what is ordered until there are no more orders."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the program that asks decides
    orders = sys.stdin.buffer
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what the unit prints shall not stand among the answers
    facts = read(orders)
    said: list[str] = []
    unit: _Unit | None = None
    while facts is not None and (order := read(orders)) is not None:
        said.clear()
        try:
            if unit is None:
                unit = (_Model if facts["kind"] == "model_exchange" else _Slave)(facts, said.append)
            t, parameters, inputs = order
            found = unit.go_on(t, inputs) if parameters is None else unit.begin(*order)
            write(answers, (found, said))
        except Exception as fault:
            write(answers, (str(fault) or type(fault).__name__, said))


if __name__ == "__main__":
    _serve()
