"""Situation at a point: what is open, sticks, slides or is at a border there, in words."""

from __future__ import annotations

from collections import defaultdict

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.points.borders import at_borders, border_text, is_bent, is_law, sides
from lumped.support.made_once import made_once
from lumped.support.text_table import list_names
from lumped.timeloop.holds import hold_words
from lumped.timeloop.programs import programs_of
from lumped.timeloop.results.operating_point import OperatingPoint

_ORDER = ("open", "closed", "stuck", "sliding", "released", "held")
_STRONGEST = ("closed", "stuck", "sliding", "open", "released")
"""Which of several holds of a component names its situation."""
_SAID = {"forward": "sliding", "backward": "sliding", "free": "released"}


def situation(point: OperatingPoint) -> str:
    """What is open, closed, stuck, sliding or released at a point, such as "; open: lash".

    A linearisation holds as long as that does not change. Open is a contact with a gap, and a
    component whose torque or force does not depend on the states there though it has other pieces
    in which it may. Held are the answers of programs, which stay as they are between samples.
    """
    words = _holds(point) | dict.fromkeys(programs_of(point.system), "held")
    for name in _without_effect(point):
        words.setdefault(name, "open")
    named = defaultdict(list)
    for name, word in words.items():
        named[word].append(name)
    return "".join(f"; {word}: {list_names(named[word])}" for word in _ORDER if named[word])


def one_sided(point: OperatingPoint) -> str:
    """Borders at which a point is and beyond which its linearisation is another; else empty."""
    rows, found = at_borders(point), []
    laws = [row for row in rows if is_law(point, row)]
    for row in rows:
        if row not in laws:
            found.append(row)
            continue
        for chosen in ([row], laws):
            first, second = sides(point, chosen, np.ones(len(chosen)))
            if is_bent(point, first, second):
                found.append(row)
                break
    texts = list(dict.fromkeys(border_text(point, row) for row in found))
    if not texts:
        return ""
    borders = list_names(texts)
    return f"one-sided: exactly at a border of {borders}; beyond it the linearisation differs"


def _holds(point: OperatingPoint) -> dict[str, str]:
    """What each component with holds does, in a word."""
    switching = point.system.switching
    parts = point.settings[switching.first_modes + np.arange(3)[:, None]] > 0.5
    found: dict[str, set[str]] = defaultdict(set)
    for hold, name in enumerate(switching.names):
        words = hold_words(switching, hold)
        stuck, forward, backward = parts[:, hold]
        word = words[0 if stuck else 1 if forward else 2 if backward else 3]
        found[name].add(_SAID.get(word, word))
    return {name: next(w for w in _STRONGEST if w in words) for name, words in found.items()}


def _without_effect(point: OperatingPoint) -> list[str]:
    """Components with conditions whose torques and forces are zero whatever the states."""
    system = point.system
    function, counts = _flows(system)
    if not counts:
        return []
    x, rng = np.zeros(len(system.structure.reduced.states)), np.random.default_rng(5)
    x[system.structure.in_use] = point.x
    beside = (x, *(x + rng.uniform(-1, 1, len(x)) for _ in range(2)))
    found = [np.asarray(function(y, point.theta, point.time, point.settings)) for y in beside]
    idle = (np.hstack(found) == 0).all(axis=1)
    groups = np.split(idle, np.cumsum(list(counts.values()))[:-1])
    return [name for name, group in zip(counts, groups, strict=True) if group.all()]


@made_once
def _flows(system: System) -> tuple[ca.Function, dict[str, int]]:
    """Torques and forces of components with conditions, and how many each has."""
    switching, reduced = system.switching, system.structure.reduced
    count = len(switching.relation_modes)
    named = {switching.relation_text(k, True)[0] for k in range(count)}
    nodes: list[int] = []
    counts: dict[str, int] = {}
    for part in system.structure.tree.instances if named else ():
        name = part.path or system.name
        numbers = [
            reduced.node(part.first_unknown + i)
            for i, q in enumerate(part.layout.quantities)
            if q.kind == "flow"
        ]
        own = [n for n in numbers if n is not None]
        if name in named and own:
            counts[name] = len(own)
            nodes += own
    inputs = [system.structure.values.states, *system.inputs[1:]]
    return ca.Function("flows", inputs, [system.structure.values.of(nodes)]), counts
