"""Exported models, run by FMPy."""

import itertools

import numpy as np
import pytest
from rows import in_rows

import lumped as lp
from lumped.components import Filter, Limiter

fmpy = pytest.importorskip("fmpy")
validate_fmu = pytest.importorskip("fmpy.validation").validate_fmu

LIMITED = in_rows(
    "first.y limiter.u",
    "limiter.y lag.u",
    first=Filter(T=1.0, u=0.0, x=3.0),
    limiter=Limiter(y_min=-1.0, y_max=2.0),
    lag=Filter(T=0.1),
    initial_equations=lambda m: [lp.der(m.lag.x) == 0],
)
"""A lag that starts at rest behind a limiter: its start follows from a condition."""

KINDS = {"ModelExchange": 1e-10, "CoSimulation": 1e-9}
"""Relative tolerances; the first is that of FMPy's own integrator."""


def runs(
    system, folder, *, until, points=100, versions=("2.0", "3.0"), kinds=tuple(KINDS), **options
):
    """Version, kind and trajectory of an exported model, for each version and kind."""
    given = {k: options.pop(k) for k in ("inputs", "outputs", "start") if k in options}
    for version, kind in itertools.product(versions, kinds):
        path = folder / f"{system.name}_{version}.fmu"
        if not path.exists():
            lp.export_fmu(system, path, version=version, **given)
            assert validate_fmu(str(path)) == []
        names = [*given.get("outputs", ()), *(n for n in system.state_names if "(" not in n)]
        found = fmpy.simulate_fmu(
            str(path),
            fmi_type=kind,
            stop_time=until,
            output_interval=until / points,
            relative_tolerance=KINDS[kind],
            output=names,
            **{"record_events": False} | options,
        )
        yield version, kind, found


def deviation(found, run, away=1e-6):
    """Largest deviation of any quantity, relative to its greatest value; not at events."""
    instants = np.array([-1.0, *(event.time for event in run.events)])
    smooth = np.abs(found["time"][:, None] - instants).min(axis=1) > away
    places = np.searchsorted(run.t, found["time"] - 1e-9)
    assert np.abs(run.t[places] - found["time"])[smooth].max() < 1e-9
    worst = 0.0
    for name in found.dtype.names[1:]:
        expected = run[name][places]
        size = np.abs(expected).max() or 1.0
        worst = max(worst, np.abs(found[name] - expected)[smooth].max() / size)
    return worst


def compare(system, folder, *, until, points=100, limit=1e-6, start=None, parameters=None, **more):
    """Compare an exported model with the run that it should make."""
    options = {"until": until, "start": start, "parameters": parameters}
    run = lp.simulate(system, grid=points, rtol=1e-11, **options)
    more |= {"start": start} if start else {}
    more |= {"start_values": dict(parameters)} if parameters else {}
    for version, kind, found in runs(system, folder, until=until, points=points, **more):
        assert len(found) == points + 1
        error = deviation(found, run)
        print(f"{system.name} {version} {kind}: {error:.1e}")
        assert error <= limit
    return run
