"""Linkages in motion: the outlines of components over a run, as a film."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import casadi as ca
import numpy as np
from matplotlib import animation
from matplotlib.figure import Figure

from lumped.errors import OptionError, UnknownNameError, told_by
from lumped.flattening.tree import Instance
from lumped.language.expression import Expr, Ref, as_expr
from lumped.language.lowering import lower
from lumped.language.quantity import Param
from lumped.support.arguments import checked
from lumped.timeloop.results.trajectory import Trajectory

MOST = 300  # frames
SIZE = (5.0, 4.0)  # inch
DOTS = 115  # per inch; letters of 10 points are 16 pixels high


@checked
def animate(run: Trajectory, path: str | Path, *, frames: int = 80, seconds: float = 4.0) -> Path:
    """Film of the linkages in a run: cranks, rods, arms and sliders in their plane.

    Parameters
    ----------
    run : Trajectory
        From `lumped.simulate`.
    path : str or Path
        File to write: .gif, or .mp4 if the program ffmpeg is installed.
    frames : int
        Pictures, evenly spaced over the time of the run; at most 300.
    seconds : float
        Duration of the film.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    OptionError
        If no component moves in a plane, or the options make no sense.
    UnknownNameError
        If positions were left out of the system and nobody can make the run again; the text says
        how to keep them.
    """
    target = Path(path)
    if not (isinstance(frames, int) and 2 <= frames <= MOST):
        raise OptionError(f"animate: frames = {frames!r}; from 2 to {MOST} are possible.")
    if not 0 < seconds < float("inf"):
        raise OptionError(f"animate: seconds = {seconds!r}; a positive duration is needed.")
    if target.suffix not in (".gif", ".mp4"):
        raise OptionError(f"animate: '{target.name}' ends neither in .gif nor in .mp4.")
    if target.suffix == ".mp4" and not animation.FFMpegWriter.isAvailable():
        raise OptionError(
            f"animate: '{target.name}' needs the program ffmpeg, which is not on the PATH. Write "
            "a .gif instead."
        )
    times = np.linspace(run.t[0], run.t[-1], frames)
    lines = moving_lines(run, times)
    if not lines:
        raise OptionError(
            f"{run.system.name}: no component has an outline; there is nothing to move. A "
            "component class tells its points by a method `outline`."
        )
    figure = Figure(SIZE, layout="constrained")
    axis = figure.subplots()
    everything = np.concatenate([points.reshape(-1, 2) for points in lines.values()])
    low, high = everything.min(axis=0), everything.max(axis=0)
    middle, size = (low + high) / 2, high - low
    half = np.maximum(size, 0.5 * size.max()) * 0.56
    axis.set_aspect("equal")
    axis.set(xlim=middle[0] + half[0] * np.array([-1, 1]), xlabel="x, m")
    axis.set(ylim=middle[1] + half[1] * np.array([-1, 1]), ylabel="y, m")
    axis.grid(alpha=0.3)
    owners = list(dict.fromkeys(name.rpartition(".")[0] for name in lines))
    drawn = []
    for name, points in lines.items():
        style = "s" if points.shape[1] == 1 else "o-"
        colour = f"C{owners.index(name.rpartition('.')[0]) % 10}"
        size = 8 if points.shape[1] == 1 else 4
        drawn.append(axis.plot([], [], style, color=colour, markersize=size, linewidth=2)[0])
    writer = animation.PillowWriter if target.suffix == ".gif" else animation.FFMpegWriter
    film = writer(fps=frames / seconds)  # type: ignore[arg-type]
    with film.saving(figure, str(target), DOTS):
        for k, time in enumerate(times):
            for curve, points in zip(drawn, lines.values(), strict=True):
                curve.set_data(*points[k].T)
            axis.set_title(f"{run.system.name}, t = {time:.3f} s", fontsize="medium")
            film.grab_frame()
    return target


def moving_lines(run: Trajectory, times: np.ndarray) -> dict[str, np.ndarray]:
    """Outlines of all components at given times.

    Parameters
    ----------
    run : Trajectory
        From `lumped.simulate`.
    times : ndarray, shape (k,)
        Times within the run, s; quantities are interpolated linearly between output points.

    Returns
    -------
    dict of str to ndarray, shape (k, points, 2)
        Positions in m, by the component's path and the name of the line.
    """
    tree = run.system.structure.tree
    parameters = run.system.structure.parameters
    values = parameters.all(run.theta)
    missing: dict[str, None] = {}

    def leaf(ref: Expr, scope: Instance) -> ca.SX:
        assert isinstance(ref, Ref)
        owner = tree.find(ref.owner, scope)
        assert owner is not None
        name = owner.name(ref.name)
        if isinstance(ref.quantity, Param):
            return ca.SX(values[tree.parameter(name)])
        if name not in run:
            missing[name] = None
            return ca.SX(0.0)
        return ca.SX(np.interp(times, run.t, run[name]))

    lines = {}
    for node in tree.instances:
        with told_by(node.label, "outline()"):
            outlines = list(node.component.outline())
        for name, points in outlines:
            lowered = (
                ca.DM(lower(as_expr(value), partial(leaf, scope=node)))
                for point in points
                for value in point
            )
            columns = [np.broadcast_to(np.asarray(each).ravel(), len(times)) for each in lowered]
            lines[node.name(name)] = np.column_stack(columns).reshape(len(times), len(points), 2)
    if missing:
        raise UnknownNameError(
            f"{run.system.name}: positions to be drawn were left out of the system. Ask for them: "
            f"assemble(model, keep={list(missing)})."
        )
    return lines
