"""Inertias, stiffnesses, natural frequencies and Holzer tables of a report, as HTML."""

from __future__ import annotations

import numpy as np

from lumped.drawing.inline import inline
from lumped.drawing.page_frame import prose, table
from lumped.drawing.torsional_study import Study
from lumped.support.display_units import Shown
from lumped.support.text_table import list_names, number
from lumped.vibration.inertias.mass_elastic import MassElastic

_SHAPES = 6
"""Mode shapes of a figure."""
_STILL = 1e-9
"""Amplitude in every mode, that of the largest being 1, below which an angle is not drawn."""


def mass_elastic_table(study: Study) -> str:
    """Inertias and stiffnesses, on their own shafts and referred to one."""
    drive = study.drive
    if not isinstance(drive, MassElastic):
        return prose(drive)
    head, rows = drive.list_parts(study.units)
    speed = study.speed
    state = f"at {speed.value(study.first.speeds[study.place]):.5g} {speed.unit}"
    told = prose(
        f"Referred to the shaft of {drive.shaft}; the ratio is that of the turns to its turns. "
        "From the free ends to the last inertia, a branch before the inertia that it joins. What "
        f"varies has its value at the mean state {state}."
    )
    if drive.left_out:
        told += "\n" + prose(f"Neither inertia nor stiffness: {list_names(drive.left_out, 12)}.")
    return f"{table(head, rows, range(1, len(head)))}\n{told}"


def natural_frequencies(study: Study) -> str:
    """All modes and their shapes."""
    found = study.modes
    count = len(found.hertz)
    if not count:
        return prose("No mode oscillates.")
    frequency, speed = study.frequency, study.speed
    undamped = {}
    if isinstance(study.drive, MassElastic):
        every = zip(study.drive.hertz, study.counterparts, strict=True)
        undamped = {mode: number(frequency.value(f)) for f, mode in every if mode is not None}
    rows = [
        (
            *(str(i + 1), number(frequency.value(f)), number(speed.value(2 * np.pi * f))),
            *(number(z, 4), undamped.get(i, "")),
        )
        for i, (f, z) in enumerate(zip(found.hertz, found.damping, strict=True))
    ]
    head = (
        *("mode", f"natural frequency, {frequency.unit}", speed.unit, "damping ratio"),
        f"without damping, {frequency.unit}",
    )
    parts = [table(head, rows, range(len(head)))]
    if study.first.damping_ratio:
        added = f"The response has {study.first.damping_ratio:g} more of every elastic mode."
        parts.append(prose(f"Damping ratios are those of the dampers of the data. {added}"))
    if undamped and len(undamped) < count:
        told = "Where it stands empty, no mode without damping has a shape like it."
        parts.append(prose(told))
    moving = [name for name in found.angles if np.abs(found.shape(name)).max() > _STILL]
    for first in range(0, count, _SHAPES):
        drawn = range(first, min(first + _SHAPES, count))
        last = drawn[-1] + 1
        name = f"Modes {first + 1} to {last}" if last > first + 1 else f"Mode {last}"
        caption = f"{name}, each angle that of its own shaft"
        picture = found.plot(moving, modes=drawn, units=study.units)
        parts.append(inline(picture, caption, f"shapes-{first}"))
    return "\n".join(parts)


def holzer_tables(study: Study) -> str:
    """Holzer tables of the modes that the orders reach at the speeds of the responses."""
    drive = study.drive
    if not isinstance(drive, MassElastic):
        return prose(drive)
    frequency, (low, high) = study.frequency, study.reach
    between = f"{number(frequency.value(low), 4)} to {number(frequency.value(high), 4)}"
    told = prose(
        "Modes without damping of the inertias and stiffnesses above, from "
        f"{between} {frequency.unit}, which the orders of the Campbell diagram reach "
        "at the speeds of the response. The largest angle, referred to the reference shaft, is "
        "1 rad; angles and torques are those of each part on its own shaft."
    )
    parts = [told]
    for mode in np.flatnonzero((drive.hertz >= low) & (drive.hertz <= high)).tolist():
        found = drive.holzer(mode)
        own = study.counterparts[mode]
        name = "No mode of the damped drive" if own is None else f"Mode {own + 1}"
        hertz = f"{number(frequency.value(found.hertz))} {frequency.unit}"
        parts.append(f"<h3>{name}: {hertz} without damping</h3>")
        head, rows = found.list_parts(Shown("rad"), study.units, 5)
        parts.append(table(head, rows, range(1, len(head))))
        parts.append(prose(f"Torques balance to {max(found.residual, 1e-16):.0e} of the largest."))
        picture = found.plot(units=study.units)
        parts.append(inline(picture, f"{name}, referred", f"holzer-{mode}"))
    if len(parts) == 1:
        parts.append(prose("There is none."))
    return "\n".join(parts)
