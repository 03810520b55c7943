"""Numbers that sum up a run, its modes or its vibration, as expressions of readings."""

from lumped.functionals.damage_law import Curve
from lumped.functionals.functional import Condition, Functional
from lumped.functionals.of_runs import (
    at_event,
    at_time,
    count,
    damage,
    final,
    highest,
    impulse,
    instant,
    integral,
    loss,
    lowest,
    mean,
    peak,
    rms,
    span,
    swing,
)
from lumped.functionals.of_vibration import clearance, damping, frequency, order_peak, separation

__all__ = [
    "Condition",
    "Curve",
    "Functional",
    "at_event",
    "at_time",
    "clearance",
    "count",
    "damage",
    "damping",
    "final",
    "frequency",
    "highest",
    "impulse",
    "instant",
    "integral",
    "loss",
    "lowest",
    "mean",
    "order_peak",
    "peak",
    "rms",
    "separation",
    "span",
    "swing",
]
