"""Description of a machine in its report, and the numbers by which its runs are compared."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from importlib import resources
from typing import Any, NamedTuple

import lumped as lp
from lumped.simulation.sizing import Limit


class Motor(NamedTuple):
    """A motor to size.

    Attributes
    ----------
    name : str
        Its name.
    torque, speed : str
        Names of its torque and speed in the run of the machine.
    rated, maximum : float, rows of (speed, torque) or None
        Limits, as for `lumped.simulation.sizing`.
    """

    name: str
    torque: str
    speed: str
    rated: Limit | None = None
    maximum: Limit | None = None


class About(NamedTuple):
    """Paragraphs of a report, and the quantities of a run that it shows.

    Attributes
    ----------
    introduction : str
        The machine and the question.
    source, findings, assumptions : tuple of str
        Origin of the numbers and misprints; results; assumptions.
    scene : str
        Events of the run, in words.
    until : float
        Its end, s; infinite for the end of the motion.
    captions : mapping of str to str
        Caption of each figure, by its name.
    watched : mapping of str to str
        Quantities of the run whose extremes are reported: words, and the name in the model.
    motors : tuple of Motor
        Motors to size.
    varied : tuple of str
        Inputs of the run to which frequency responses are of interest.
    """

    introduction: str
    source: tuple[str, ...]
    findings: tuple[str, ...]
    assumptions: tuple[str, ...]
    scene: str
    until: float
    captions: Mapping[str, str]
    watched: Mapping[str, str]
    motors: tuple[Motor, ...] = ()
    varied: tuple[str, ...] = ()


class Measure(NamedTuple):
    """A number by which a machine is compared with a changed one."""

    quantity: str
    unit: str
    value: float


def read_about(machine: str, until: float, watched: Mapping[str, str], **more: Any) -> About:
    """Paragraphs of the file `about.md` of a machine, and the quantities of its run.

    Parameters
    ----------
    machine : str
        Its name in `lumped.models.MACHINES`.
    until, watched, **more
        What else `About` has.
    """
    file = resources.files(f"lumped.models.{machine}") / "about.md"
    head, *sections = re.split(r"^## ", file.read_text(encoding="utf-8"), flags=re.MULTILINE)
    parts = {title: body for title, _, body in (section.partition("\n") for section in sections)}
    source, findings, assumptions = (
        _list_items(parts[title]) for title in ("Source", "Findings", "Assumptions")
    )
    captions = (text.split(": ", 1) for text in _list_items(parts["Figures"]))
    return About(
        _join_words(head.partition("\n")[2]),
        source,
        findings,
        assumptions,
        scene=_join_words(parts["Run"]),
        captions={name.strip("`"): caption for name, caption in captions},
        until=until,
        watched=watched,
        **more,
    )


def _join_words(text: str) -> str:
    return " ".join(text.split())


def _list_items(text: str) -> tuple[str, ...]:
    return tuple(_join_words(item) for item in re.split(r"^\* ", text, flags=re.MULTILINE)[1:])


def number_values(text: str, unit: str, values: Iterable[float]) -> list[Measure]:
    """Values of one kind, counted from 1."""
    return [Measure(f"{text} {i}", unit, float(value)) for i, value in enumerate(values, 1)]


def extremes(run: lp.Trajectory, about: About) -> Iterator[Measure]:
    """Extremes of the watched quantities, RMS torques of the motors, energy lost."""
    for words, name in about.watched.items():
        values, unit = run[name], run.system.quantity(name).unit
        yield Measure(f"{words}, least", unit, float(values.min()))
        yield Measure(f"{words}, greatest", unit, float(values.max()))
    for motor in about.motors:
        asked = size_motor(run, motor)
        yield Measure(f"{motor.name}, RMS torque", "N.m", asked.rms_torque)
        yield Measure(f"{motor.name}, peak power", "W", asked.peak_power)
    lost = sum(event.loss for event in run.events)
    yield Measure("energy lost in impacts", "J", float(lost))


def size_motor(run: lp.Trajectory, motor: Motor) -> lp.simulation.Sizing:
    """Demand of a run on a motor."""
    limits = {"rated": motor.rated, "maximum": motor.maximum}
    return lp.simulation.sizing(run, of=(motor.torque, motor.speed), **limits)


def find_shared(system: lp.System, parameters: Mapping[str, Any] | None) -> dict[str, Any]:
    """Those of some parameters of a machine that another model of it also has."""
    return {name: x for name, x in (parameters or {}).items() if name in system.parameters}
