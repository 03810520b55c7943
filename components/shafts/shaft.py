"""Shafts made of sections in line, and what all sections have in common.

Stiffness and inertia of a section follow from its diameters, its length and its material, as
expressions, so a natural frequency has an exact derivative by a diameter.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lumped import (
    Component,
    Connection,
    Equation,
    Expr,
    Flange,
    Output,
    Param,
    chain,
    connect,
    param,
)
from lumped.components.shafts.continuous import ContinuousElement, bars_needed
from lumped.components.shafts.element import ShaftElement
from lumped.components.shafts.fineness import elements_needed
from lumped.components.shafts.materials import Material, material_of_name
from lumped.components.shafts.notch import Notch
from lumped.components.shafts.steps import RULES, lengthen
from lumped.errors import DeclarationError, UnknownNameError, nearest, shown
from lumped.language.component import Made, path_of
from lumped.language.declared import place_of, values_of
from lumped.language.expression import Number
from lumped.language.given_numbers import read_given_number
from lumped.ops import maximum, minimum, pi, smooth, where

__all__ = ["Section", "Shaft", "neighbours"]


def _label(part: Component) -> str:
    return f"{path_of(part)} ({type(part).__name__})".lstrip()


def _shaft(part: Component) -> Shaft | None:
    """The shaft in which a part stands."""
    place = place_of(part)
    return place[0] if place is not None and isinstance(place[0], Shaft) else None


def neighbours(part: Component) -> tuple[Section | None, Section | None]:
    """The sections before and behind a part of a shaft; notches between do not count.

    Parameters
    ----------
    part : Component
        As it stands in a model.

    Returns
    -------
    (Section or None, Section or None)
    """
    place, shaft = place_of(part), _shaft(part)
    if place is None or shaft is None:
        return None, None
    number = int(place[1].partition("[")[2][:-1])
    before = (s for s in reversed(shaft.sections[:number]) if isinstance(s, Section))
    behind = (s for s in shaft.sections[number + 1 :] if isinstance(s, Section))
    return next(before, None), next(behind, None)


def _own_material(part: Shaft | Section) -> Material:
    return material_of_name(part.material or "steel", _label(part))


def _of_material(name: str) -> Any:
    """Default of a material's parameter: its own, that of the shaft around it, or that of steel."""

    def default(section: Section) -> Expr | float:
        shaft = None if section.material else _shaft(section)
        value: Expr | float = getattr(_own_material(section) if shaft is None else shaft, name)
        return value

    return default


def _lengthen_at(side: int) -> Any:
    """Default of the length that the step at end a (0) or b (1) adds."""

    def default(section: Section) -> Expr | float:
        other, shaft = neighbours(section)[side], _shaft(section)
        if other is None or shaft is None:
            return 0.0
        if shaft.step not in RULES:
            raise UnknownNameError(
                f"{_label(shaft)}: step = {shown(shaft.step)} is no rule. "
                f"{nearest(str(shaft.step), RULES)}"
            )
        return lengthen(shaft.step, section.outside()[side], other.outside()[1 - side])

    return default


def _of_shaft(name: str) -> Any:
    """Default of a parameter of the loss: that of the shaft around it, else no loss."""

    def default(section: Section) -> Expr | float | None:
        shaft = _shaft(section)
        if name == "w_loss" and "eta" in values_of(section):
            return None if shaft is None or "w_loss" not in values_of(shaft) else shaft.w_loss
        return (0.0 if name == "eta" else 1.0) if shaft is None else getattr(shaft, name)

    return default


def _is_continuous(section: Section) -> bool:
    shaft = _shaft(section)
    found = section.continuous or (shaft is not None and shaft.continuous)
    for part in (section, shaft):
        if part is not None and "eta" in values_of(part) and not found:
            raise DeclarationError(
                f"{_label(part)}: eta is given, but lumped elements have no loss; give "
                "continuous=True, too."
            )
    return found


def _count(section: Section) -> int:
    """Number of elements of a section."""
    given, shaft = section.n_elements, _shaft(section)
    if given != 0:
        if not isinstance(given, int) or isinstance(given, bool) or given < 1:
            raise DeclarationError(
                f"{_label(section)}: n_elements = {shown(given)}: a whole number, at least 1, or 0 "
                "for as many as the f_max of the shaft needs."
            )
        return given
    if shaft is None:
        return 1
    f_max, accuracy = shaft.limit()
    begin, end = section.ends()
    if _is_continuous(section) and begin is end:  # no cone
        c, J = (read_given_number(section, name) for name in ("c", "J"))
        return bars_needed((J / c) ** 0.5, f_max) if c > 0 and J > 0 else 1
    length, G, rho = (read_given_number(section, name) for name in ("L", "G", "rho"))
    if f_max == 0 or not (length > 0 and G > 0 and rho > 0):  # what is wrong is told with all else
        return 1
    return elements_needed(length * (rho / G) ** 0.5, f_max, accuracy)


def _elements(section: Section) -> list[ShaftElement]:
    """The pieces of a section; what steps add to it is spread over all of them."""
    n = _count(section)
    kind, loss = ShaftElement, {}
    if _is_continuous(section):
        kind, loss = ContinuousElement, {"eta": section.eta, "w_loss": section.w_loss}
    made = []
    for i in range(n):
        soft, heavy_a, heavy_b, modulus = section.shares(i / n, (i + 1) / n)
        made.append(
            kind(
                c=section.c / soft,
                J_a=section.J * heavy_a,
                J_b=section.J * heavy_b,
                W=section.W * modulus,
                **loss,
            )
        )
    return made


class Section(Component):
    """Section of a shaft, base of all kinds: ``c = G / softness``, ``stress = tau / W``.

    ``softness`` is the integral of ``1 / I_p`` over the length, ``I_p = pi (d^4 - bore^4) / 32``;
    ``W = 2 I_p / d``. A section is a row of `ShaftElement`, one unless `n_elements` or the `f_max`
    of the shaft around it asks for more: a structural choice. Their inertia is shared between their
    ends so that total and centre are kept.

    `material` is the name of one of `MATERIALS`; without it, that of the shaft around it, else
    steel. `G`, `rho`, `c`, `J` and `W` may be given instead of what follows from material and
    geometry. `stress` is the nominal shear stress of the element where it is largest, at its
    thinner end, with its sign; a response takes the element that is so at its operating point, the
    first at rest; the others are ``elements[i].stress``. ``notch_stress = K_ts stress``.

    With `continuous`, of the section or of the shaft around it, its inertia is distributed in all
    responses to a vibration, and the material has the loss factor `eta` (see `ContinuousElement`).
    The elements then are exact there whatever their number, but for cones; runs have lumps.
    """

    symbol = "shaft"
    flange_a = Flange(free=True)
    flange_b = Flange(free=True)
    stress = Output("Pa", "nominal shear stress where it is largest")
    notch_stress = Output("Pa", "the same, times the notch factor")
    material: str = ""
    n_elements: int = 0
    continuous: bool = False
    L: Param = param(
        "m",
        "length, from which steps take no more than all",
        above=lambda section: maximum(0.0, -section.x_a - section.x_b),
    )
    G: Param = param("Pa", "shear modulus", _of_material("G"), above=0)
    rho: Param = param("kg/m3", "density", _of_material("rho"), above=0)
    eta: Param = param("1", "loss factor of the material, if continuous", _of_shaft("eta"), min=0)
    w_loss: Param = param(
        "rad/s", "angular frequency at which a run has that loss", _of_shaft("w_loss"), above=0
    )
    K_ts: Param = param("1", "notch factor, largest stress over nominal shear stress", 1.0, min=1)
    x_a: Param = param("m", "length that the step at flange a adds", _lengthen_at(0))
    x_b: Param = param("m", "length that the step at flange b adds", _lengthen_at(1))
    c: Param = param("N.m/rad", "torsional stiffness", lambda s: s.stiffness(), above=0)
    J: Param = param("kg.m2", "moment of inertia", lambda s: s.inertia(), above=0)
    W: Param = param(
        "m3",
        "polar section modulus of the thinner end",
        lambda s: 2 * s.polar_moment(s.thin()) / s.thin(),
        above=0,
    )
    elements: Any = Made(_elements)

    def ends(self) -> tuple[Expr, Expr]:
        """Outside diameters that count for the stiffness at flanges a and b, m."""
        raise NotImplementedError

    def outside(self) -> tuple[Expr, Expr]:
        """Outside diameters at flanges a and b, for steps and notches, m."""
        return self.ends()

    def polar_moment(self, d: Expr) -> Expr:
        """Polar second moment of area where the outside diameter is `d`, m4."""
        return pi / 32 * (d**4 - self.hole() ** 4)

    def hole(self) -> Expr | float:
        """Diameter of the bore, m."""
        return 0.0

    def softness(self) -> Expr:
        """Integral of ``1 / I_p`` over the length, 1/m3."""
        return self.L / self.polar_moment(self.ends()[0])

    def stiffness(self) -> Expr:
        """Torsional stiffness with the lengths that steps add, N.m/rad."""
        a, b = self.ends()
        if a is b:
            return self.G * self.polar_moment(a) / (self.L + self.x_a + self.x_b)
        added = self.x_a / self.polar_moment(a) + self.x_b / self.polar_moment(b)
        return self.G / (self.softness() + added)

    def inertia(self) -> Expr:
        """Moment of inertia, kg.m2."""
        raise NotImplementedError

    def thin(self) -> Expr:
        """Outside diameter of the thinner end, m."""
        return self.ends()[0]

    def shares(self, begin: float, end: float) -> tuple[Number, Number, Number, Number]:
        """What a piece between two places, shares of the length, has of the whole section.

        Of its softness, of its inertia for both ends of the piece, and of its section modulus.
        """
        length = end - begin
        return length, length / 2, length / 2, 1.0

    def equations(self) -> Iterator[Equation]:
        stresses = [element.stress for element in self.elements]
        most = least = stresses[0]
        for stress in stresses[1:]:
            most, least = maximum(most, stress), minimum(least, stress)
        if len(stresses) > 1:
            most = smooth(where(most + least >= 0, most, least))
        yield self.stress == most
        yield self.notch_stress == self.K_ts * self.stress

    def connections(self) -> Iterator[Connection]:
        yield connect(self.flange_a, self.elements[0].flange_a)
        yield from chain(*self.elements)
        yield connect(self.elements[-1].flange_b, self.flange_b)


def _no_sections(shaft: Shaft) -> None:
    raise DeclarationError(
        f"{_label(shaft)}: no sections. Give them in their order, such as "
        "Shaft(sections=[Solid(d=0.1, L=0.5), Taper(d_a=0.1, d_b=0.08, L=0.1)])."
    )


class Shaft(Component):
    """Sections in line, from flange a to b: ``1 / c = sum(1 / c_i)``, ``J = sum(J_i)``.

    `sections` are `Section` of any kind, and notches (`Fillet`, `Keyway`, `RadialHole`) at their
    places between them. `material`, or `G` and `rho`, hold for all that do not say otherwise.

    `step` is the rule for the length that a sudden step adds to its thinner side and takes from the
    thicker one: ``"computed"`` (finite volumes, sharp corner), ``"textbook"`` (a table of the
    trade), or ``"none"``. It counts outside diameters of solid parts.

    With `f_max`, the highest frequency of interest in Hz, each section is cut into as many elements
    as a uniform bar needs for natural frequencies up to there with the relative error `accuracy`:
    ``pi f_max L sqrt(rho / G) / sqrt(3 accuracy)``, see
    `lumped.components.shafts.fineness.elements_needed`. Their number is fixed at assembly, by the
    lengths and materials as written. ``f_max = 0`` is one element for each section.

    With `continuous` all sections are bars with distributed inertia in responses to a vibration,
    and `eta` is the loss factor of the material (see `ContinuousElement`). `f_max` then cuts them
    so that their law holds up to there; `accuracy` is that of cones.
    """

    symbol = "stepped_shaft"
    flange_a = Flange(free=True)
    flange_b = Flange(free=True)
    c = Output("N.m/rad", "torsional stiffness from end to end")
    J = Output("kg.m2", "moment of inertia")
    material: str = "steel"
    step: str = "computed"
    f_max: float = 0.0
    accuracy: float = 0.01
    continuous: bool = False
    G: Param = param("Pa", "shear modulus", lambda shaft: _own_material(shaft).G, above=0)
    rho: Param = param("kg/m3", "density", lambda shaft: _own_material(shaft).rho, above=0)
    eta: Param = param("1", "loss factor of the material, if continuous", 0.0, min=0)
    w_loss: Param = param(
        "rad/s",
        "angular frequency at which a run has that loss",
        lambda shaft: None if "eta" in values_of(shaft) else 1.0,
        above=0,
    )
    sections: Any = Made(_no_sections)

    def limit(self) -> tuple[float, float]:
        """Highest frequency of interest, Hz, and relative error, checked.

        Raises
        ------
        DeclarationError
            If they make no sense.
        """
        for name, unit, most in (("f_max", " Hz", float("inf")), ("accuracy", "", 1.0)):
            value = getattr(self, name)
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not 0 <= value < most or (value == 0 and name == "accuracy"):
                raise DeclarationError(
                    f"{_label(self)}: {name} = {shown(value)}{unit}: "
                    + (
                        "a relative error between 0 and 1, such as 0.01."
                        if name == "accuracy"
                        else "the highest frequency of interest, or 0 for one element a section."
                    )
                )
        return self.f_max, self.accuracy

    def equations(self) -> Iterator[Equation]:
        sections = [s for s in self.sections if isinstance(s, Section)]
        soft, heavy = 1 / sections[0].c, sections[0].J
        for section in sections[1:]:
            soft, heavy = soft + 1 / section.c, heavy + section.J
        yield self.c == 1 / soft
        yield self.J == heavy

    def connections(self) -> Iterator[Connection]:
        self.limit()
        for part in self.sections:
            if not isinstance(part, Section | Notch):
                raise DeclarationError(
                    f"{_label(part)} is no section of a shaft and no notch. Connect it to an end "
                    "of the shaft, or between two shafts."
                )
        if not any(isinstance(part, Section) for part in self.sections):
            _no_sections(self)
        yield connect(self.flange_a, self.sections[0].flange_a)
        yield from chain(*self.sections)
        yield connect(self.sections[-1].flange_b, self.flange_b)
