"""Formulas of a user among the equations of a model: values wanted, and conditions to watch."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from importlib.util import find_spec

from lumped.errors import EquationError, UnitError
from lumped.flattening.flat_model import FlatModel, Group
from lumped.flattening.flatten import number_group
from lumped.flattening.template import Measure
from lumped.flattening.template_cache import template_of
from lumped.flattening.tree import Tree
from lumped.language.check_units import check_terms
from lumped.language.formula import Formula


def measure(tree: Tree, formula: Formula, *, plain: bool) -> Group:
    """A formula, lowered; kinks of a `plain` one are not watched.

    Raises
    ------
    UnknownNameError
        If a name in it does not exist.
    EquationError
        If it holds something that has no meaning there.
    UnitError
        If it adds or compares different kinds of quantities (noticed if pint is installed).
    """
    top = tree.instances[0]
    expression = formula.expression(tree.reference)
    if find_spec("pint") is not None:
        try:
            check_terms(expression)
        except UnitError as error:
            raise UnitError(f"{type(tree.model).__name__}: {formula}: {error}") from None
    try:
        template = template_of(
            top.component, lambda c: tree.below(c, top), [Measure(expression)], plain=plain
        )
    except EquationError as error:
        raise EquationError(f"{type(tree.model).__name__}: {formula}: {error}") from None
    group = Group(template, [], [0], [str(formula)])
    number_group(tree, group)
    return group


def watching(flat: FlatModel, formulas: Iterable[Formula]) -> FlatModel:
    """A model whose runs stop at the kinks of formulas; itself if they have none."""
    groups, modes, watched = list(flat.groups), flat.mode_count, dict(flat.watched)
    for formula in dict.fromkeys(formulas):
        group = measure(flat.tree, formula, plain=False)
        if formula not in watched and group.template.relations:
            group.first_equation, group.first_mode = flat.equation_count, modes
            modes += len(group.template.modes)
            groups.append(group)
            watched[formula] = group
    if len(watched) == len(flat.watched):
        return flat
    return replace(flat, groups=groups, watched=watched)
