"""Functions of the time in the specifications of reference cases."""

import numpy as np

import lumped as lp


def const(k):
    return k


def sine(amplitude, frequency, phase=0.0, offset=0.0):
    return offset + amplitude * lp.ops.sin(2 * np.pi * frequency * lp.time + phase)


def step(height, begin=0.0, offset=0.0):
    return offset + lp.ops.where(lp.time >= begin, height, 0)


def ramp(height, duration, begin=0.0, offset=0.0):
    return offset + lp.ops.table([begin, begin + duration], [0.0, height])


def pulse(height, width_percent, period, begin, offset=0.0, until=10.0):
    """Pulses from `begin` on, each for a share of the period."""
    starts = np.arange(begin, until, period).tolist()
    width = width_percent / 100 * period
    return sum((step(height, t) - step(height, t + width) for t in starts), start=offset)


SIGNALS = {
    "const": const,
    "pulse": pulse,
    "ramp": ramp,
    "sine": sine,
    "step": step,
    "table": lambda rows: lp.ops.table(*zip(*rows, strict=True)),
}
