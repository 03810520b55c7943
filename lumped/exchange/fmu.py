"""Export of a model as a functional mock-up unit (FMU)."""

from __future__ import annotations

import re
import time as clock
import uuid
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Literal

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError
from lumped.exchange.c_tables import model_files
from lumped.exchange.derivatives import derivative_functions
from lumped.exchange.fmu_description import build_description, model_description
from lumped.exchange.interface import Interface, refuse_doubles, uneven_clocks
from lumped.exchange.platforms import libraries, platforms_of
from lumped.support.arguments import checked
from lumped.support.whole_files import whole_file
from lumped.timeloop.clocks import Clock
from lumped.timeloop.levers import may_be_unfit

_SOURCES = (
    *("access.c", "clocks.c", "derivatives.c", "events.c", "faults.c", "saved.c", "start.c"),
    "steps.c",
)
_LICENCE = "fmi-licence.txt"
"""Of the headers of the Modelica Association."""
_OWN = {"2.0": ("fmi2.c",), "3.0": ("adjoint.c", "fmi3.c", "fmi3_absent.c")}
_HEADERS = {
    "2.0": ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    "3.0": ("fmi3.h", "fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
"""Those of the Modelica Association, and one of ours."""
_KINDS = ("model_exchange", "co_simulation")


@dataclass(frozen=True)
class ExportedFMU:
    """What was written.

    Attributes
    ----------
    path : Path
        The file.
    version : str
        Of the interface.
    kinds : tuple of str
        "model_exchange", "co_simulation".
    counts : dict of str to int
        Parameters, inputs, outputs, states, event indicators, operations of all functions.
    platforms : tuple of str
        For which it is compiled; none if there was no compiler.
    seconds : float
        Wall time.
    notes : tuple of str
        What the unit cannot do.
    """

    path: Path
    version: str
    kinds: tuple[str, ...]
    counts: dict[str, int]
    platforms: tuple[str, ...]
    seconds: float
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        counts = ", ".join(f"{n} {what}" for what, n in self.counts.items())
        built = " and ".join(self.platforms)
        made = f"compiled for {built}" if built else "sources only"
        head = f"{self.path}: FMI {self.version}, {' and '.join(self.kinds)}, {made}"
        return "\n".join([head, f"{counts}; {self.seconds:.2g} s", *self.notes])


@checked
def export_fmu(
    system: System,
    path: str | Path,
    *,
    version: str = "3.0",
    kind: str | Iterable[str] = _KINDS,
    inputs: Iterable[Name] = (),
    outputs: Iterable[Name] = (),
    start: Changes | None = None,
    rtol: float = 1e-6,
    method: Literal["auto", "explicit", "implicit"] = "auto",
    platforms: Iterable[str] = (),
) -> ExportedFMU:
    """Write a model as an FMU for other tools.

    The file holds C sources: the time loop that `simulate` uses, the functions of the system, and
    the interface. Co-simulation makes the steps of `simulate` and finds the same events; from the
    same start and at the same tolerance its states are the same to the last bit. Steps do not end
    at communication points; where an input is set, integration starts anew. The sources are
    compiled for `platforms`, or else by the compiler of this machine (``CC``, or ``cc``).

    Parameters of the model can be set before the run, and during it if no equation that holds them
    was differentiated. States can be set before the run where they follow from nothing else.

    Parameters
    ----------
    system : System
        From `assemble`.
    path : path
        File to write, ``*.fmu``.
    version : {"3.0", "2.0"}
        Of the Functional Mock-up Interface.
    kind : "model_exchange", "co_simulation" or both
        With the integrator of the importing tool, or with an own one.
    inputs : iterable of names
        Parameters, or inputs given as numbers, that vary from outside. Co-simulation holds them
        from one communication point to the next.
    outputs : iterable of names
        Quantities to give out. States are always visible.
    start : mapping of name to float, optional
        Start values to set or change, as for `simulate`.
    rtol : float
        Relative tolerance of co-simulation where the importing tool gives none.
    method : {"auto", "explicit", "implicit"}
        Of co-simulation: "explicit" is DOP853, "implicit" Rodas5P, "auto" the first until the
        second pays, as "steps" of `simulate`.
    platforms : iterable of str
        For which to compile instead of this machine, by Zig's compiler (``lumped[cross]``):
        "x86_64-linux", "aarch64-linux", and the same with "windows" and "darwin" (macOS); in
        version 2.0 "linux64", "win64" and "darwin64".

    Returns
    -------
    ExportedFMU

    Raises
    ------
    OptionError
        If an option makes no sense, the rate of an input would matter, the version knows no such
        platform, or Zig's compiler is not installed.
    UnknownNameError
        If an input or output does not exist.
    StartError
        If the start values contradict each other.
    ExportError
        If the compiler refuses the sources.
    """
    begin = clock.perf_counter()
    kinds = (kind,) if isinstance(kind, str) else tuple(kind)
    if version not in _OWN:
        raise OptionError(f"export_fmu: version = {version!r}: choose '3.0' or '2.0'.")
    if not kinds or not set(kinds) <= set(_KINDS):
        raise OptionError(f"export_fmu: kind = {kind!r}: choose from {', '.join(_KINDS)}.")
    if not 1e-13 <= rtol < 1:
        raise OptionError(f"export_fmu: rtol = {rtol}: it must lie between 1e-13 and 1.")
    wanted = platforms_of(version, platforms)
    sampled = uneven_clocks(system)
    if sampled:
        system = system.without_foresight()
    interface = Interface(system, inputs, outputs, start or {})
    refuse_doubles(interface)
    identifier = re.sub(r"\W", "_", system.name, flags=re.ASCII)
    derivatives = derivative_functions(interface, reverse=version == "3.0")
    files, operations = model_files(interface, "{token}", rtol, method, beside=derivatives)
    token = "{" + str(uuid.uuid5(uuid.NAMESPACE_OID, version + "".join(files.values()))) + "}"
    files["model.c"] = files["model.c"].replace("{token}", token, 1)
    folder = resources.files("lumped.exchange") / "c"
    own = (*_SOURCES, *_OWN[version])
    for name in (*own, "lumped.h", *_HEADERS[version], _LICENCE):
        files[name] = (folder / name).read_text()
    sources = ("loop.c", "model.c", *own)
    described = model_description(
        interface,
        version=version,
        kinds=[k for k in _KINDS if k in kinds],
        identifier=identifier,
        token=token,
        rtol=rtol,
        sources=sources,
    )
    if version == "3.0":
        files["buildDescription.xml"] = build_description(identifier, sources)
    made = libraries(files, sources, version, wanted)
    path = Path(path)
    with whole_file(path) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", described)
        for name, text in files.items():
            archive.writestr(f"sources/{name}", text)
        for library in made:
            name = f"binaries/{library.folder}/{identifier}{library.suffix}"
            archive.writestr(name, library.content)
    roles = [v.role for v in interface.variables]
    counts = {
        "parameters": roles.count("parameter"),
        "inputs": roles.count("input"),
        "outputs": sum(v.is_output for v in interface.variables),
        "states": roles.count("state"),
        "event indicators": interface.margins,
        "operations": operations,
    }
    notes = _list_notes(system, bool(made), sampled)
    seconds = clock.perf_counter() - begin
    built = tuple(library.folder for library in made)
    return ExportedFMU(path, version, kinds, counts, built, seconds, notes)


def _list_notes(system: System, compiled: bool, sampled: list[Clock]) -> tuple[str, ...]:
    notes = []
    for timed in sampled:
        name, (left, right) = timed.condition.name, timed.condition.relation.sides
        notes.append(
            f"'{left}' against '{right}' in {name} depends on the time alone, but not linearly. A "
            "run here finds all instants of its changes beforehand; the unit watches it from step "
            "to step and misses what changes and changes back within one. Keep its communication "
            "steps shorter than that."
        )
    if not compiled:
        notes.append(
            "No C compiler was found (CC, cc), so the unit holds sources only. Install one and "
            "export again, or use a tool that compiles them."
        )
    if may_be_unfit(system):
        notes.append(
            "A linkage or mechanism leads other motions by a varying ratio: a run that comes to a "
            "dead centre ends with an error, as states cannot change places in an FMU."
        )
    return tuple(notes)
