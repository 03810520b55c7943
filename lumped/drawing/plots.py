"""Pictures of results; each function returns a matplotlib Figure that needs no display."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from lumped.compiler.system import Name
from lumped.errors import OptionError

if TYPE_CHECKING:
    from lumped.simulation.sizing import Sizing
    from lumped.simulation.work_precision import WorkPrecision
    from lumped.timeloop.result import Trajectory
    from lumped.timeloop.result_files import Saved
    from lumped.vibration.campbell import Campbell
    from lumped.vibration.modes import Modes
    from lumped.vibration.response import FrequencyResponse
    from lumped.vibration.root_locus import RootLocus

__all__ = [
    "campbell",
    "frequency_response",
    "mode_shapes",
    "root_locus",
    "tornado",
    "torque_speed",
    "trajectory",
    "work_precision",
]

_WIDTH = 8.0  # inch
_MOST_MODES = 16
_MOST_BARS = 12
_LINES = ("-", "--", ":", "-.")  # after ten colours


def trajectory(run: Trajectory | Saved, names: Iterable[Name] | None = None) -> Figure:
    """Curves over time, one panel for each unit; events are thin vertical lines.

    Parameters
    ----------
    run : Trajectory or Saved
        From `lumped.simulate` or `lumped.load`.
    names : iterable of names or references, optional
        Quantities to draw; default is all states (of a file that does not tell them, such as a
        csv, all quantities).

    Raises
    ------
    OptionError
        If there is nothing to draw.
    """
    title, chosen = run._drawn(names)
    if not len(run.t):
        raise OptionError(f"{title}: nothing was computed, so there is nothing to draw.")
    panels: dict[str, list[str]] = {}
    texts: dict[str, set[str]] = {}
    for name, (unit, text) in chosen.items():
        panels.setdefault(unit, []).append(name)
        texts.setdefault(unit, set()).add(text)
    if not panels:
        raise OptionError(f"{title}: no states to draw; name the quantities to see.")
    figure = Figure((_WIDTH, 0.6 + 2.4 * len(panels)), layout="constrained")
    axes = figure.subplots(len(panels), sharex=True, squeeze=False).ravel()
    for axis, (unit, members) in zip(axes, panels.items(), strict=True):
        for i, name in enumerate(members):
            line = _LINES[i // 10 % len(_LINES)]
            axis.plot(run.t, run[name], line, color=f"C{i % 10}", label=name)
        for event in run.events:
            axis.axvline(event.time, color="grey", linewidth=0.6)
        (text,) = texts[unit] if len(texts[unit]) == 1 else ("",)
        axis.set_ylabel(f"{text}, {unit}" if text else unit)
        axis.grid(alpha=0.3)
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    axes[-1].set_xlabel("time, s")
    axes[-1].set_xlim(run.t[0], run.t[-1])
    figure.suptitle(title)
    return figure


def mode_shapes(
    found: Modes, names: Iterable[Name] | None = None, modes: Iterable[int] | None = None
) -> Figure:
    """Amplitudes along the drive, one panel for each mode.

    Where modes are damped the parts do not pass zero together; dashed lines then show what moves
    a quarter of a period apart. Of more than 16 modes the lowest are drawn, which the title says.

    Parameters
    ----------
    found : Modes
        From `lumped.modes`.
    names : iterable of names or references, optional
        Quantities in the order along the drive; default is all angles and positions in the
        order of their declaration.
    modes : iterable of int, optional
        Numbers of the modes to draw, from 0; default is all.

    Raises
    ------
    OptionError
        If there is no oscillating mode, none of a number, or no quantity is named.
    """
    system, every = found.system, len(found.hertz)
    if not every:
        raise OptionError(f"{system.name}: no oscillating mode to draw.")
    drawn = list(range(min(every, _MOST_MODES))) if modes is None else list(modes)
    for number in drawn:
        if not 0 <= number < every:
            raise OptionError(
                f"{system.name}: modes = {drawn}: there is no mode {number}; {every} modes count "
                f"from 0 to {every - 1}."
            )
    if not drawn:
        raise OptionError(f"{system.name}: modes = []: give the number of at least one mode.")
    count = len(drawn)
    chosen = found.angles if names is None else [system.key(n) for n in names]
    if not chosen:
        raise OptionError(f"{system.name}: name at least one quantity to draw.")
    shapes = np.array([found.shape(name)[drawn] for name in chosen])
    columns = 1 if count <= 4 else 2
    lines = -(-count // columns)
    figure = Figure((_WIDTH, 1.2 + 1.9 * lines), layout="constrained")
    grid = figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False)
    place = np.arange(len(chosen))
    damped = np.abs(shapes.imag).max() > 1e-6
    for i, axis in enumerate(grid.T.ravel()[:count]):
        axis.axhline(0, color="black", linewidth=0.8)
        axis.plot(place, shapes[:, i].real, "o-", markersize=4, label="in phase")
        if damped:
            axis.plot(
                *(place, shapes[:, i].imag, "o--"),
                color="grey",
                markersize=3,
                label="a quarter of a period apart",
            )
        axis.set_title(
            f"{found.hertz[drawn[i]]:.4g} Hz, damping ratio {found.damping[drawn[i]]:.3g}",
            fontsize="medium",
        )
        axis.grid(alpha=0.3)
        axis.set_ylim(-1.15, 1.15)
    for axis in grid.T.ravel()[count:]:
        axis.set_visible(False)
    for axis in grid[-1]:
        angle = 30 if len(chosen) * columns <= 10 else 90
        axis.set_xticks(place, chosen, rotation=angle, ha="right", rotation_mode="anchor")
    if damped:
        lines_drawn, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(lines_drawn, labels, loc="outside lower center", ncols=2)
    figure.supylabel("relative amplitude")
    title = system.name
    if modes is None and count < every:
        title += f": the {count} lowest of {every} modes; modes= chooses others"
    figure.suptitle(title)
    return figure


def frequency_response(
    response: FrequencyResponse, outputs: Iterable[Name] | None = None
) -> Figure:
    """Magnitude (logarithmic) and phase over the frequency, one pair of panels for each output.

    Parameters
    ----------
    response : FrequencyResponse
        From `lumped.frequency_response`.
    outputs : iterable of names or references, optional
        Outputs to draw; default is all.

    Raises
    ------
    OptionError
        If no output is named.
    """
    system = response.system
    chosen = response.outputs if outputs is None else [system.key(name) for name in outputs]
    if not chosen:
        raise OptionError(f"{system.name}: name at least one output to draw.")
    figure = Figure((_WIDTH, 0.6 + 3.6 * len(chosen)), layout="constrained")
    axes = figure.subplots(2 * len(chosen), sharex=True, height_ratios=[2, 1] * len(chosen))
    for size, angle, output in zip(axes[::2], axes[1::2], chosen, strict=True):
        for i, given in enumerate(response.inputs):
            line, colour = _LINES[i // 10 % len(_LINES)], f"C{i % 10}"
            magnitude = response.magnitude(output, given)
            size.plot(response.hertz, magnitude, line, color=colour, label=given)
            degrees = np.degrees(response.phase(output, given))
            angle.plot(response.hertz, degrees, line, color=colour)
        size.set_yscale("log")
        size.set_title(output, fontsize="medium")
        size.set_ylabel(f"{system.quantity(output).unit} for each unit")
        size.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
        angle.set_ylabel("phase, deg")
        for axis in (size, angle):
            axis.grid(alpha=0.3)
    axes[-1].set_xlabel("frequency, Hz")
    axes[-1].set_xlim(response.hertz[0], response.hertz[-1])
    figure.suptitle(system.name)
    return figure


def torque_speed(demand: Sizing) -> Figure:
    """Plane of speed and torque: the run, the limits in all four quadrants, the thermal point.

    Parameters
    ----------
    demand : Sizing
        From `lumped.simulation.sizing`.
    """
    speed, torque = demand.points
    figure = Figure((_WIDTH, 5.0), layout="constrained")
    axis = figure.subplots()
    axis.plot(speed, torque, color="C0", label="run")
    reach = 1.1 * demand.peak_speed
    limits = ((demand.maximum, "C3", "maximum"), (demand.rated, "C2", "rated"))
    for limit, colour, label in limits:
        if limit is None:
            continue
        if isinstance(limit, float | int):
            w, bound = np.array([0.0, reach]), np.full(2, limit)
        else:  # the first torque holds below the first row, none beyond the last
            rows = np.array([(0.0, limit[0][1]), *limit, (limit[-1][0], 0.0)])
            w, bound = rows.T
        for sign in (1, -1):
            both = np.concatenate([-w[::-1], w])
            axis.plot(
                *(both, sign * np.concatenate([bound[::-1], bound])),
                color=colour,
                label=label if sign > 0 else None,
            )
    axis.plot(demand.mean_speed, demand.rms_torque, "o", color="C2", label="thermal equivalent")
    for line in (axis.axhline, axis.axvline):
        line(0, color="black", linewidth=0.8)
    torque_unit, speed_unit = demand.units
    turning = torque_unit == "N.m"
    axis.set_xlabel(f"{'angular velocity' if turning else 'speed'}, {speed_unit}")
    axis.set_ylabel(f"{'torque' if turning else 'force'}, {torque_unit}")
    axis.grid(alpha=0.3)
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return figure


def tornado(ranked: Sequence[tuple[str, float]], title: str, what: str) -> Figure:
    """Change of a number by 1 % of each parameter, the most effective on top.

    Parameters
    ----------
    ranked : sequence of (str, float)
        Names and relative sensitivities, the largest first.
    title, what : str
        Title, and what changes.
    """
    most = ranked[:_MOST_BARS]
    figure = Figure((_WIDTH, 1.2 + 0.3 * len(most)), layout="constrained")
    axis = figure.subplots()
    place = np.arange(len(most))
    percent = [value for _, value in most]
    axis.barh(place, percent, color=["C0" if value >= 0 else "C3" for value in percent])
    axis.set_yticks(place, [name for name, _ in most])
    axis.invert_yaxis()
    axis.axvline(0, color="black", linewidth=0.8)
    axis.grid(alpha=0.3, axis="x")
    axis.set_xlabel(f"change of {what} by 1 % of the parameter, %")
    figure.suptitle(title)
    return figure


def campbell(diagram: Campbell) -> Figure:
    """Natural frequencies over the speed, rays of the orders, and points where they meet.

    Parameters
    ----------
    diagram : Campbell
        From `lumped.campbell`.
    """
    figure = Figure((_WIDTH, 5.0), layout="constrained")
    axis = figure.subplots()
    rpm = diagram.speeds * 30 / np.pi
    axis.plot(rpm, diagram.hertz, color="C0")
    for order in diagram.orders:
        axis.plot(rpm, order * rpm / 60, color="grey", linewidth=0.8)
        axis.annotate(f"{order:g}", (rpm[-1], order * rpm[-1] / 60), color="grey")
    axis.plot(
        [c.rpm for c in diagram.critical], [c.hertz for c in diagram.critical], "o", color="C3"
    )
    top = np.nanmax(diagram.hertz, initial=0.0)
    axis.set_ylim(0, 1.15 * (top or max(diagram.orders) * rpm[-1] / 60))
    axis.set_xlim(rpm[0], rpm[-1])
    axis.set_xlabel("speed, 1/min")
    axis.set_ylabel("frequency, Hz")
    axis.grid(alpha=0.3)
    figure.suptitle(diagram.system.name)
    return figure


def root_locus(locus: RootLocus) -> Figure:
    """Eigenvalues in the complex plane, upper half; a circle marks the first value, a dot the last.

    Parameters
    ----------
    locus : RootLocus
        From `lumped.vibration.root_locus`.
    """
    figure = Figure((_WIDTH, 5.0), layout="constrained")
    axis = figure.subplots()
    hertz = locus.eigenvalues / (2 * np.pi)
    upper = (locus.eigenvalues.imag > 0).any(axis=0)
    for i, column in enumerate(np.flatnonzero(upper).tolist()):
        path = np.where(hertz[:, column].imag >= 0, hertz[:, column], np.nan)
        colour = f"C{i % 10}"
        axis.plot(path.real, path.imag, color=colour)
        axis.plot(path.real[0], path.imag[0], "o", color=colour, fillstyle="none")
        axis.plot(path.real[-1], path.imag[-1], "o", color=colour)
    axis.axvline(0, color="black", linewidth=0.8)
    axis.set_xlabel("real part / (2 pi), 1/s")
    axis.set_ylabel("imaginary part / (2 pi), Hz")
    axis.grid(alpha=0.3)
    figure.suptitle(
        f"{locus.system.name}: {locus.parameter} from {locus.values[0]:g} (circle) to "
        f"{locus.values[-1]:g} (dot)"
    )
    return figure


def work_precision(found: WorkPrecision) -> Figure:
    """Run time over error, both logarithmic, one line for each method; failed runs are left out.

    Parameters
    ----------
    found : WorkPrecision
        From `lumped.simulation.work_precision`.
    """
    figure = Figure((_WIDTH, 5.0), layout="constrained")
    axis = figure.subplots()
    marks = "os^Dv"
    for i, method in enumerate(dict.fromkeys(row.method for row in found.rows)):
        rows = [r for r in found.rows if r.method == method and np.isfinite(r.error)]
        error = [max(r.error, found.reference_error) for r in rows]
        mark = f"-{marks[i % len(marks)]}"
        axis.plot(error, [1e3 * r.seconds for r in rows], mark, label=method, fillstyle="none")
    axis.axvline(found.reference_error, color="grey", linewidth=0.8, linestyle="--")
    axis.annotate(
        "error of the reference",
        (found.reference_error, 0.98),
        xycoords=("data", "axes fraction"),
        rotation=90,
        va="top",
        ha="right",
        color="grey",
    )
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlabel("largest error, relative to the range of the signal")
    axis.set_ylabel("run time, ms")
    axis.grid(alpha=0.3, which="both")
    axis.legend(frameon=False)
    figure.suptitle(found.system.name)
    return figure
