"""A run of a model as WebAssembly."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources

from lumped.compiler.system import Changes, System
from lumped.exchange.c_compiler import Linked, compile_sources, zig_compiler
from lumped.exchange.c_tables import model_files
from lumped.exchange.interface import Interface
from lumped.many_runs.watched import Watched
from lumped.timeloop.results.operating_point import OperatingPoint

_SOURCES = ("clocks.c", "events.c", "faults.c", "start.c", "steps.c", "access.c", "live.c")
_MADE = Linked((), ("-mexec-model=reactor", "-s"), ".wasm")


def run_code(
    system: System,
    names: Sequence[str],
    watched: Watched,
    start: Changes | OperatingPoint | None,
    rtol: float,
    grid: int,
) -> bytes:
    """The time loop, the functions of a system and what the page calls.

    Parameters
    ----------
    system : System
    names : sequence of str
        Quantities of which the page gets curves.
    watched : Watched
        Functionals.
    start : mapping of name to float, or OperatingPoint
        Start values, or states.
    rtol : float
        Relative tolerance.
    grid : int
        Intervals of the curves.

    Raises
    ------
    OptionError
        If Zig's compiler is not installed.
    ExportError
        If it refuses the sources.
    """
    compiler = zig_compiler("wasm32-wasi", "live_page")
    interface = Interface(system, (), names, {} if start is None else start)
    files, _ = model_files(interface, "", rtol, "auto", watched=watched)
    folder = resources.files("lumped.exchange") / "c"
    for name in (*_SOURCES, "lumped.h"):
        files[name] = (folder / name).read_text()
    files["shown.h"] = _write_shown(interface, names, watched, grid)
    return compile_sources(files, ("loop.c", "model.c", *_SOURCES), compiler, _MADE)


def _write_shown(interface: Interface, names: Sequence[str], watched: Watched, grid: int) -> str:
    """Sizes of the results, and where the values of the curves are found."""
    states = interface.system.state_names
    places = [
        f"FIRST_STATE + {states.index(name)}"
        if name in states
        else f"FIRST_OUTPUT + {interface.outputs.index(name)}"
        for name in names
    ]
    return (
        f"enum {{ N_SHOWN = {len(names)}, N_TAKEN = {watched.width}, N_ROWS = {grid + 1} }};\n"
        f"static const uint32_t shown_references[] = {{{', '.join(places)}}};\n"
    )
