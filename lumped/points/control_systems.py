"""Linear systems for python-control and SciPy."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import scipy

from lumped.errors import OptionError
from lumped.support.optional_packages import extra

Four = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def control_names(names: Iterable[str]) -> list[str]:
    """Names as python-control takes them: a slash for each dot, which it refuses.

    Raises
    ------
    OptionError
        If a name has a slash itself, so that the change could not be undone.
    """
    given = list(names)
    for name in given:
        if "/" in name:
            raise OptionError(
                f"to_control: {name} has a slash, which python-control needs for the dots. Choose "
                "another key for the part."
            )
    return [name.replace(".", "/") for name in given]


def scipy_state_space(title: str, matrices: Four) -> Any:
    """A continuous ``scipy.signal.StateSpace``."""
    _check(title, "to_scipy", matrices[3])
    return scipy.signal.StateSpace(*matrices)


def control_state_space(
    title: str, matrices: Four, states: Iterable[str], inputs: Iterable[str], outputs: Iterable[str]
) -> Any:
    """A continuous ``control.StateSpace`` with names."""
    control = extra("control", "control", "to_control")
    _check(title, "to_control", matrices[3])
    return control.StateSpace(
        *matrices,
        name=title,
        states=control_names(states),
        inputs=control_names(inputs),
        outputs=control_names(outputs),
    )


def control_response(
    title: str,
    hertz: np.ndarray,
    values: np.ndarray,
    inputs: Iterable[str],
    outputs: Iterable[str],
) -> Any:
    """A ``control.FrequencyResponseData`` with names.

    Parameters
    ----------
    title : str
        Name of the system.
    hertz : ndarray, shape (k,)
        Frequencies, Hz.
    values : complex ndarray, shape (k, outputs, inputs)
        Response.
    inputs, outputs : iterable of str
        Names.
    """
    control = extra("control", "control", "to_control")
    return control.FRD(
        np.moveaxis(values, 0, 2),
        2 * np.pi * hertz,
        name=title,
        inputs=control_names(inputs),
        outputs=control_names(outputs),
    )


def _check(title: str, what: str, D: np.ndarray) -> None:
    if not D.size:
        raise OptionError(
            f"{title}: {what} needs at least one input and one output; name them in "
            "linearise(inputs=, outputs=)."
        )
