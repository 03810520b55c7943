"""Whether a system is ``der(x) = A x + g(t)`` with a polynomial g between jumps, and A and g."""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.language.lowering import has_steps
from lumped.support.made_once import Recent, made_once
from lumped.support.text_table import list_names
from lumped.timeloop.guards import may_be_unfit

_MOST = 6
_KEPT = 64
"""Parts of runs whose coefficients are kept."""


@dataclass(frozen=True, eq=False)
class LinearForm:
    """A system that is linear in its states, with polynomials of time beside them.

    Attributes
    ----------
    system : System
        What has this form.
    degree : int
        Highest power of the time.
    """

    system: System
    degree: int
    _taylor: ca.Function
    _known: Recent[tuple[scipy.sparse.csc_array, np.ndarray]]

    def at(
        self, theta: np.ndarray, time: float, settings: np.ndarray
    ) -> tuple[scipy.sparse.csc_array, np.ndarray]:
        """A, shape (n, n), and the coefficients of ``(t - time)^k`` in g, shape (degree + 1, n)."""
        key = (theta.tobytes(), time, settings.tobytes())
        return self._known.of(key, lambda: self._at(theta, time, settings))

    def _at(
        self, theta: np.ndarray, time: float, settings: np.ndarray
    ) -> tuple[scipy.sparse.csc_array, np.ndarray]:
        none = np.zeros(len(self.system.structure.states))
        matrix = self.system.state_matrix((none, theta, time, settings))
        found = np.asarray(self._taylor(theta, time, settings)).T
        factorials = np.array([math.factorial(k) for k in range(self.degree + 1)])
        return matrix, found / factorials[:, None]


def linear_form(system: System) -> LinearForm:
    """The linear form of a system.

    Raises
    ------
    OptionError
        If there is none; the text names what is not linear.
    """
    found = _form_or_refusal(system)
    if isinstance(found, OptionError):
        raise OptionError(str(found))
    return found


@made_once
def _form_or_refusal(system: System) -> LinearForm | OptionError:
    try:
        return _make(system)
    except OptionError as refusal:
        return refusal


def _make(system: System) -> LinearForm:
    if system.switching:
        raise _refusal(system, f"its modes depend on states, in {list_names(_switching(system))}")
    if system.structure.implicit:
        names = [system.structure.node_name(node) for node in system.structure.implicit]
        raise _refusal(system, f"{list_names(names)} follow from equations that are not linear")
    if may_be_unfit(system):
        raise _refusal(system, "what its states lead is not linear in them")
    x, theta, t, settings = system.inputs
    rates = system.rates
    if has_steps(rates, ca.vertcat(x, t)):
        raise _refusal(system, "kinks stand in `smooth` or in a spline of a state")
    entries = ca.SX(ca.jacobian(rates, x).nz[:])
    moving = ca.vertcat(x, t)
    if entries.numel() and any(ca.which_depends(entries, moving, 1, False)):
        rows = ca.which_depends(rates, moving, 2, True)
        names = [n for n, bent in zip(system.state_names, rows, strict=True) if bent]
        raise _refusal(
            system,
            f"the derivatives of {list_names(names)} are not linear in the states with constant "
            "coefficients",
        )
    terms = [ca.densify(ca.substitute(rates, x, ca.SX.zeros(x.numel())))]
    while terms[-1].numel() and any(ca.which_depends(terms[-1], t, 1, False)):
        if len(terms) > _MOST:
            rows = ca.which_depends(terms[-1], t, 1, True)
            names = [n for n, bent in zip(system.state_names, rows, strict=True) if bent]
            raise _refusal(
                system,
                f"what drives {list_names(names)} is no polynomial of the time between jumps, or "
                f"one of a degree above {_MOST}",
            )
        terms.append(ca.densify(ca.jacobian(terms[-1], t)))
    columns = ca.densify(ca.horzcat(*terms))
    taylor = ca.Function("taylor", [theta, t, settings], [columns])
    return LinearForm(system, len(terms) - 1, taylor, Recent(_KEPT))


def _switching(system: System) -> list[str]:
    found = system.switching
    conditions = [found.relation_text(k, True)[0] for k in range(len(found.relation_modes))]
    return sorted({*conditions, *found.names})


def _refusal(system: System, why: str) -> OptionError:
    return OptionError(
        f"{system.name}: method='exact' is for linear systems between jumps of functions of time, "
        f"but {why}. Use method='auto'."
    )
