"""Whether the wheels of a planetary set mesh, can be assembled and leave room for each other.

A planet fits at an angle if a whole number of teeth passes at each of its meshes between there and
the first planet, perhaps with a turn of its own. Tip circles have the addendum of one module
(ISO 53).
"""

from __future__ import annotations

import math  # noqa: TID251 - numbers of a structure
from collections.abc import Sequence

from lumped.components.each import one_for_each
from lumped.errors import DeclarationError, shown
from lumped.language.component import Component

__all__: list[str] = []

_OFF = 0.01  # teeth, by which rounded angles of planets may miss


def refuse_counts(part: Component, names: Sequence[str]) -> None:
    """Refuse what are no numbers of teeth, or of planets.

    Raises
    ------
    DeclarationError
        If one of them is no whole number, or too small.
    """
    for name in names:
        count, least = getattr(part, name), 1 if name == "n" else 3
        if isinstance(count, bool) or not isinstance(count, int) or count < least:
            what = "planets" if name == "n" else "teeth"
            raise DeclarationError(
                f"{part._label()}: {name} = {shown(count)} {what}: a whole number, at least "
                f"{least}, is needed."
            )


def refuse_mesh(part: Component, ring: str, formula: str, fitting: float) -> None:
    """Refuse a ring whose teeth do not fit those of sun and planets.

    Raises
    ------
    DeclarationError
        If they do not.
    """
    given = getattr(part, ring)
    if abs(given - fitting) > 1e-6:
        raise DeclarationError(
            f"{part._label()}: {ring} = {given} teeth do not mesh at the centre distance of sun "
            f"and planet: {formula} = {fitting:g} teeth are needed."
        )


def equal_angles(n: int) -> list[float]:
    """Angles of planets at equal distances, rad."""
    return [2 * math.pi * i / n for i in range(n)]


def waves(n: int) -> list[tuple[float, ...]]:
    """Cosines and sines of the angles of planets at equal distances."""
    angles = equal_angles(n)
    return [tuple(map(math.cos, angles)), tuple(map(math.sin, angles))]


def least_angle(z_s: int, z_p: int, z_r: int) -> float:
    """Pressure angle at the sun with which that at the ring is zero, rad; zero if there is none."""
    ratio = (z_s + z_p) / max(z_r - z_p, 1)
    return math.acos(ratio) if ratio < 1 else 0.0


def stepped_places(z_s: int, z_1: int, z_2: int, z_r: int) -> int:
    """Number of places on the circle at which a stepped planet fits."""
    return (z_s * z_2 + z_r * z_1) // math.gcd(z_1, z_2)


def refuse_assembly(part: Component, formula: str, pitch: int) -> None:
    """Refuse planets at equal angles whose teeth would not meet those of both wheels.

    Raises
    ------
    DeclarationError
        If `pitch`, the number of places on the circle at which a planet fits, is no multiple of
        their number.
    """
    n: int = getattr(part, "n")  # noqa: B009
    if pitch % n:
        fitting = ", ".join(str(k) for k in range(1, 13) if pitch % k == 0)
        raise DeclarationError(
            f"{part._label()}: n = {n} planets at equal angles cannot be assembled: {formula} = "
            f"{pitch / n:g} is not whole. It is for n = {fitting}."
        )


def angles_of(part: Component, name: str, n: int, pitch: int) -> list[float]:
    """Angles of planets, rad: those given, or equal ones.

    Raises
    ------
    DeclarationError
        If a planet cannot be assembled at its angle.
    """
    if getattr(part, name) == ():
        refuse_assembly(part, "(z_s + z_r) / n", pitch)
        return equal_angles(n)
    found = [float(angle) for angle in one_for_each(part, name, n)]
    for i, angle in enumerate(found):
        places = (angle - found[0]) * pitch / (2 * math.pi)
        if abs(places - round(places)) > _OFF:
            near = found[0] + round(places) * 2 * math.pi / pitch
            raise DeclarationError(
                f"{part._label()}: planets[{i}] cannot be assembled at {name} = {angle:.6g} rad: "
                f"from the first planet it needs a multiple of 2 pi / (z_s + z_r) = "
                f"{2 * math.pi / pitch:.6g} rad. The nearest place is {near:.6g} rad."
            )
    return found


def refuse_collision(part: Component, what: str, distance: float, tips: float) -> None:
    """Refuse wheels that touch beside their meshes; lengths over the module.

    Raises
    ------
    DeclarationError
        If their centres are nearer than the sum of their tip radii.
    """
    if distance <= tips:
        raise DeclarationError(
            f"{part._label()}: {what} collide: their centres are {distance:.4g} modules apart, "
            f"their tip radii add up to {tips:.4g} modules. Take fewer planets or smaller ones."
        )


def refuse_neighbours(
    part: Component, angles: Sequence[float], reach: float, planet: int, what: str = "planets"
) -> None:
    """Refuse planets that touch their neighbours: ``2 a sin(angle / 2) > d_tip`` is needed.

    `reach` is twice the centre distance a over the module of the planets, `planet` their teeth.

    Raises
    ------
    DeclarationError
        If they do.
    """
    ordered = sorted(angle % (2 * math.pi) for angle in angles)
    gaps = [b - a for a, b in zip(ordered, [*ordered[1:], ordered[0] + 2 * math.pi], strict=True)]
    if len(ordered) > 1:
        refuse_collision(part, what, reach * math.sin(min(gaps) / 2), planet + 2)


def refuse_long_planets(part: Component, short: int, long: int, z_short: int, z_long: int) -> None:
    """Refuse long planets that miss their short ones, or touch the next ones.

    `short` and `long` are twice the distances of their pins from the axis, over the module.

    Raises
    ------
    DeclarationError
        If they do.
    """
    n: int = getattr(part, "n")  # noqa: B009
    between = z_short + z_long
    if not abs(short - long) < between < short + long:
        raise DeclarationError(
            f"{part._label()}: z_short = {z_short} and z_long = {z_long} teeth do not mesh: with "
            f"pins {short / 2:g} and {long / 2:g} modules from the axis their sum must lie between "
            f"{abs(short - long)} and {short + long}."
        )
    apart = math.acos((short**2 + long**2 - between**2) / (2 * short * long))
    angle = 2 * math.pi / n - apart
    to_next = math.dist((short, 0.0), (long * math.cos(angle), long * math.sin(angle)))
    if n > 1:
        tips = (between + 4) / 2
        refuse_collision(part, "short planets and the next long ones", to_next / 2, tips)
