"""Laws that hold at the amplitude with which a quantity vibrates."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca

from lumped.compiler.system import System
from lumped.support.made_once import made_once


class AmplitudeLaws(NamedTuple):
    """Parameters that are amplitudes at which laws hold.

    Attributes
    ----------
    places : list of int
        Among the parameters that have a value of their own.
    names : tuple of str
        Of the parameters.
    quantities : tuple of str
        What vibrates with these amplitudes.
    """

    places: list[int]
    names: tuple[str, ...]
    quantities: tuple[str, ...]


@made_once
def amplitude_laws(system: System) -> AmplitudeLaws:
    """Those of a system that its motion depends on."""
    parameters = system.structure.parameters
    known = parameters.amplitudes
    if not known:
        return AmplitudeLaws([], (), ())
    places = list(known)
    used = ca.which_depends(system.rates, system.inputs[1][places], 1, False)
    chosen = [place for place, is_used in zip(places, used, strict=True) if is_used]
    names = [parameters.names[parameters.free[place]] for place in chosen]
    return AmplitudeLaws(chosen, tuple(names), tuple(known[place] for place in chosen))
