"""Jumps: constraints that stick and let go, and changes of states at an instant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from lumped.errors import EquationError, shown
from lumped.language.expression import Compare, Equation, Expr, Number, Ref, as_expr, der
from lumped.language.program import Question


@dataclass(frozen=True, eq=False)
class Hold:
    """A constraint ``speed == 0`` with a limited reaction (see `hold`).

    Its speed may leap with conditions and functions of time; it is direct if the reaction
    determines the speed and not the rate of it, as beside dampers without inertia. The hold of the
    opposite limit of the same friction is so many after it, 0 if there is none.
    """

    reaction: Ref
    speed: Ref
    forward: Expr | None
    backward: Expr | None
    upper: Expr | None
    lower: Expr | None
    engaged: Compare | None
    gap: Expr | None
    restitution: Expr
    pressed: bool
    position: Expr | None
    words: tuple[str, str, str] | None = None
    leaps: bool = False
    direct: bool = False
    opposite: int = 0

    def called(self, sticks: str, slides: str, free: str = "free") -> Hold:
        """The same, with words for events: what it is while it sticks, slides forward, is free."""
        return replace(self, words=(sticks, slides, free))

    @property
    def impulsive(self) -> bool:
        """Whether the reaction can be an impulse, because it has no limit on one side."""
        return self.upper is None or self.lower is None

    def equations(self) -> list[Equation]:
        """Equations of the reaction and the position, as they read while the constraint sticks."""
        held = der(self.speed) == 0
        return [held] if self.position is None else [held, self.position == 0]


@dataclass(frozen=True, eq=False)
class When:
    """Changes of states at the instant when a condition becomes true (see `when`)."""

    condition: Compare
    changes: tuple[tuple[Ref, Expr], ...]
    question: Question | None = None


Single = Equation | Hold | When
Item = Single | tuple[Equation, ...]
"""Items that ``equations()`` may yield."""


def hold(
    reaction: Expr,
    speed: Expr,
    *,
    forward: Number | None = None,
    backward: Number | None = None,
    upper: Number | None = None,
    lower: Number | None = None,
    engaged: Compare | None = None,
    gap: Number | None = None,
    restitution: Number = 0.0,
    pressed: bool = True,
    position: Expr | None = None,
) -> Hold:
    """A constraint ``speed == 0`` that holds as long as its reaction stays within limits.

    Friction, clutches, freewheels, stops and couplings are all made of it. While it *sticks*, the
    reaction is whatever keeps the speed at zero. Beyond a limit it lets go and *slides* forward or
    backward with a given reaction. All elements of a model choose their modes together, so that
    accelerations and reactions agree (Pfeiffer and Glocker, Multibody Dynamics with Unilateral
    Contacts, 1996, ch. 5; Murty, Opsearch 11 (1974) 196). A reaction without limit can be an
    impulse: if such a constraint closes at a speed, velocities jump so that momentum is kept.

    Parameters
    ----------
    reaction, speed : quantity
        Reaction, positive against a positive speed; the speed that is zero while it sticks.
    forward, backward : expression, optional
        Reaction while sliding with positive and negative speed. Without `backward` (`forward`)
        the speed cannot become negative (positive).
    upper, lower : expression, optional
        Limits of the reaction while it sticks; None for no limit.
    engaged : relation, optional
        While this is false there is no reaction.
    gap : expression, optional
        Position whose derivative is `speed`: the constraint only closes where the gap is zero,
        and pushes towards positive speed. `upper` is then 0 unless given.
    restitution : expression
        Ratio of the speeds after and before an impact.
    pressed : bool
        Whether impulses press it: friction whose limits depend on a reaction then takes impulses,
        too. False for losses that are averages over turns, as those of gears.
    position : quantity, optional
        0 while it sticks, 1 and -1 while it slides forward and backward (1: open, for a gap), 2
        while it is not engaged.

    Returns
    -------
    Hold
        To be yielded by ``equations``.

    Raises
    ------
    EquationError
        If `reaction` or `speed` are not quantities, or the limits make no sense.
    """
    for what, given in (("reaction", reaction), ("speed", speed)):
        if not isinstance(given, Ref):
            raise EquationError(f"hold({what}={given!r}): {what} must be a quantity.")
    if engaged is not None and not isinstance(engaged, Compare):
        raise EquationError(f"hold(engaged={engaged!r}): a relation such as f > 0 is needed.")
    if gap is not None:
        forward = 0.0 if forward is None else forward
        upper = 0.0 if upper is None else upper
    for side, limit, law in (("upper", upper, forward), ("lower", lower, backward)):
        if limit is not None and law is None:
            way = "forward" if side == "upper" else "backward"
            raise EquationError(
                f"hold({reaction!r}, ...): beyond the limit {side} = {limit!r} it would slide "
                f"{way}, but its reaction then is not given; give {way}=."
            )

    if isinstance(upper, int | float) and isinstance(lower, int | float) and upper < lower:
        raise EquationError(
            f"hold({reaction!r}, ...): upper = {upper!r} must be at least lower = {lower!r}. A "
            "reaction is positive against a positive speed."
        )

    def expr(given: Number | None) -> Expr | None:
        return None if given is None else as_expr(given)

    assert isinstance(reaction, Ref)
    assert isinstance(speed, Ref)
    sides = expr(forward), expr(backward), expr(upper), expr(lower)
    rest = expr(gap), as_expr(restitution)
    return Hold(reaction, speed, *sides, engaged, *rest, pressed, position)


def when(
    condition: Compare, changes: Mapping[Expr, Number], *, question: Question | None = None
) -> When:
    """Change states at the instant when a condition becomes true.

    The new values are computed from the values just before. A condition that is true from the
    start does nothing. A quantity that only changes by jumps is a state with ``der(y) == 0``.

    Parameters
    ----------
    condition : relation
        For example ``self.s <= 0``.
    changes : mapping of quantity to expression
        States and their new values.
    question : Question, optional
        What a program is asked then (see `lumped.language.program`).

    Returns
    -------
    When
        To be yielded by ``equations``.

    Raises
    ------
    EquationError
        If the condition is not a relation, or a key is not a quantity.
    """
    if not isinstance(condition, Compare):
        raise EquationError(f"when({condition!r}, ...): a relation such as s <= 0 is needed.")
    if not isinstance(changes, Mapping):
        raise EquationError(
            f"when({condition!r}, {shown(changes)}): the changes are a dictionary of states and "
            "their new values."
        )
    pairs = []
    for target, value in changes.items():
        if not isinstance(target, Ref):
            raise EquationError(f"when({condition!r}, ...): {target!r} is not a quantity.")
        pairs.append((target, as_expr(value)))
    if not pairs:
        raise EquationError(f"when({condition!r}, ...): no changes are given.")
    return When(condition, tuple(pairs), question)
