"""Steps of a run one after the other, and what is carried back over them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lumped.gradients.jumps import EventDerivatives


@dataclass(frozen=True, eq=False)
class Span:
    """Steps one after the other.

    Attributes
    ----------
    theta : ndarray
        Parameters.
    t, x, m : ndarray, shapes (k + 1,), (k + 1, n), (k + 1, settings)
        Ends of the steps: times, s, states, settings of the step that begins there.
    is_implicit : ndarray, shape (k,)
        Whether each step is one of the implicit method.
    changes : sequence of int
        From which ends no step leads to the next, as the run changes there.
    """

    theta: np.ndarray
    t: np.ndarray
    x: np.ndarray
    m: np.ndarray
    is_implicit: np.ndarray
    changes: Sequence[int] = ()

    @cached_property
    def is_step(self) -> np.ndarray:
        """Whether a step leads from each end to the next, shape (k,)."""
        found = np.ones(len(self.t) - 1, dtype=np.int64)
        found[list(self.changes)] = 0
        return found

    @cached_property
    def needs_matrix(self) -> bool:
        """Whether a step of the implicit method is among them."""
        return bool((self.is_implicit & (self.is_step > 0)).any())

    def part(self, begin: int, end: int) -> Span:
        """Those from one end of a step to another."""
        own = slice(begin, end + 1)
        changes = [k - begin for k in self.changes if begin <= k < end]
        implicit = self.is_implicit[begin:end]
        return Span(self.theta, self.t[own], self.x[own], self.m[own], implicit, changes)

    @classmethod
    def join(cls, spans: Sequence[Span]) -> Span:
        """The steps of several, one after the other, with changes between them."""
        first = spans[0]
        if len(spans) == 1:
            return first
        t, x, m = (np.concatenate([getattr(span, v) for span in spans]) for v in ("t", "x", "m"))
        ends = list(itertools.accumulate(len(span.t) for span in spans))
        implicit = np.zeros(len(t) - 1, dtype=bool)
        for span, end in zip(spans, ends, strict=True):
            implicit[end - len(span.t) : end - 1] = span.is_implicit
        return Span(first.theta, t, x, m, implicit, [end - 1 for end in ends[:-1]])


class Jump(NamedTuple):
    """What a change between two steps does to derivatives.

    Attributes
    ----------
    step : int
        In place of which step it stands.
    change : EventDerivatives
        The derivatives of the states and of the instant.
    late : ndarray, shape (k,)
        Derivatives of the results by the instant.
    """

    step: int
    change: EventDerivatives
    late: np.ndarray


class Pulse(NamedTuple):
    """Derivatives of a result by the states, and integrals, at one end of a step.

    Attributes
    ----------
    end, column : int
        Which end, and which result.
    slopes : ndarray, shape (n + q,)
        Its derivatives.
    """

    end: int
    column: int
    slopes: np.ndarray


class Carried(NamedTuple):
    """Derivatives of results that are carried back over steps.

    Attributes
    ----------
    adjoint : ndarray, shape (n + q, k)
        Derivatives of the results by the states, and by integrals.
    by_parameters : ndarray, shape (p, k)
        By the parameters.
    largest, lost : ndarray, shape (n + q, k)
        Largest size of the adjoint so far, and the sizes of the errors of all steps, together.
    """

    adjoint: np.ndarray
    by_parameters: np.ndarray
    largest: np.ndarray
    lost: np.ndarray


class Back(NamedTuple):
    """What a sweep back over some steps finds.

    Attributes
    ----------
    carried : Carried
        Derivatives at the begin.
    errors : ndarray, shape (steps, k)
        Error of each result by each step, relative to its derivatives by the states there.
    parts, part_errors : ndarray, shape (steps, q)
        Integrals over each step, and their errors.
    """

    carried: Carried
    errors: np.ndarray
    parts: np.ndarray
    part_errors: np.ndarray
