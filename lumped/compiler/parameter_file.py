"""Parameters in files that people edit."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, ParameterError
from lumped.support.arguments import checked
from lumped.support.whole_files import write_text


@checked
def write_parameters(
    system: System, path: str | Path, *, parameters: Changes | None = None
) -> Path:
    """Write all parameters of a system with their units, as TOML or JSON.

    Each line reads ``"shaft.c" = "30000.0 N.m/rad"``; numbers are written in full.

    Parameters
    ----------
    system : System
        From `assemble`.
    path : str or Path
        Its ending, .toml or .json, says the format.
    parameters : mapping of name to value, optional
        Those that are changed from the model.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    OptionError
        If the ending is neither.
    """
    path = Path(path)
    write_text(path, parameter_text(system, path.name, parameters))
    return path


def parameter_text(system: System, name: str, parameters: Changes | None) -> str:
    """Content of a file of that name (see `write_parameters`)."""
    is_json = _is_json(name)
    p = system.structure.parameters
    values = zip(p.free, system.theta(parameters).tolist(), strict=True)
    texts = {p.names[i]: f"{value!r} {p.declared[i].unit}" for i, value in values}
    if is_json:
        return json.dumps(texts, indent=2, ensure_ascii=False) + "\n"
    lines = (f"{json.dumps(name)} = {json.dumps(text)}\n" for name, text in texts.items())
    return f"# {system.name}\n" + "".join(lines)


@checked
def read_parameters(system: System, path: str | Path) -> dict[str, float]:
    """Read parameters, to give to an analysis as ``parameters=``.

    A text is a number with a unit, a number is in the unit of the parameter. Tables of a TOML file
    and objects in JSON stand for parts: ``[shaft]`` and ``c = 3e4`` is ``shaft.c``.

    Parameters
    ----------
    system : System
        From `assemble`; names and units are those of its parameters.
    path : str or Path
        Its ending, .toml or .json, says the format; it may hold some of the parameters.

    Returns
    -------
    dict of str to float
        In SI units.

    Raises
    ------
    OptionError
        If the ending is neither, the file is not of that format, or it gives a value twice.
    UnknownNameError
        If a parameter does not exist, or is bound to others.
    UnitError
        If a value has a unit of another dimension.
    ParameterError
        If a value is no number, or out of range.
    """
    _is_json(str(path))  # before the file is looked for
    return parameters_in(system, str(path), Path(path).read_bytes())


def parameters_in(system: System, path: str, held: bytes) -> dict[str, float]:
    """Parameters in the content of a file of that name (see `read_parameters`)."""
    is_json = _is_json(path)
    try:
        text = held.decode()
        found = _parse_json(text) if is_json else tomllib.loads(text)
    except (ValueError, RecursionError) as fault:
        kind = "JSON" if is_json else "TOML"
        raise OptionError(f"{path} is no {kind}: {fault}") from None
    if not isinstance(found, dict | _Pairs):
        raise OptionError(f"{path}: names with values are needed, not {found!r:.60}.")
    changes: dict[str, object] = {}
    for name, value in _flat("", found):
        if name in changes:
            raise OptionError(
                f"{path}: {name} is given twice, {changes[name]!r} and {value!r}. Remove one."
            )
        changes[name] = value
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise ParameterError(f"{path}: {name} = {value!r}: a number or a text is needed.")
    theta = system.theta(changes)  # type: ignore[arg-type]
    return dict(zip(changes, theta[system.places(changes)].tolist(), strict=True))


class _Pairs(list[tuple[str, object]]):
    """An object of JSON with all that it holds, also under one name."""


def _parse_json(text: str) -> object:
    return json.loads(text, object_pairs_hook=_Pairs)


def _flat(path: str, part: object) -> list[tuple[str, object]]:
    if not isinstance(part, dict | _Pairs):
        return [(path, part)]
    prefix = f"{path}." if path else ""
    pairs = part.items() if isinstance(part, dict) else part
    return [pair for name, inner in pairs for pair in _flat(prefix + name, inner)]


def _is_json(path: str) -> bool:
    suffix = Path(path).suffix
    if suffix not in (".toml", ".json"):
        raise OptionError(f"{Path(path).name}: the ending must be .toml or .json.")
    return suffix == ".json"
