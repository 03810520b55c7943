"""Programs outside of the equations that are asked at instants, such as a controller's."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lumped.errors import EquationError
from lumped.language.expression import Expr, Number, Ref, as_expr


class Session(ABC):
    """A program that is running, for one run at a time."""

    @abstractmethod
    def answer(self, values: np.ndarray) -> np.ndarray:
        """Answers to a question.

        Questions of a run come in order of time. That another run begins shows in their values,
        such as the number of a sample.

        Raises
        ------
        SolverError
            If there is no answer, with the reason.
        """

    @abstractmethod
    def end(self) -> None:
        """No run will ask again."""


class Program(ABC):
    """A program that answers questions; equal ones give equal answers.

    Attributes
    ----------
    text : str
        What it is, for errors, such as ``unit 'pi.fmu'``.
    """

    text: str

    @abstractmethod
    def begin(self) -> Session:
        """Begin to run."""

    @property
    @abstractmethod
    def content(self) -> str:
        """All on which answers depend, as text."""


@dataclass(frozen=True, eq=False)
class Question:
    """What a program is asked at an instant, and which states take the answers (see `question`)."""

    program: Program
    values: tuple[Expr, ...]
    answers: tuple[Ref, ...]


def question(program: Program, values: Sequence[Number], answers: Sequence[Expr]) -> Question:
    """Ask a program at the instant of a `when`, before its changes.

    Values are those at the instant, with all that samples then. The states that take the answers
    have them from then on, so what else samples at the same instant has the new ones.

    Parameters
    ----------
    program : Program
        What is asked.
    values : sequence of expression
        What it is given.
    answers : sequence of quantity
        States that take what it answers, one after the other.

    Returns
    -------
    Question
        For ``when(..., question=...)``.

    Raises
    ------
    EquationError
        If an answer is not a quantity.
    """
    for state in answers:
        if not isinstance(state, Ref):
            raise EquationError(f"question({program.text}, ...): {state!r} is not a quantity.")
    states = tuple(state for state in answers if isinstance(state, Ref))
    return Question(program, tuple(as_expr(value) for value in values), states)
