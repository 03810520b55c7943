"""The sliders and values of a page, as the query string of its link."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from urllib.parse import parse_qsl, urlencode

from lumped.errors import OptionError, ParameterError
from lumped.explorer.sliders import Slider, slider
from lumped.explorer.study import Study, Values

_SLIDERS = "_sliders"
"""What names the parameters with sliders; no parameter begins with this sign."""


def query(study: Study, sliders: Sequence[Slider], values: Mapping[str, float]) -> str:
    """Which parameters have sliders, and all values that differ from those at first.

    Parameters
    ----------
    study : Study
        What is shown.
    sliders : sequence of Slider
        Those of the page.
    values : mapping of str to float
        Changed parameters.
    """
    first = study.system.parameters | study.base
    told = {name: repr(value) for name, value in values.items() if value != first[name]}
    return urlencode({_SLIDERS: ",".join(each.name for each in sliders), **told}, safe=",")


def from_query(
    study: Study, sliders: Sequence[Slider], text: str
) -> tuple[tuple[Slider, ...], Values]:
    """Sliders and changed parameters of a query string.

    Sliders that are on the page keep their ends.

    Raises
    ------
    OptionError
        If a value is given twice.
    UnknownNameError
        If a parameter does not exist, or is bound to others.
    ParameterError
        If a value is no number, out of range or beyond the ends of its slider.
    """
    values: Values = {}
    names: list[str] = []
    for name, given in parse_qsl(text, keep_blank_values=True):
        if name == _SLIDERS:
            names = [each for each in given.split(",") if each]
        elif name in values:
            raise OptionError(f"The link gives {name} twice.")
        else:
            try:
                values[name] = float(given)
            except ValueError:
                raise ParameterError(f"The link gives {name} = {given!r:.60}: no number.") from None
    system = study.system
    system.theta(study.base | values)
    theta, known = system.theta(study.base), {each.name: each for each in sliders}
    found = tuple(
        known[name] if name in known else slider(system, theta, name)
        for name in dict.fromkeys(names or known)
    )
    for each in found:
        each.check(values.get(each.name, each.default))
    return found, study.base | values
