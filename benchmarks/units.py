"""What does a run of an exported unit cost, compared with `simulate`?

The reversing mill skids while strip enters and leaves, within 0.12 s, and vibrates after that. The
unit is run for co-simulation by an importer in C (``units.c``), which reads all states and two
torques at each communication point; `simulate` records its states at the same times. Times are the
best of several runs in one process; read the ratios.

    python -m benchmarks.units
"""

import ctypes
import tempfile
import zipfile
from importlib import resources
from pathlib import Path

import numpy as np

import lumped as lp
from benchmarks.harness import build_in_c, in_turn, publish
from lumped.models.reversing_mill.scenes import RATED, StripGap

RTOL, ROUNDS = 1e-6, 15
RUNS = ((0.2, 1), (0.2, 200), (0.2, 2000), (20.0, 200), (20.0, 2000), (20.0, 20_000))
"""Seconds of a run, and its communication points."""
DRIVES = {"upper.drive.tau": RATED, "lower.drive.tau": 0.4 * RATED}
OUTPUTS = ["upper.shaft.tau", "gap.tau"]


def main() -> None:
    """Print and write the table."""
    system = lp.assemble(StripGap(enters=0.02, leaves=0.12).with_(DRIVES))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        unit = lp.export_fmu(system, folder / "mill.fmu", kind="co_simulation", outputs=OUTPUTS)
        with zipfile.ZipFile(unit.path) as archive:
            archive.extractall(folder)
        text = (folder / "modelDescription.xml").read_text()
        token = text.split('instantiationToken="')[1].split('"')[0]
        (binary,) = (folder / "binaries").glob("*/*")
        headers = resources.files("lumped.exchange") / "c"
        library = build_in_c("units.c", "-O2", f"-I{headers}")
        assert library, "the importer needs a compiler"
        library.runs.restype = ctypes.c_double
        count = unit.counts["parameters"] + 1
        states = range(count, count + len(system.state_names))
        first = count + 2 * len(system.state_names)
        listed = [*states, *range(first, first + len(OUTPUTS))]
        called = str(binary), token, listed
        rows = [_row(system, library, called, end, points) for end, points in RUNS]
    header = ("run, s", "communication points", "simulate, ms", "unit, ms", "ratio", "deviation")
    publish("units", header, rows)


def _row(
    system: lp.System,
    library: ctypes.CDLL,
    unit: tuple[str, str, list[int]],
    end: float,
    points: int,
) -> tuple[str, ...]:
    path, token, listed = unit
    references, values = (ctypes.c_uint32 * len(listed))(*listed), (ctypes.c_double * len(listed))()
    given = (path.encode(), token.encode(), ctypes.c_double(end), ctypes.c_double(RTOL), points)

    def run_imported() -> float:
        return float(library.runs(*given, 2, references, len(listed), values))

    options = {"until": end, "grid": points, "rtol": RTOL}
    own, unit_runs = in_turn(lambda: lp.simulate(system, **options), run_imported, rounds=ROUNDS)
    run, others = own.result, unit_runs.result
    expected = run.table([*system.state_names, *OUTPUTS])[-1]
    worst = np.max(np.abs(np.array(values) - expected) / (np.abs(expected) + 1e-3))
    numbers = (1e3 * own.seconds, 1e3 * others, others / own.seconds)
    return (f"{end:g}", str(points), *(f"{v:.3g}" for v in numbers), f"{worst:.0e}")


if __name__ == "__main__":
    main()
