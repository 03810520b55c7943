"""Names and responses for python-control."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from lumped.errors import OptionError
from lumped.support.optional_packages import extra


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
