"""How long does the same run take elsewhere?

The smooth drive of three masses and the chain of 300 of `time_loop`, by lumped and by other
packages (the extra `bench`), each with the tolerance that brings its error near 1e-6, against the
reference of `time_loop`. Packages without components get the right-hand side of `time_loop` in
NumPy. SciPy has the method that it has there, the others the fastest found. Set-up goes from the
description to the end of the first run, less the best time of a run and without the imports; lumped
makes its machine code anew, that of the time loop too. What a package does again in each run counts
as run. Each row is the best of all runs in some seconds of a process of its own; read the ratios.

    python -m benchmarks.run_peers
"""

import importlib
import itertools
import os
import tempfile
import time
import warnings
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

import lumped as lp
from benchmarks.harness import publish
from benchmarks.time_loop import ROW, THREE, Masses
from lumped.timeloop.plants.executable import executable

SECONDS, ROUNDS, LIMIT = 4.0, 300, 90.0  # of the runs, at most so many; of the whole process


PROBLEMS = {"three masses, 2 s": THREE, "300 masses, 1 s": ROW}
Way = tuple[Callable[[], Any], Callable[[Any], np.ndarray]]
"""A run, and what finds the twists and speeds at its end."""


def in_lumped(problem: Masses, rtol: float) -> Way:
    """Assembled, with explicit steps and compiled functions."""
    system, until = lp.assemble(problem.model()), problem.until
    executable(system).compile()

    def run() -> lp.Trajectory:
        return lp.simulate(system, until=until, rtol=rtol, grid=[until], method="steps")

    return run, lambda found: np.array([found[name][-1] for name in problem.names])


def in_scipy(problem: Masses, rtol: float) -> Way:
    """SciPy's DOP853."""
    return problem.by_scipy(rtol), np.asarray


def in_cvode(problem: Masses, rtol: float, **options: object) -> Way:
    """CVODE's Adams method; twists and speeds alternate, so that its matrices are banded."""
    from sksundae.cvode import CVODE

    n = len(problem.names)
    order = np.concatenate([np.arange(1, n, 2), np.arange(0, n, 2)])  # of twists, then speeds

    def rate(t: float, y: np.ndarray, yp: np.ndarray) -> None:
        yp[order] = problem.rate(t, y[order])

    solver = CVODE(
        rate, method="Adams", rtol=rtol, atol=rtol * 1e-3, max_num_steps=100_000, **options
    )

    def run() -> np.ndarray:
        y = np.zeros(n)
        for begin, end in itertools.pairwise(problem.edges):
            found = solver.solve(np.array([begin, np.nextafter(end, begin)]), y)
            if not found.success:
                raise RuntimeError(found.message)
            y = found.y[-1]
        return y

    return run, lambda y: y[order]


def in_exudyn(problem: Masses, rtol: float, matrices: str) -> Way:
    """Items of one coordinate, the motor's torque as a symbolic function of exudyn, DOPRI5."""
    import exudyn as exu
    from exudyn import itemInterface as items  # noqa: N813
    from exudyn.utilities import CreateSymbolicUserFunction

    container = exu.SystemContainer()
    system, last = container.AddSystem(), len(problem.J) - 1
    markers = []
    for inertia in problem.J:
        node = system.AddNode(items.Node1D())
        system.AddObject(items.Mass1D(mass=inertia, nodeNumber=node))
        markers.append(system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=0)))
    for ends, c, d in zip(itertools.pairwise(markers), problem.c, problem.d, strict=True):
        system.AddObject(
            items.CoordinateSpringDamper(markerNumbers=[*ends], stiffness=c, damping=d)
        )

    def torque(mbs: object, t: Any, load: object) -> Any:
        return problem.amplitude * exu.symbolic.sin(problem.frequency * t)

    motor = CreateSymbolicUserFunction(
        system, torque, "loadUserFunction", itemTypeName="LoadCoordinate"
    )
    system.AddLoad(items.LoadCoordinate(markerNumber=markers[0], loadUserFunction=motor))
    load = system.AddLoad(items.LoadCoordinate(markerNumber=markers[last], load=0.0))
    system.Assemble()

    settings = exu.SimulationSettings()
    settings.linearSolverType = getattr(exu.LinearSolverType, matrices)
    settings.solution.file.write = False
    integration = settings.timeIntegration
    integration.numberOfSteps = 1  # one as a limit: the tolerance sets their length
    integration.initialStepSize, integration.minimumStepSize = 1e-4, 1e-10
    integration.relativeTolerance, integration.absoluteTolerance = rtol, rtol * 1e-3
    integration.explicit.computeEndOfStepAccelerations = False
    rest, initial, data = np.zeros(last + 1), exu.ConfigurationType.Initial, system.systemData

    def run() -> tuple[np.ndarray, np.ndarray]:
        assert motor is not None  # exudyn does not keep the function alive
        data.SetODE2Coordinates(rest, initial)
        data.SetODE2Coordinates_t(rest, initial)
        sections = itertools.pairwise(problem.edges)
        for (begin, end), value in zip(sections, problem.loads, strict=True):
            system.SetLoadParameter(load, "load", value)
            integration.startTime, integration.endTime = begin, end
            if not system.SolveDynamic(
                settings, exu.DynamicSolverType.DOPRI5, updateInitialValues=True
            ):
                raise RuntimeError("the solver stopped")
        return data.GetODE2Coordinates(), data.GetODE2Coordinates_t()

    return run, lambda found: np.concatenate([np.diff(found[0]), found[1]])


MODELICA = """
connector Flange
  Real phi;
  flow Real tau;
end Flange;
model Inertia
  Flange flange_a, flange_b;
  parameter Real J = 1;
  Real phi, w;
equation
  phi = flange_a.phi;
  phi = flange_b.phi;
  w = der(phi);
  J * der(w) = flange_a.tau + flange_b.tau;
end Inertia;
model Shaft
  Flange flange_a, flange_b;
  parameter Real c = 1, d = 1;
  Real phi_rel, tau;
equation
  phi_rel = flange_b.phi - flange_a.phi;
  tau = c * phi_rel + d * der(phi_rel);
  flange_b.tau = tau;
  flange_a.tau = -tau;
end Shaft;
model Torque
  Flange flange;
  Real tau;
equation
  flange.tau = -tau;
end Torque;
model Drive
  Inertia body[{n}](J = {J});
  Shaft shaft[{n} - 1](c = {c}, d = {d});
  Torque motor, load;
equation
  motor.tau = {amplitude} * sin({frequency} * time);
  load.tau = {load};
  connect(motor.flange, body[1].flange_a);
  for i in 1:{n} - 1 loop
    connect(body[i].flange_b, shaft[i].flange_a);
    connect(shaft[i].flange_b, body[i + 1].flange_a);
  end for;
  connect(body[{n}].flange_b, load.flange);
end Drive;
"""


def in_rumoca(problem: Masses, rtol: float) -> Way:
    """Compiled Modelica, with the explicit one of its solvers."""
    import rumoca

    n, load = len(problem.J), str(problem.loads[-1])
    for edge, value in reversed(list(zip(problem.edges[1:-1], problem.loads, strict=False))):
        load = f"if time < {edge} then {value} else ({load})"
    values: dict[str, object] = {"n": n, "load": load}
    values |= {"amplitude": problem.amplitude, "frequency": problem.frequency}
    for name in ("J", "c", "d"):
        values[name] = "{" + ", ".join(map(str, getattr(problem, name).tolist())) + "}"
    source = MODELICA
    for name, value in values.items():
        source = source.replace("{" + name + "}", str(value))
    model = rumoca.Session().loads(source, model="Drive")
    config = rumoca.SimConfig(solver="rk-like", rtol=rtol, atol=rtol * 1e-3)
    wanted = [f"shaft[{i}].phi_rel" for i in range(1, n)]
    wanted += [f"body[{i}].w" for i in range(1, n + 1)]
    return (
        lambda: model.simulate((0.0, problem.edges[-1]), config=config),
        lambda found: np.array([found[name][-1] for name in wanted]),
    )


Plan = tuple[str, str, Callable[..., Way], tuple[object, ...], dict[str, object]]
"""Package, method, what makes the run, its tolerance and other arguments."""

PLANS: dict[str, list[Plan]] = {
    "three masses, 2 s": [
        ("lumped", "DOP853", in_lumped, (1e-5,), {}),
        ("scipy", "DOP853, NumPy", in_scipy, (1e-5,), {}),
        ("exudyn", "DOPRI5", in_exudyn, (1e-7, "EXUdense"), {}),
        ("rumoca", "rk-like", in_rumoca, (3e-7,), {}),
        ("scikit-sundae", "CVODE Adams, NumPy", in_cvode, (4e-6,), {}),
    ],
    "300 masses, 1 s": [
        ("lumped", "DOP853", in_lumped, (4e-8,), {}),
        ("scipy", "DOP853, NumPy", in_scipy, (4e-8,), {}),
        ("exudyn", "DOPRI5, sparse", in_exudyn, (5e-8, "EigenSparse"), {}),
        ("rumoca", "rk-like", in_rumoca, (1e-7,), {}),
        (
            *("scikit-sundae", "CVODE Adams, banded, NumPy", in_cvode, (1e-8,)),
            {"linsolver": "band", "lband": 2, "uband": 2},
        ),
    ],
}


def measure(pipe: Connection, problem: str, place: int) -> None:
    """Send set-up and run in seconds with the states at the end, or what went wrong."""
    package, _, make, arguments, options = PLANS[problem][place]
    warnings.simplefilter("ignore")
    try:
        importlib.import_module({"scikit-sundae": "sksundae"}.get(package, package))
        begin = time.perf_counter()
        run, at_end = make(PROBLEMS[problem], *arguments, **options)
        built = time.perf_counter()
        found = run()
        first = now = time.perf_counter()
        best, rounds = np.inf, 0
        while rounds == 0 or (now - first < SECONDS and rounds < ROUNDS):
            found = run()
            before, now, rounds = now, time.perf_counter(), rounds + 1
            best = min(best, now - before)
        setup = built - begin + max(first - built - best, 0.0)
        pipe.send((setup, best, at_end(found)))
    except Exception as error:
        pipe.send(f"{type(error).__name__}: {error}".splitlines()[0][:80])


def within_limit(problem: str, place: int) -> tuple[float, float, np.ndarray] | str:
    """What a process of its own has measured, or the reason why there is nothing."""
    try:
        version(PLANS[problem][place][0])
    except PackageNotFoundError:
        return "not installed"
    context = get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["LUMPED_CACHE"] = folder
        process = context.Process(target=measure, args=(sender, problem, place))
        process.start()
        sender.close()
        try:
            found = receiver.recv() if receiver.poll(LIMIT) else f"over {LIMIT:.0f} s"
        except EOFError:
            found = "ended without a result"
        process.kill()
        process.join()
    return found


def rows_of(name: str) -> list[tuple[str, ...]]:
    """All packages on one problem."""
    problem, rows, own = PROBLEMS[name], [], np.nan
    reference = problem.by_scipy(1e-13)()
    for place, (package, method, _, arguments, _) in enumerate(PLANS[name]):
        found = within_limit(name, place)
        if isinstance(found, str):
            given = "" if found == "not installed" else f" {version(package)}"
            rows.append((name, package + given, f"{method}: {found}", "", "", "", ""))
            continue
        setup, seconds, x = found
        own = seconds if place == 0 else own
        error = np.abs(x - reference).max() / np.abs(reference).max()
        cells = (f"{method}, rtol {arguments[0]:.0e}", f"{error:.1e}", f"{seconds * 1e3:.3f}")
        rows.append(
            (name, f"{package} {version(package)}", *cells, f"{setup:.4f}", f"{seconds / own:.2f}")
        )
    return rows


def main() -> None:
    """Print the table and write it to the results."""
    rows = [row for name in PROBLEMS for row in rows_of(name)]
    head = ("problem", "package", "method", "error", "ms", "set-up, s", "ratio to lumped")
    publish("run_peers", head, rows)


if __name__ == "__main__":
    main()
