"""Templates that are kept for later models with equal equations."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import fields

from lumped.flattening.template import Measure, Place, Template
from lumped.language.component import Component
from lumped.language.expression import Compare, Equation, Expr
from lumped.language.formula import content_of_expression
from lumped.language.program import Question
from lumped.language.switch import Hold, Single, When

_MOST = 1000
"""Templates that are kept."""

_known: dict[Hashable, Template] = {}


def template_of(
    component: Component,
    place: Place,
    items: Sequence[Single | Measure],
    *,
    enclosed: bool = False,
    plain: bool = False,
) -> Template:
    """The template of some equations, made once for all models with equal ones.

    Where they are `enclosed`, parameters of no component that occur in them are those of the
    enclosing one, else those of `component` itself. Kinks of `plain` ones are not watched.
    """
    key = enclosed, plain, content_of(tuple(items), place)
    found = _known.get(key)
    if found is None:
        found = Template(component, place, items, enclosed=enclosed, plain=plain)
        found.content = key
        if len(_known) >= _MOST:
            del _known[next(iter(_known))]
        _known[key] = found
    return found


def content_of(what: object, place: Place) -> Hashable:
    """All that equations and expressions say, with names relative to a component."""
    if isinstance(what, Expr):
        return content_of_expression(what, place)
    if isinstance(what, Measure):
        return Measure, content_of_expression(what.expression, place)
    if isinstance(what, Equation):
        return content_of_expression(what.left - what.right, place)
    if isinstance(what, Compare):
        sides = (content_of_expression(side, place) for side in (what.greater, what.less))
        return what.strict, what.words, *sides
    if isinstance(what, tuple):
        return tuple(content_of(part, place) for part in what)
    if isinstance(what, Hold | When):
        parts = (getattr(what, field.name) for field in fields(what))
        return (type(what), *(content_of(part, place) for part in parts))
    if isinstance(what, Question):
        parts = (content_of(part, place) for part in (what.values, what.answers))
        return (Question, what.program.content, *parts)
    if what is None or isinstance(what, int | str):
        return what
    raise TypeError(what)
