"""The rotary arm by hand: torques at an angle, and the reference files."""

from functools import partial

import numpy as np
from references import columns

data = partial(columns, "rotary_arm", named=False)
R, TRAYS, ARMS, WEIGHTS, MANDREL, SHAFT = 1.008, 325.0, 7315.0, 5320.0, 31_700.0, 7269.0
EMPTY = TRAYS * R**2 + ARMS * R**2 / 3 + WEIGHTS * 0.35**2 + SHAFT * 0.135**2 / 2 + 0.2
LOADED = EMPTY + MANDREL * R**2
SPIN = MANDREL * 0.2535**2 / 2
ROTOR = 12.8 * 50**2


def gravity(phi, loaded, g=9.80665):
    moment = TRAYS * R + ARMS * R / 2 - WEIGHTS * 0.35 + loaded * MANDREL * R
    return moment * g * np.cos(phi)


def friction(loaded, g=9.80665):
    return 0.15 * 1.27 * 0.135 * (TRAYS + ARMS + WEIGHTS + SHAFT + loaded * MANDREL) * g
