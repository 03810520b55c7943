"""Turns of the pilger mill and its reference files, computed independently with numpy and scipy."""

from functools import partial

import numpy as np
from references import columns

import lumped as lp
from lumped.models.pilger_mill import stand
from lumped.models.pilger_mill.stand import Mill

R, L, L1, E = 0.59, 4.25, 3.4, 0.33

data = partial(columns, "pilger_mill")


def turn(name, design="after", kind=Mill, degrees=None, **changes):
    w = stand.SPEED[name]
    degrees = np.arange(361.0) if degrees is None else degrees
    part = stand.mill(name, design, kind, **changes)
    return stand.revolution(stand.turn_mill(part, w * lp.time), w, degrees)
