"""The C files made for one model: sizes, tables and functions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from lumped.code.emit_c import c_text, declaration
from lumped.code.operations import OWN, Operations, operations_of
from lumped.code.to_c import as_c, header
from lumped.compiler.switching import Switching
from lumped.compiler.system import System
from lumped.exchange.c_memory import Memory
from lumped.exchange.interface import Interface, Shown
from lumped.flattening import hold_modes
from lumped.kernel import plant, run
from lumped.kernel.instants.holds import TOUCHING
from lumped.kernel.instants.linkages import close
from lumped.kernel.instants.positions import begin, calm_positions, find_positions
from lumped.kernel.instants.yielding import watch_redundancy
from lumped.kernel.loop import loop, must_jump
from lumped.kernel.many_runs.variants import note_collisions, take
from lumped.kernel.methods.pivots import pattern_of
from lumped.kernel.observe import begin_watch
from lumped.kernel.run import Pattern
from lumped.kernel.steps import is_unfit
from lumped.many_runs.watched import Watched
from lumped.timeloop.clocks import clocks
from lumped.timeloop.guards import followers
from lumped.timeloop.levers import MOST_LEVERAGE, levers
from lumped.timeloop.nominal_sizes import nominals
from lumped.timeloop.plants.parts import find_enclosed_sizes, parts_of, select_enclosed

_ENTRIES: dict[str, Any] = {
    "kernel_loop": loop,
    "kernel_begin": begin,
    "kernel_calm_positions": calm_positions,
    "kernel_find_positions": find_positions,
    "kernel_close": close,
    "kernel_watch_redundancy": watch_redundancy,
    "kernel_must_jump": must_jump,
    "kernel_is_unfit": is_unfit,
    "kernel_begin_watch": begin_watch,
    "kernel_note_collisions": note_collisions,
    "kernel_take": take,
    **OWN,
}
"""What of the time loop the interface and the functions of a model call."""

_LIMITS = ("MOST_JUMP", "STORM_WITHIN")
"""Limits of the loop that words of faults name."""
_STATUS = (
    *("GOES_ON", "DONE", "FULL", "UNFIT", "NOT_FINITE", "GIVEN_UP", "TOO_MANY", "STORM"),
    *("NEEDS_MATRIX", "NO_FIT", "NOT_CLOSED", "JUMPS", "INSIDE", "SET_TWICE"),
    *("BEGIN_SEGMENT", "RESTART", "STORM_SIZE"),
)
_POSITIONS = ("STUCK", "FORWARD", "BACKWARD", "CONDITION", "SLIDE")


def model_files(
    interface: Interface,
    token: str,
    rtol: float,
    method: str,
    *,
    watched: Watched | None = None,
    beside: Mapping[str, ca.Function] | None = None,
) -> tuple[dict[str, str], int]:
    """Text of ``loop.c``, ``loop.h``, ``model.c`` and ``model.h``, and the number of operations.

    Parameters
    ----------
    method : {"auto", "explicit", "implicit"}
        Of co-simulation.
    watched : Watched, optional
        Functionals that the loop collects.
    beside : mapping of str to Function, optional
        Further functions that the interface calls.
    """
    system = interface.system
    functions, lengths, fields = parts_of(system, MOST_LEVERAGE)
    lengths = {**lengths, "nonzeros": 0, "entries": 0}
    values: dict[str, dict[str, int | np.ndarray]] = {"plant": fields}
    if method != "explicit" and lengths["states"]:
        functions["jacobian"] = operations_of(system.jacobian, full=False)
        rows, columns = (np.array(v) for v in system.jacobian.sparsity_out(0).get_triplet())
        pattern = pattern_of(rows.astype(int), columns.astype(int), lengths["states"])
        values["pattern"] = {name: getattr(pattern, name) for name in Pattern.fields}
        lengths |= {"nonzeros": pattern.nonzeros, "entries": pattern.entries}
    timed = [m for clock in clocks(system) for m in clock.condition.modes]
    lengths["timed"] = len(timed)
    values["run"] = {"timed": len(timed), "timed_setting": np.array(timed, dtype=np.int64)}
    watch = None if watched is None else watched.record()
    if watched is not None:
        functions |= watched.functions
        values["run"]["watches"] = 1
    enclosed = select_enclosed(functions)
    lengths |= find_enclosed_sizes(enclosed)
    values["enclosed_margins"] = {"results": lengths["margins"]}
    values["enclosed_rates"] = {"results": lengths["states"], "is_still": 1}
    memory = Memory(lengths, values, list(functions), enclosed, watch)
    functions |= _own_functions(interface)
    functions |= {name: operations_of(f) for name, f in (beside or {}).items()}
    # the interface calls these directly
    if system.switching:
        functions["margin_rate"] = operations_of(system.margin_rates)
    for name in ("rates", "look", "margin", "margin_rate", "following"):
        if name not in functions:
            functions[name] = _operations(name, system, [])
    sizes = _sizes(interface, len(timed)) | {
        "MAY_CHOOSE": int(method == "auto" and "jacobian" in functions),
        "IS_IMPLICIT": int(method == "implicit" and "jacobian" in functions),
    }
    tables = _tables(interface, token)
    head = [
        "/* A model made by lumped: sizes, tables, functions of states x, parameters p, time t,",
        "   settings m (positions of conditions and holds, then implicit quantities). */",
        '#ifndef MODEL_H\n#define MODEL_H\n\n#include <stdbool.h>\n#include "loop.h"\n',
        "enum {\n" + ",\n".join(f"    {name} = {value}" for name, value in sizes.items()) + "\n};",
        f"#define DEFAULT_TOLERANCE {rtol!r}\n",
        memory.declaration,
        *(f"extern {text};" for text, _ in tables),
        "",
        *(declaration(f"model_{name}") for name in functions),
        "const char *parameter_fault(int parameter, double value);",
        "const char *bound_fault(const double *p);",
        "\n#endif\n",
    ]
    body = [
        '#include <math.h>\n#include <stddef.h>\n#include "model.h"\n',
        *(f"{text} = {value};" for text, value in tables),
        "",
        _faults(interface.variables),
        *(c_text(operations, f"model_{name}") for name, operations in functions.items()),
        _write_bound_faults(system),
        memory.definition,
    ]
    files = {"model.h": "\n".join(head), "model.c": "\n".join(body), **_loop_files()}
    return files, sum(len(operations.table) for operations in functions.values())


@cache
def _loop_files() -> dict[str, str]:
    """The time loop; the same for all models."""
    told = (
        "/* The time loop of lumped, translated from lumped/kernel; it is the same in all units. */"
    )
    names = [*_STATUS, *_POSITIONS]
    found = {**vars(hold_modes), **vars(run), **vars(plant)}
    listed = ",\n".join(f"    {name} = {found[name]}" for name in names)
    gap = f"#define CONTACT {TOUCHING!r} /* of bodies that touch */"
    limits = "\n".join(f"#define {name} {found[name]!r}" for name in _LIMITS)
    declared = f"{told}\n#ifndef LOOP_H\n#define LOOP_H\n\n{header(_ENTRIES)}\n"
    return {
        "loop.c": f"{told}\n{as_c(_ENTRIES)}",
        "loop.h": f"{declared}\n{gap}\n{limits}\nenum {{\n{listed}\n}};\n\n#endif\n",
    }


def _operations(name: str, system: System, results: Sequence[ca.SX]) -> Operations:
    """A function with the inputs of a system."""
    return operations_of(ca.Function(name, system.inputs, [ca.densify(r) for r in results]))


def _own_functions(interface: Interface) -> dict[str, Operations]:
    """What the interface needs beside the functions of the plant, one result after the other."""
    system, form = interface.system, interface.form
    _, p, time, m = system.inputs
    v = system.structure.values
    jacobian = ca.jacobian(form.miss, v.states)
    jacobian = jacobian[form.rows, form.columns] if form.rows else ca.SX(0, 1)
    places = ca.vertcat(ca.SX(0, 1), *(c.condition.argument for c in clocks(system)))
    speeds = ca.densify(ca.jacobian(places, v.time))
    targets = ca.Function(
        "targets", [v.states, p, time, m], [ca.densify(form.miss), ca.vec(ca.densify(jacobian))]
    )
    own = {
        "outputs": [interface.output_expressions],
        "clocks": [places, speeds],
        "bound": [_find_bound(system)],
        "start": [form.states],
    }
    found = {name: _operations(name, system, results) for name, results in own.items()}
    return found | {"targets": operations_of(targets)}


def _sizes(interface: Interface, timed: int) -> dict[str, int]:
    system, form, s = interface.system, interface.form, interface.system.switching
    return {
        "N_STATES": len(system.state_names),
        "N_ALL_STATES": len(system.structure.reduced.states),
        "N_PARAMETERS": system.inputs[1].numel(),
        "N_MODES": system.structure.mode_count,
        "N_IMPLICIT": len(system.structure.implicit),
        "N_SETTINGS": system.inputs[3].numel(),
        "N_OUTPUTS": len(interface.outputs),
        "N_MARGINS": interface.margins,
        "N_CONDITIONS": len(s.relation_modes),
        "N_CLOCKS": len(s.timed),
        "N_TIMED": timed,
        "CLOCK_LEVELS": _levels(s.needs),
        "N_HOLDS": len(s.first_modes),
        "N_TARGETS": form.miss.numel(),
        "N_SOLVED": len(form.rows),
        "N_FOLLOWERS": len(followers(system)[0]) if s.timed else 0,
        "N_LEVERS": len(levers(system, MOST_LEVERAGE)[0]),
        "HAS_SWITCHING": int(bool(s)),
    }


def _tables(interface: Interface, token: str) -> list[tuple[str, str]]:
    """Declarations and values; one entry more than needed, as C has no empty arrays."""
    system, form, s = interface.system, interface.form, interface.system.switching
    parameters = [v for v in interface.variables if v.role in ("parameter", "input")]
    name = system.structure.node_name
    leads = [
        f"{name(follower)} should lead instead of {name(leader)}"
        for follower, leader in levers(system, MOST_LEVERAGE)[0]
    ]
    implicit = ", ".join(name(n) for n in system.structure.implicit[:6])
    sides = [c.relation.sides for c in s.conditions]
    texts: list[str] = []
    for k, c in enumerate(s.conditions):
        both = ("", "") if c.pieces else (s.relation_text(k, mode)[1] for mode in (0.0, 1.0))
        texts += both
    return [
        ("const char *const model_name", _quote(system.name)),
        ("const char *const model_token", _quote(token)),
        ("const char *const implicit_names", _quote(implicit)),
        _texts("parameter_names", [v.name for v in parameters]),
        _array("double", "parameter_starts", system.structure.parameters.defaults.tolist()),
        _array("bool", "parameter_tunable", [v.tunable for v in parameters]),
        _texts("state_names", system.state_names),
        _array("double", "state_nominal", nominals(system).tolist()),
        _array("int", "state_place", system.structure.in_use),
        _array("bool", "state_settable", interface.settable_states),
        _array("double", "implicit_starts", form.guesses.tolist()),
        _texts("change_names", [*(c.name for c in s.conditions), *s.names]),
        _texts("condition_sides", [str(left) for left, _ in sides]),
        _texts("condition_texts", texts),
        _texts("jump_texts", [f"{jump.name} when {jump.condition}" for jump in s.jumps]),
        *_clocks(s),
        _texts("gap_units", s.gap_units),
        _array("int", "solved_row", form.rows),
        _array("int", "solved_state", form.columns),
        _texts("follower_names", followers(system)[0] if s.timed else []),
        _texts("lever_names", leads),
    ]


def _levels(needs: list[list[int]]) -> int:
    """How many rounds it takes until each function of time knows those that it needs."""
    levels: list[int] = []
    for need in needs:
        levels.append(1 + max((levels[i] for i in need), default=0))
    return max(levels, default=0)


def _clocks(s: Switching) -> list[tuple[str, str]]:
    """Tables of the functions of time."""
    tables = [c.pieces for c in s.timed]
    counts = [p.count if p else 0 for p in tables]
    widths = [p.width if p else 1 for p in tables]
    firsts = np.cumsum([0, *(n * w for n, w in zip(counts, widths, strict=True))])[:-1]
    rows = [value for p in tables if p for value in p.table.ravel().tolist()]
    return [
        _array("int", "clock_setting", [c.mode for c in s.timed]),
        _array("bool", "clock_strict", [c.relation.strict for c in s.timed]),
        _array("int", "clock_count", counts),
        _array("int", "clock_first", firsts.tolist()),
        _array("int", "clock_width", widths),
        _array("double", "clock_period", [p.period or 0.0 if p else 0.0 for p in tables]),
        _array("double", "clock_rows", rows),
    ]


def _array(kind: str, name: str, values: Iterable[object]) -> tuple[str, str]:
    listed = [_write_value(v) for v in values]
    return f"const {kind} {name}[{len(listed) + 1}]", "{" + ", ".join([*listed, "0"]) + "}"


def _texts(name: str, values: Sequence[str]) -> tuple[str, str]:
    listed = ", ".join([*(_quote(v) for v in values), "NULL"])
    return f"const char *const {name}[{len(values) + 1}]", "{" + listed + "}"


def _write_value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not np.isfinite(value):
        return "NAN" if np.isnan(value) else "-INFINITY" if value < 0 else "INFINITY"
    return value if isinstance(value, str) else repr(value)


def _quote(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + escaped.replace("?", "\\?") + '"'  # ??/ would be a backslash to C


def _faults(variables: Sequence[Shown]) -> str:
    """A C function that says why the value of a parameter is out of range."""
    lines = [
        "const char *parameter_fault(int parameter, double value)",
        "{",
        '    if (!(value - value == 0)) return "must be a finite number";',
        "    switch (parameter) {",
    ]
    parameters = [v for v in variables if v.role in ("parameter", "input")]
    for i, shown in enumerate(parameters):
        tests = [f'        if (value {b.sign} {b.limit!r}) return "{b}";' for b in shown.bounds]
        if tests:
            lines += [f"    case {i}:", *tests, "        break;"]
    return "\n".join([*lines, "    default: break;", "    }", "    return NULL;", "}\n"])


def _find_bound(system: System) -> ca.SX:
    """Parameters that follow from others, and how far those with such a limit are from it."""
    p = system.structure.parameters
    over = [p.values[high] - least for high, least, *_ in p.ordered]
    return ca.vertcat(p.values, *over)


def _write_bound_faults(system: System) -> str:
    """A C function that says which parameter is out of a range that depends on others."""
    p = system.structure.parameters
    tests = []
    for i, declared in enumerate(p.declared):
        for b in declared.bounds if i not in p.free else ():
            tests.append((f"values[{i}] {b.sign} {b.limit!r}", f"{p.names[i]} {b}"))
    for k, (high, _, name, (_, meaning)) in enumerate(p.ordered):
        lower = p.declared[high].lower
        fault = f"{p.names[high]} must be {lower.words} {name}{meaning}"
        tests.append((f"values[{len(p.declared) + k}] {lower.sign} 0", fault))
    lines = [f"    if ({test}) return {_quote(text)};" for test, text in tests]
    size = len(p.declared) + len(p.ordered) + 1
    head = ["const char *bound_fault(const double *p)", "{"]
    if lines:
        head += [f"    double values[{size}];", "    model_bound(NULL, p, 0.0, NULL, values);"]
    else:
        head.append("    (void)p;")
    return "\n".join([*head, *lines, "    return NULL;", "}\n"])
