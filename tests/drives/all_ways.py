"""One model, all ways: methods, exported units, and derivatives in three ways.

``python tests/drives/all_ways.py drives 60`` takes random drives, ``python tests/drives/all_ways.py
pages`` the scenes of the pages in ``docs/elements``. A way may refuse, by an error with a name; no
two ways may give different numbers.
"""

import importlib.util
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import lumped as lp
from lumped import functionals as fun
from lumped.errors import LumpedError

PAGES = Path(__file__).parents[2] / "docs" / "elements"
TIGHT = 1e-9


@dataclass
class Scene:
    """A system and how it is run."""

    name: str
    system: lp.System
    until: float
    start: dict = field(default_factory=dict)
    parameters: dict = field(default_factory=dict)

    def run(self, **options):
        return lp.simulate(
            self.system,
            until=self.until,
            start=self.start,
            parameters=self.parameters,
            **{"grid": 40, "rtol": TIGHT} | options,
        )


def quiet(grid: np.ndarray, run: lp.Trajectory, away: float) -> np.ndarray:
    """Which instants lie away from events."""
    events = np.array([-1.0, *(event.time for event in run.events)])
    return np.abs(grid[:, None] - events).min(axis=1) > away


class Ways:
    """All ways of one scene against its run by explicit or implicit steps."""

    def __init__(self, scene: Scene):
        self.scene, self.found = scene, {}
        self.names = [n for n in scene.system.state_names if "(" not in n]
        self.grid = np.linspace(0, scene.until, 41)
        self.best = scene.run(method="steps", grid=self.grid, rtol=TIGHT / 10)
        self.expected = self.best.table(self.names)
        self.scale = np.maximum(np.abs(self.expected).max(axis=0), 1e-6)
        self.keep = quiet(self.grid, self.best, 1e-5 * scene.until)

    def compare(self, way: str, received: np.ndarray, limit: float = 2e-6) -> None:
        error = (np.abs(received - self.expected) / self.scale)[self.keep].max(initial=0.0)
        self.found[way] = "agrees" if error <= limit else f"DEVIATES by {error:.1e}"

    def attempt(self, way: str, action) -> None:
        try:
            action()
        except LumpedError as refusal:
            self.found[way] = f"refused: {type(refusal).__name__}: {refusal}"
        except Exception as error:
            self.found[way] = f"RAW {type(error).__name__}: {error}"

    def methods(self) -> None:
        for method in ("explicit", "implicit", "exact", "auto"):

            def action(method=method):
                run = self.scene.run(method=method, grid=self.grid)
                self.compare(method, run.table(self.names))

            self.attempt(method, action)

    def unit(self, folder: Path) -> None:
        import fmpy

        def action():
            path = folder / "unit.fmu"
            given = {"start": self.scene.start} if self.scene.start else {}
            lp.export_fmu(self.scene.system, path, **given)
            found = fmpy.simulate_fmu(
                str(path),
                fmi_type="CoSimulation",
                stop_time=self.scene.until,
                output_interval=self.scene.until / 40,
                relative_tolerance=TIGHT,
                start_values=dict(self.scene.parameters),
                output=self.names,
                record_events=False,
            )
            self.compare("unit", np.column_stack([found[name] for name in self.names]), 1e-5)

        self.attempt("unit", action)

    def derivatives(self, to: list[str]) -> None:
        """`sensitivity`, `gradient` and differences of the states at the end of the run."""
        given = {
            "until": self.scene.until,
            "start": self.scene.start,
            "parameters": self.scene.parameters,
        }
        rates: dict[str, np.ndarray] = {}

        def forward():
            found = lp.sensitivity(
                self.scene.system, of=self.names, by=to, rtol=TIGHT, grid=4, **given
            )
            rates["sensitivity"] = found.derivatives[-1]

        def backward():
            of = [fun.final(name) for name in self.names]
            found = lp.gradient(self.scene.system, of=of, by=to, rtol=TIGHT, **given)
            rates["gradient"] = found.derivatives

        self.attempt("sensitivity", forward)
        self.attempt("gradient", backward)
        if not rates:
            return
        point = {name: self.scene.system.parameters[name] for name in to} | self.scene.parameters
        size = np.array([abs(point[name]) or 1.0 for name in to])

        def ends(k, step):
            values = self.scene.parameters | {to[k]: point[to[k]] + step * size[k]}
            run = lp.simulate(
                self.scene.system, **given | {"parameters": values}, rtol=1e-11, grid=1
            )
            return run.table(self.names)[-1]

        def differences():
            columns, doubt = [], []
            for k in range(len(to)):
                wide, near = ((ends(k, h) - ends(k, -h)) / (2 * h * size[k]) for h in (2e-5, 1e-5))
                columns.append(near)
                doubt.append(np.abs(wide - near))
            rates["differences"] = np.column_stack(columns)
            rates["doubt"] = np.column_stack(doubt)

        self.attempt("differences", differences)
        doubt = rates.pop("doubt", None)
        unit = self.scale[:, None] / size
        pairs = [("sensitivity", "gradient"), ("sensitivity", "differences")]
        for one, other in [*pairs, ("gradient", "differences")]:
            if one in rates and other in rates:
                slack = 2e-6 * (np.abs(rates[one]) + unit)
                if other == "differences":
                    slack = 1e-4 * (np.abs(rates[one]) + unit) + 3 * doubt
                error = np.abs(rates[one] - rates[other])
                way = f"{one} and {other}"
                worst = (error / (np.abs(rates[one]) + unit)).max()
                good = (error <= slack).all()
                self.found[way] = "agrees" if good else f"DEVIATES by {worst:.1e}"


def some_parameters(system: lp.System, rng, count=3) -> list[str]:
    """Names of parameters that can be changed and are not zero."""
    bounds = ("peak", "ratio", "restitution", "e")  # a step may leave their range
    found = system.parameters.items()
    names = [n for n, v in found if v and np.isfinite(v) and n.split(".")[-1] not in bounds]
    return sorted(rng.choice(names, min(count, len(names)), replace=False).tolist())


def drives(count: int) -> Iterator[Scene]:
    """Random drives over half a second."""
    from random_drives import RandomDrive

    for seed in range(2000, 2000 + count):
        drive = RandomDrive(seed)
        keep = [f"body{i}.phi" for i in range(len(drive.shafts))]
        yield Scene(f"drive {seed}", lp.assemble(drive.model(), keep=keep), 0.5)


def pages() -> Iterator[Scene]:
    """What the scripts simulate that draw the pictures of elements."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.figure import Figure

    calls, simulate = [], lp.simulate

    def recorded(system, **options):
        calls.append((system, options))
        return simulate(system, **options)

    Figure.savefig = lambda *_, **__: None
    for path in sorted(PAGES.glob("draw_*.py")):
        spec = importlib.util.spec_from_file_location(path.stem, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        for name in [n for n in vars(module) if n.startswith("draw_")]:
            lp.simulate = recorded
            try:
                getattr(module, name)()
            finally:
                lp.simulate = simulate
            for k, (system, options) in enumerate(calls):
                start = options.get("start") or {}
                if isinstance(start, dict):
                    given = dict(options.get("parameters") or {})
                    yield Scene(f"{path.stem}.{name}[{k}]", system, options["until"], start, given)
            calls.clear()


def main(kind: str, count: int) -> None:
    """All ways of many scenes; print what does not agree, and count."""
    warnings.simplefilter("error")
    total: Counter = Counter()
    for k, scene in enumerate(drives(count) if kind == "drives" else pages()):
        if not any("(" not in name for name in scene.system.state_names):
            continue
        try:
            ways = Ways(scene)
        except LumpedError as refusal:
            print(f"{scene.name}: {type(refusal).__name__}: {str(refusal)[:200]}")
            continue
        ways.methods()
        ways.derivatives(some_parameters(scene.system, np.random.default_rng(k)))
        if k % 4 == 0:
            with tempfile.TemporaryDirectory() as folder:
                ways.unit(Path(folder))
        for way, verdict in ways.found.items():
            total[verdict.split()[0]] += 1
            if not verdict.startswith("agrees") and "method='exact' is for" not in verdict:
                print(f"{scene.name}: {way}: {verdict[:300]}", flush=True)
    print(dict(total))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 0)
