"""What flows into the ports of a component is stored or dissipated, for the whole library.

A new component is covered as it is. It needs an entry in one of the modules `powers_of_...` only if
it stores, dissipates or supplies energy. Components of straight-line motion with a rotational twin
have its law (see test_twins) and are left out.
"""

from collections.abc import Iterator

import numpy as np
import powers_of_converters
import powers_of_elements
import powers_of_engines
import powers_of_hysteresis
import powers_of_machines
import powers_of_mechanisms
import powers_of_sources
import pytest
from library_rigs import FIELDS, LIBRARY, POSITIVE, SENSIBLE, declared, every, kinds, rig, values
from power_terms import Energy, Motion, Power
from powers_of_sources import PRESCRIBED
from translation_twins import TWINS

import lumped as lp
from lumped.components import Cylinder, Heated, InductionMotor
from lumped.components.electric import air_gap, drives
from lumped.language.declared import has_parts
from lumped.language.switch import Hold

STATES = 12
TOLERANCE = 1e-12
ROUNDING = 1e-14  # W, where contacts are open and all powers are zero

STORED: dict[type[lp.Component], Energy] = (
    powers_of_elements.STORED
    | powers_of_converters.STORED
    | powers_of_hysteresis.STORED
    | powers_of_engines.STORED
    | powers_of_mechanisms.STORED
    | powers_of_machines.STORED
)
DISSIPATED: dict[type[lp.Component], Power] = (
    powers_of_elements.DISSIPATED
    | powers_of_converters.DISSIPATED
    | powers_of_hysteresis.DISSIPATED
    | powers_of_engines.DISSIPATED
    | powers_of_mechanisms.DISSIPATED
    | powers_of_machines.DISSIPATED
)
SUPPLIED: dict[type[lp.Component], Power] = (
    powers_of_sources.SUPPLIED
    | powers_of_engines.SUPPLIED
    | powers_of_mechanisms.SUPPLIED
    | powers_of_machines.SUPPLIED
)


NET = {air_gap.AirGap, drives.FieldOrientedMotor, drives.MappedMotor, InductionMotor, Cylinder}
"""What is fed by no port, so that the supply of the tables is less the loss."""


def rubbing(at: Motion) -> float:
    return sum(at.held)


def rate(energy: Energy, at: Motion) -> float:
    """Time derivative of an energy along the motion, by a complex step: exact to rounding."""
    h = 1e-30
    q = {port: at.q[port] + 1j * h * at.v[port] for port in at.q}
    v = {port: at.v[port] + 1j * h * at.a[port] for port in at.v}
    x = {name: at.x[name] + 1j * h * at.rates[name] for name in at.x}
    return energy(Motion(at.p, q, v, at.a, x, at.rates, flow=at.flow)).imag / h


def nothing(at: Motion) -> float:
    return 0.0


def holds(cls: type[lp.Component]) -> list[tuple[str, str]]:
    """Names of the reactions of what sticks and slides, and of their speeds."""
    items = cls(**FIELDS.get(cls, {})).equations()
    found = [item for item in items if isinstance(item, Hold)]
    return [(f"part.{h.reaction.name}", f"part.{h.speed.name}") for h in found]


def motions(cls: type[lp.Component]) -> Iterator[tuple[Motion, np.ndarray, float | None]]:
    """Random parameters, bodies, loads and states of the rig, power into each port, told loss.

    What sticks and slides stands still in every third state.
    """
    rng = np.random.default_rng(20)
    ports, joined = declared(cls, lp.Port), kinds(cls)
    positions = [f"part.{name}.{port.potential_name}" for name, port in ports.items()]
    speeds = [f'bodies["{name}"].{kind.speed}' for name, kind in joined.items()]
    flows = [f"part.{name}.{port.flow_name}" for name, port in ports.items()]
    system = lp.assemble(rig(cls, rng), keep=positions)
    held = [] if has_parts(cls) else holds(cls)
    told = system.model.part.loss()
    losses = [] if told is None or cls in NET else [told]
    sizes = np.cumsum([len(ports)] * 3 + [len(held)] * 2)
    read = system.function(
        [*positions, *speeds, *flows, *(r for r, _ in held), *(s for _, s in held), *losses]
    )
    for number in range(STATES):
        own = values(cls, rng)
        mass, load = rng.uniform(0.5, 2.0, len(ports)), rng.uniform(-2.0, 2.0, len(ports))
        changed = {f"part.{name}": value for name, value in own.items()}
        for i, (name, kind) in enumerate(joined.items()):
            changed[f'bodies["{name}"].{kind.mass}'] = mass[i]
            changed[f'loads["{name}"].{kind.effort}'] = load[i]
        start = {name: rng.uniform(-2.0, 2.0) for name in system.state_names}
        start |= {name: abs(value) for name, value in start.items() if name.endswith(".gap")}
        if number % 3 == 0:
            start |= {speed: 0.0 for _, speed in held if speed in start}
        point = lp.start_point(system, parameters=changed, start=start)
        found = np.asarray(read(point.x, point.theta, point.time, point.settings)).ravel()
        q, v, flow, reaction, sliding, loss = np.split(found, sizes)
        a = (load - flow) / mass
        rates = np.asarray(system.rhs(point.x, point.theta, point.time, point.settings)).ravel()
        inside = {
            name.removeprefix("part."): i
            for i, name in enumerate(system.state_names)
            if name.startswith("part.")
        }
        x, der_x = ({name: values[i] for name, i in inside.items()} for values in (point.x, rates))
        qva = (dict(zip(ports, y, strict=True)) for y in (q, v, a))
        warm = [isinstance(port, lp.HeatPort) for port in ports.values()]
        held_power = tuple(reaction * sliding)
        motion = Motion(own, *qva, x, der_x, held_power, dict(zip(ports, flow, strict=True)))
        yield motion, np.where(warm, flow, flow * v), *(loss if losses else (None,))


@every(
    [
        cls
        for cls in LIBRARY
        if declared(cls, lp.Port) and cls not in PRESCRIBED and cls not in TWINS
    ]
)
def test_power_into_its_ports_is_stored_or_dissipated(cls: type[lp.Component]) -> None:
    worst = 0.0
    for at, power, loss in motions(cls):
        received = power.sum()
        stored = rate(STORED.get(cls, nothing), at)
        dissipated = DISSIPATED.get(cls, rubbing)(at)
        supplied = SUPPLIED.get(cls, nothing)(at)
        expected = stored + dissipated - supplied
        scale = np.abs(power).sum() + abs(stored) + abs(dissipated) + abs(supplied)
        error = abs(received - expected)
        assert error <= TOLERANCE * scale + ROUNDING
        assert received - stored + supplied >= -TOLERANCE * scale - ROUNDING
        assert min(at.held, default=0.0) >= 0
        assert loss is None or abs(loss - dissipated) <= TOLERANCE * scale + ROUNDING
        worst = max(worst, error / scale if scale else 0.0)
    print(f"{cls.__name__}: power balance, largest relative error {worst:.1e}")


@every([cls for cls in LIBRARY if cls.loss is not lp.Component.loss and not has_parts(cls)])
def test_a_heated_component_gives_its_loss_to_its_thermal_port(
    cls: type[lp.Component], monkeypatch: pytest.MonkeyPatch
) -> None:
    hot = type(cls.__name__, (Heated, cls), {})
    for table in (FIELDS, SENSIBLE, POSITIVE):
        monkeypatch.setitem(table, hot, table.get(cls, {}))
    place = list(declared(hot, lp.Port)).index("heat")
    for _, power, loss in motions(hot):
        assert loss is not None
        assert power[place] == pytest.approx(-loss, rel=TOLERANCE, abs=ROUNDING)
