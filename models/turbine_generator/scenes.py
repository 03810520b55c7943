"""Faults at the terminals of the turbine generator, from rated load."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import lumped as lp
from lumped.errors import OptionError
from lumped.models.turbine_generator.drive import (
    BASE,
    SHAFTS,
    Compensated,
    Reclosed,
    Train,
    TurbineGenerator,
)

FREE = ["bus.V", "bus.phase", "gen.v_f", "turbine.steam"]
"""What follows from the state at the start: bus, excitation, steam."""
_NEAR = 8.0
"""Eigenvalues as near to a torsional frequency are those of its mode, rad/s."""


def at_maximum(system: lp.System, parameters: Mapping[str, Any] | None = None) -> dict[str, float]:
    """Angle of the generator at the start: phase a has its largest voltage when the fault begins.

    Parameters
    ----------
    system : System
        Of a `Generator`.
    parameters : mapping, optional
        Parameters to change.

    Returns
    -------
    dict
        Start value of ``gen.phi``, rad.

    Raises
    ------
    OptionError
        If a parameter is given that follows from the start.
    """
    for name in sorted(set(FREE) & set(parameters or {})):
        raise OptionError(
            f"{system.name}: {name} follows from the steady state at the start. Change what it "
            "follows from: gen.P_0, gen.Q_0 or gen.V_0."
        )
    value = system.parameter_values(parameters)
    P, Q, V = (value[f"gen.{name}"] for name in ("P_0", "Q_0", "V_0"))
    w = 2 * np.pi * value["bus.f"]
    X_q = w * (value["gen.L_ls"] + value["gen.L_mq"])
    # the q axis lies along v + (R_s + j X_q) i, the d axis a quarter of a period behind
    inner = V - (value["gen.R_s"] + 1j * X_q) * (P - 1j * Q) / (1.5 * V)
    return {"gen.phi": float(np.angle(inner)) - np.pi / 2 - w * value["fault.begin"]}


def run_short_circuit(
    until: float = 0.52,
    phases: str = "abc",
    model: TurbineGenerator | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Short circuit at the terminals, which begins at 0.02 s.

    Parameters
    ----------
    until : float
        End of the run, s.
    phases : str
        "abc" for three phases, "bc" from line to line.
    model : TurbineGenerator, optional
        The machine; its fault gets these phases.
    **options
        Passed to `lumped.simulate`; `parameters` such as ``{"fault.end": 0.1}``.
    """
    system = lp.assemble((model or TurbineGenerator()).with_({"fault.phases": phases}))
    return _run(system, until, options)


def clear_faults(
    durations: ArrayLike, until: float = 0.8, parameters: Mapping[str, Any] | None = None
) -> lp.ensembles.Ensemble:
    """Largest torque of each shaft after three-phase faults that are cleared.

    Parameters
    ----------
    durations : array_like
        From the beginning of the fault to its clearing, s.
    until : float
        End of the runs, s.
    parameters : mapping, optional
        Parameters to change.

    Returns
    -------
    Ensemble
        N.m, by the names of the shafts.
    """
    system = lp.assemble(TurbineGenerator())
    point = find_rated_point(system, parameters)
    begin = system.parameter_values(parameters)["fault.begin"]
    ends = begin + np.asarray(durations, dtype=float)
    over: dict[str | lp.Expr, Any] = {"fault.end": ends}
    return lp.ensemble(
        system,
        over=over,
        until=until,
        start={name: point[name] for name in system.state_names},
        parameters={**(parameters or {}), **{name: point.parameters[name] for name in FREE}},
        of={text: lp.functionals.peak(torque) for text, torque in SHAFTS.items()},
    )


def run_reclosing(
    until: float = 0.6, model: Reclosed | None = None, **options: Any
) -> lp.Trajectory:
    """Three-phase fault cleared after 50 ms; then the breaker opens, and closes again.

    Parameters
    ----------
    until : float
        End of the run, s.
    model : Reclosed, optional
        The machine.
    **options
        Passed to `lumped.simulate`; `parameters` such as ``{"closes": 0.4}``.
    """
    return _run(lp.assemble(model or Reclosed()), until, options)


def find_growth(reactances: ArrayLike) -> np.ndarray:
    """Growth rates of the torsional modes on a line with a series capacitor, at rated load.

    Parameters
    ----------
    reactances : array_like, shape (n,)
        Of the capacitor, pu.

    Returns
    -------
    ndarray, shape (n, 5)
        For each mode, 1/s: the largest real part of the eigenvalues near its frequency.
    """
    system = lp.assemble(Compensated())
    torsional = 2 * np.pi * lp.modes(lp.assemble(Train())).hertz
    found = []
    for X_c in np.asarray(reactances, dtype=float).tolist():
        point = find_rated_point(system, {"X_c": X_c})
        roots = np.linalg.eigvals(lp.linearise(system, at=point).A)
        near = np.abs(roots.imag[:, None] - torsional) < _NEAR
        found.append(np.where(near, roots.real[:, None], -np.inf).max(axis=0))
    return np.array(found)


def find_rated_point(
    system: lp.System, parameters: Mapping[str, Any] | None = None
) -> lp.OperatingPoint:
    """The steady state before the fault."""
    start = at_maximum(system, parameters)
    return lp.start_point(system, start=start, free=FREE, parameters=parameters)


def per_unit(run: lp.Trajectory, torque: str) -> np.ndarray:
    """A torque of a run, positive in the direction in which the turbine drives."""
    found: np.ndarray = -run[torque] / BASE.tau
    return found


def _run(system: lp.System, until: float, options: dict[str, Any]) -> lp.Trajectory:
    start = at_maximum(system, options.get("parameters")) | options.pop("start", {})
    return lp.simulate(system, until=until, start=start, free=FREE, **options)
