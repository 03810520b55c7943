"""Templates that are kept for later models with equal equations."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import fields

from lumped.flattening.template import Place, Template
from lumped.language.component import Component
from lumped.language.expression import (
    Call,
    Compare,
    ConstantExpression,
    Equation,
    Expr,
    Piecewise,
    Ref,
    Where,
    walk,
)
from lumped.language.quantity import Param
from lumped.language.switch import Hold, Single, When

__all__ = ["content_of", "template_of"]

_MOST = 1000
"""Templates that are kept."""

_known: dict[Hashable, Template] = {}


def template_of(
    component: Component,
    place: Place,
    items: list[Single],
    *,
    enclosed: bool = False,
    plain: bool = False,
) -> Template:
    """The template of some equations, made once for all models with equal ones.

    Where they are `enclosed`, parameters of no component that stand in them are those of the
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
        return _tree(place, what)
    if isinstance(what, Equation):
        return _tree(place, what.left - what.right)
    if isinstance(what, Compare):
        return what.strict, _tree(place, what.greater), _tree(place, what.less)
    if isinstance(what, tuple):
        return tuple(content_of(part, place) for part in what)
    if isinstance(what, Hold | When):
        parts = (getattr(what, field.name) for field in fields(what))
        return (type(what), *(content_of(part, place) for part in parts))
    if what is None:
        return None
    raise TypeError(what)


def _tree(place: Place, root: Expr) -> Hashable:
    numbers: dict[int, int] = {}
    found: list[Hashable] = []
    for node in walk(root):
        what: Hashable = getattr(node, "name", None)
        if isinstance(node, ConstantExpression):
            what = repr(node.value)
        elif isinstance(node, Call):
            what = node.op
        elif isinstance(node, Piecewise):
            what = node.pieces
        elif isinstance(node, Where):
            what = node.condition.strict
        elif isinstance(node, Ref):
            what = (place(node.owner), node.name, isinstance(node.quantity, Param))
        numbers[id(node)] = len(numbers)
        found.append((type(node), what, *(numbers[id(child)] for child in node.children())))
    return tuple(found)
