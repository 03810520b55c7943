"""Short runs of the five machines, and of the same run by several engines."""

from functools import cache
from unittest.mock import patch

import lumped as lp
from lumped.kernel import engine
from lumped.models.carrousel_coiler.scenes import elastic_winding, gear_change
from lumped.models.eccentric_shear.scenes import free_run
from lumped.models.pilger_mill.drive import start_up
from lumped.models.reversing_mill.scenes import skidding
from lumped.models.rotary_arm.control import run_controlled

SCENES = {
    "coiler": lambda **o: elastic_winding(length=400.0, until=2.0, **o),
    "coiler, gears": lambda **o: gear_change(until=6.0, **o),
    "shear": lambda **o: free_run(eps=0.1, turns=1, **o),
    "pilger mill": lambda **o: start_up(until=2.0, **o),
    "reversing mill": lambda **o: skidding(until=0.2, **o),
    "rotary arm": lambda **o: run_controlled(until=3.0, **o),
}


class _AskedError(Exception):
    """A scene has asked for its run."""


@cache
def asked(name):
    """The system of a scene, with the options of the run that is not made."""
    return asked_by(SCENES[name])


def asked_by(scene):
    """The system of a scene given as a function, with the options of the run that is not made."""
    found = []

    def noted(system, **options):
        found.append((system, options))
        raise _AskedError

    try:
        with patch.object(lp, "simulate", noted):
            scene()
    except _AskedError:
        pass
    ((system, options),) = found
    return system, options


def by_engines(action, engines=("llvm", "c")):
    """What an action gives when each engine makes its runs."""
    found = []
    for name in engines:
        with engine.using(name):
            found.append(action())
    return found
