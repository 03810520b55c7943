"""The C files made for one model: sizes, tables and functions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.switching import Switching
from lumped.compiler.system import System
from lumped.exchange.c_functions import CFunction, c_text
from lumped.exchange.interface import Interface, Shown, limits_of
from lumped.timeloop.guards import followers, levers
from lumped.timeloop.instants import clocks
from lumped.timeloop.run import nominals

__all__ = ["coefficients", "model_files"]

_HERE = ("x", "p", "t", "m")
_OUTSIDE = {
    "min": ("<", "be at least"),
    "above": ("<=", "be greater than"),
    "max": (">", "be at most"),
    "below": (">=", "be less than"),
    "nonzero": ("==", "not be zero"),
}


def model_files(interface: Interface, token: str, rtol: float) -> tuple[dict[str, str], int]:
    """Text of ``model.h`` and ``model.c``, and the number of operations of the functions."""
    functions = _functions(interface)
    sizes, tables = _sizes(interface, rtol), _tables(interface, token)
    header = [
        "/* A model made by lumped: sizes, tables and functions of states x, parameters p, time t,",
        "   modes and implicit quantities m. */",
        "#ifndef MODEL_H\n#define MODEL_H\n\n#include <stdbool.h>\n",
        "enum {\n" + ",\n".join(f"    {name} = {value}" for name, value in sizes.items()) + "\n};",
        "enum { RELATION, UPPER, LOWER, SLIDE }; /* kinds of margins */\n",
        f"#define DEFAULT_TOLERANCE {rtol!r}\n",
        *(f"extern {text};" for text, _ in tables),
        "",
        *(f"{f.declaration};" for f in functions),
        "const char *parameter_fault(int parameter, double value);",
        "const char *bound_fault(const double *p);",
        "\n#endif\n",
    ]
    body = [
        '#include <stddef.h>\n#include "model.h"\n',
        *(f"{text} = {value};" for text, value in tables),
        "",
        _faults(interface.variables),
        c_text(functions),
        _bound_faults(interface.system),
    ]
    operations = sum(f.function.n_instructions() for f in functions)
    return {"model.h": "\n".join(header), "model.c": "\n".join(body)}, operations


def _functions(interface: Interface) -> list[CFunction]:
    system, form = interface.system, interface.form
    here = system._inputs
    p, all_states = here[1], system._values.states

    def usual(name: str, results: Sequence[ca.SX], outputs: Sequence[str]) -> CFunction:
        return CFunction(name, here, results, _HERE, outputs)

    jacobian = ca.jacobian(form.miss, all_states)
    if form.rows:
        jacobian = jacobian[form.rows, form.columns]
    empty = ca.SX(0, 1)
    margins = system.margins(*here) if system.switching else (empty, empty)
    slopes = system.margin_rates(*here) if system.switching else empty
    v, all_clocks = system._values, clocks(system)
    places = ca.vertcat(empty, *(c.condition.argument for c in all_clocks))
    speeds = ca.densify(ca.jacobian(places, v.time))
    return [
        usual("model_rates", [system.rates], ["rates"]),
        usual("model_look", [system.look(*here)], ["look"]),
        usual("model_margins", list(margins), ["margins", "tolerances"]),
        usual("model_margin_rates", [slopes], ["slopes"]),
        usual("model_outputs", [interface.output_expressions], ["outputs"]),
        usual("model_closure", list(system.closure(*here)), ["found", "step"]),
        usual("model_followers", [followers(system)[1](*here)], ["values"]),
        usual("model_levers", [levers(system)[1](*here)], ["ratios"]),
        CFunction(
            "model_clocks",
            [v.time, p, here[3]],
            [places, speeds],
            ["t", "p", "m"],
            ["places", "slopes"],
        ),
        CFunction("model_bound", [p], [_bound(interface.system)], ["p"], ["values"]),
        CFunction("model_start", [p], [form.states], ["p"], ["states"]),
        CFunction(
            "model_targets",
            [all_states, *here[1:]],
            [form.miss, jacobian],
            ["all", "p", "t", "m"],
            ["miss", "jacobian"],
        ),
    ]


def _sizes(interface: Interface, rtol: float) -> dict[str, int]:
    system, form, s = interface.system, interface.form, interface.system.switching
    return {
        "N_STATES": len(system.states),
        "N_ALL_STATES": len(system._reduced.states),
        "N_PARAMETERS": system._inputs[1].numel(),
        "N_MODES": system._flat.mode_count,
        "N_GUESSES": len(system._values.implicit),
        "N_OUTPUTS": len(interface.outputs),
        "N_MARGINS": interface.margins,
        "N_RELATIONS": len(s.relation_modes),
        "N_CLOCKS": len(s.timed),
        "CLOCK_LEVELS": _levels(s.needs),
        "N_HOLDS": len(s.first_modes),
        "N_JUMPS": len(s.jumps),
        "N_JUMP_VALUES": s.values.numel(),
        "N_TARGETS": form.miss.numel(),
        "N_SOLVED": len(form.rows),
        "N_FOLLOWERS": len(followers(system)[0]),
        "N_LEVERS": len(levers(system)[0]),
        "HAS_SWITCHING": int(bool(s)),
    }


def _tables(interface: Interface, token: str) -> list[tuple[str, str]]:
    """Declarations and values; one entry more than needed, as C has no empty arrays."""
    system, form, s = interface.system, interface.form, interface.system.switching
    place = {node: i for i, node in enumerate(system.states)}
    parameters = [v for v in interface.variables if v.role in ("parameter", "input")]
    uses = _grouped(*system.speed_uses, len(s.speeds)) if s.speeds else ([0], [])
    jumped = [place.get(node, -1) for jump in s.jumps for node in jump.nodes]
    signs = [sign for jump in s.jumps for sign in jump.signs]
    begins = np.cumsum([0, *(len(jump.nodes) for jump in s.jumps)]).tolist()
    leads = [
        f"{system._node_name(follower)} should lead instead of {system._node_name(leader)}"
        for follower, leader in levers(system)[0]
    ]
    kinds = [kind.upper() for kind, _ in s.rows] if interface.margins else []
    numbers = [number for _, number in s.rows] if interface.margins else []
    return [
        ("const char *const model_name", _quoted(system.name)),
        ("const char *const model_token", _quoted(token)),
        _texts("parameter_names", [v.name for v in parameters]),
        _array("double", "parameter_starts", system._flat.parameters.defaults.tolist()),
        _array("bool", "parameter_tunable", [v.tunable for v in parameters]),
        _array("double", "state_nominal", nominals(system).tolist()),
        _array("int", "state_place", system._in_use),
        _array("bool", "state_settable", interface.settable_states),
        _array("double", "guess_starts", form.guesses.tolist()),
        *_conditions(s),
        _texts("hold_names", s.names),
        _array("int", "hold_modes", s.first_modes.tolist()),
        _array("int", "hold_engaged", s.engaged.tolist()),
        _array("int", "hold_state", [place.get(node, -1) for node in s.speeds]),
        _array("bool", "hold_has_upper", s.has_upper.tolist()),
        _array("bool", "hold_has_lower", s.has_lower.tolist()),
        _array("bool", "hold_has_forward", s.has_forward.tolist()),
        _array("bool", "hold_has_backward", s.has_backward.tolist()),
        _array("bool", "hold_has_gap", s.has_gap.tolist()),
        _array("int", "hold_uses_begin", uses[0]),
        _array("int", "hold_uses", uses[1]),
        _array("int", "margin_kind", kinds),
        _array("int", "margin_number", numbers),
        _array("int", "jump_mode", [jump.mode for jump in s.jumps]),
        _array("int", "jump_begin", begins),
        _array("int", "jump_state", jumped),
        _array("double", "jump_sign", signs),
        _array("int", "solved_row", form.rows),
        _array("int", "solved_state", form.columns),
        _texts("follower_names", followers(system)[0]),
        _texts("lever_names", leads),
    ]


def _levels(needs: list[list[int]]) -> int:
    """How many rounds it takes until each function of time knows those that it needs."""
    levels: list[int] = []
    for need in needs:
        levels.append(1 + max((levels[i] for i in need), default=0))
    return max(levels, default=0)


def _conditions(s: Switching) -> list[tuple[str, str]]:
    """Tables of the conditions and of the functions of time, and the rows of both."""
    found: list[tuple[str, str]] = []
    rows: list[float] = []
    for name, conditions in (("relation", s.conditions), ("clock", s.timed)):
        firsts, tables = [], [c.pieces for c in conditions]
        for pieces in tables:
            firsts.append(len(rows))
            rows += [] if pieces is None else pieces.table.ravel().tolist()
        found += [
            _array("int", f"{name}_mode", [c.mode for c in conditions]),
            _array("bool", f"{name}_strict", [c.relation.strict for c in conditions]),
            _array("int", f"{name}_count", [p.count if p else 0 for p in tables]),
            _array("int", f"{name}_first", firsts),
            _array("int", f"{name}_width", [p.width if p else 1 for p in tables]),
        ]
    periods = [c.pieces.period or 0.0 if c.pieces else 0.0 for c in s.timed]
    return [*found, _array("double", "clock_period", periods), _array("double", "piece_rows", rows)]


def _grouped(rows: np.ndarray, columns: np.ndarray, count: int) -> tuple[list[int], list[int]]:
    """Columns of each row, one row after the other, and where each begins."""
    order = np.argsort(rows, kind="stable")
    begins = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=count))])
    return begins.tolist(), columns[order].tolist()


def _array(kind: str, name: str, values: Iterable[object]) -> tuple[str, str]:
    listed = [_written(v) for v in values]
    return f"const {kind} {name}[{len(listed) + 1}]", "{" + ", ".join([*listed, "0"]) + "}"


def _texts(name: str, values: Sequence[str]) -> tuple[str, str]:
    listed = ", ".join([*(_quoted(v) for v in values), "NULL"])
    return f"const char *const {name}[{len(values) + 1}]", "{" + listed + "}"


def _written(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not np.isfinite(value):
        return "NAN" if np.isnan(value) else "-INFINITY" if value < 0 else "INFINITY"
    return value if isinstance(value, str) else repr(value)


def _quoted(text: str) -> str:
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
        tests = [
            f'        if (value {_OUTSIDE[key][0]} {limit!r}) return "must {_OUTSIDE[key][1]}'
            f'{"" if key == "nonzero" else f" {limit:g}"}";'
            for key, limit in shown.limits.items()
        ]
        if tests:
            lines += [f"    case {i}:", *tests, "        break;"]
    return "\n".join([*lines, "    default: break;", "    }", "    return NULL;", "}\n"])


def _bound(system: System) -> ca.SX:
    """Parameters that follow from others, and how far those with such a limit are from it."""
    p = system._flat.parameters
    over = [p.values[high] - least for high, least, *_ in p.ordered]
    return ca.vertcat(p.values, *over)


def _bound_faults(system: System) -> str:
    """A C function that says which parameter is out of a range that depends on others."""
    p = system._flat.parameters
    tests = []
    for i, declared in enumerate(p.declared):
        for key, limit in limits_of(declared).items() if i not in p.free else ():
            sign, text = _OUTSIDE[key]
            bound = "" if key == "nonzero" else f" {limit:g}"
            tests.append((f"values[{i}] {sign} {limit!r}", f"{p.names[i]} must {text}{bound}"))
    for k, (high, _, name, rest) in enumerate(p.ordered):
        sign, text = _OUTSIDE["above" if p.declared[high].strict else "min"]
        fault = f"{p.names[high]} must {text} {name}, {rest}"
        tests.append((f"values[{len(p.declared) + k}] {sign} 0", fault))
    lines = [f"    if ({test}) return {_quoted(text)};" for test, text in tests]
    size = len(p.declared) + len(p.ordered) + 1
    head = ["const char *bound_fault(const double *p)", "{"]
    if lines:
        head += [f"    double values[{size}];", "    model_bound(p, values);"]
    else:
        head.append("    (void)p;")
    return "\n".join([*head, *lines, "    return NULL;", "}\n"])


def coefficients() -> str:
    """Text of ``dop853.h``: coefficients of the method as SciPy publishes them."""
    d = scipy.integrate.DOP853
    tables = {
        "a": np.asarray(d.A),
        "b": np.asarray(d.B),
        "c": np.asarray(d.C),
        "e3": np.asarray(d.E3),
        "e5": np.asarray(d.E5),
        "ax": np.asarray(d.A_EXTRA),
        "cx": np.asarray(d.C_EXTRA),
        "d": np.asarray(d.D),
    }
    lines = ["/* Coefficients of DOP853 (Hairer, Norsett, Wanner, vol. I, II.5). */"]
    for name, values in tables.items():
        size = "".join(f"[{n}]" for n in values.shape)
        lines.append(f"static const double dop853_{name}{size} = {_nested(values)};")
    return "\n".join(lines) + "\n"


def _nested(values: np.ndarray) -> str:
    if values.ndim == 1:
        return "{" + ", ".join(repr(float(v)) for v in values) + "}"
    return "{\n" + ",\n".join(_nested(row) for row in values) + "}"
