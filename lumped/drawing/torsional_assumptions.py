"""What a torsional vibration calculation rests on, and how accurate it is, in words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from lumped.drawing.page_frame import prose, table
from lumped.drawing.torsional_study import Study
from lumped.points.situation import one_sided, situation
from lumped.support.display_units import Shown
from lumped.support.text_table import count_words, list_names, number
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.rotating.small_vibrations import amplitude_laws


def assumptions(study: Study, stated: Iterable[str]) -> str:
    """Assumptions of the user, those of the methods, and a table of residuals."""
    items = [*stated, *_model(study)]
    for caption, response in study.responses.items():
        told = _response(response, study.speed)
        items += [f"{caption}: {text}" if caption else text for text in told]
    items += [
        f"{caption}, how it was integrated: {run.statistics.why}."
        for caption, run in study.runs.items()
    ]
    return f"{prose(items)}\n<h3>Accuracy</h3>\n{_accuracy(study)}"


def _model(study: Study) -> Iterator[str]:
    first, system, speed = study.first, study.system, study.speed
    yield (
        "Maximum, half range and sum are those of all computed orders over a cycle, without the "
        "mean: the largest size, half the difference of the extremes, and the sum of the "
        "amplitudes as if all orders met in phase."
    )
    rotation = first.rotation
    if rotation.turns_matter:
        yield (
            "In the order response, inertias and stiffnesses that vary with the angle of "
            f"{rotation.shaft} count with their means over {_turns(rotation.turns)}, and what "
            "varies excites (first order in the variation)."
        )
    how = (
        "of the equivalent with constant inertias, by means over "
        f"{_turns(rotation.turns)} of {rotation.shaft},"
        if study.modes.mean is not None and rotation.turns_matter
        else "of the drive linearised"
    )
    yield (
        f"Natural frequencies are those {how} at "
        f"{speed.value(first.speeds[study.place]):.5g} {speed.unit}"
        f"{situation(study.modes.point)}."
    )
    if study.is_at_means:
        yield (
            "Critical speeds are those at which an order meets a natural frequency at the mean "
            "state of that speed."
        )
    if side := one_sided(study.modes.point):
        yield f"{side[0].upper()}{side[1:]}."
    parameters = system.structure.parameters
    every = parameters.all(study.modes.point.theta)
    laws = [
        f"{name} of {number(value)} rad/s"
        for name, p, value in zip(parameters.names, parameters.declared, every, strict=True)
        if p.vibrates
    ]
    if laws:
        yield (
            "Laws that depend on the frequency of the vibration have that of each order in the "
            "order response; natural frequencies and runs take the frequencies of the data: "
            f"{list_names(laws, 4)}."
        )
    at = amplitude_laws(system)
    if at.names:
        stated = zip(at.names, study.modes.point.theta[at.places], at.quantities, strict=True)
        yield (
            "Laws that depend on the amplitude of a vibration have at each speed the one that the "
            "order response finds, half the range of all computed orders; natural frequencies and "
            "runs take the amplitudes of the data: "
            + list_names([f"{n} of {number(v)} {system.quantity(q).unit}" for n, v, q in stated], 4)
            + "."
        )
    tree = system.structure.tree
    if not any(
        q.kind == "potential" and q.unit == "m" for n in tree.instances for q in n.layout.quantities
    ):
        yield "Bending and axial vibration, and their coupling with torsion, are left out."


def _response(response: OrderResponse, speed: Shown) -> Iterator[str]:
    rotation = response.rotation
    orders, ends = response.orders, speed.value(response.speeds)
    spread = f"{orders[0]:g} to {orders[-1]:g}" if len(orders) > 1 else f"{orders[0]:g}"
    yield (
        f"{count_words(len(orders), 'order')}, {spread}, at "
        f"{count_words(len(response.speeds), 'speed')} from "
        f"{ends[0]:g} to {ends[-1]:g} {speed.unit}; linearised about steady rotation "
        f"{_means(response)}{situation(rotation.points[0])}."
    )
    if response.damping_ratio:
        yield (
            f"A damping ratio of {response.damping_ratio:g} was added to every elastic mode, "
            "beside the dampers of the data."
        )
    yield from (f"{note[0].upper()}{note[1:]}." for note in response.notes)


def _means(response: OrderResponse) -> str:
    rotation = response.rotation
    if rotation.balancing is not None:
        return f"in which mean torques balance with {rotation.balancing} free"
    if rotation.is_given:
        return "at operating points that were given"
    if rotation.shaft is not None:
        return f"in which all parts turn together with {rotation.shaft}, their twists as at start"
    return "at the start point"


def _turns(count: int) -> str:
    return f"{count} turns" if count > 1 else "a turn"


def _accuracy(study: Study) -> str:
    rows = [
        (f"order response {caption}".strip(), "largest backward error", f"{response.residual:.0e}")
        for caption, response in study.responses.items()
    ]
    if len(study.modes.hertz):
        worst = f"{study.modes.accuracy.residuals.max():.0e}"
        rows.append(("modes", "largest residual of eigenpairs", worst))
    rows.append(("critical speeds", "intersections met to", f"{study.campbell.residual:.0e}"))
    for caption, run in study.runs.items():
        if run.certificate is not None:
            worst = f"{run.certificate.states.worst.relative:.0e}"
            rows.append((f"run {caption}", "estimated error relative to the range", worst))
    return table(("of", "what", "size"), rows, (2,))
