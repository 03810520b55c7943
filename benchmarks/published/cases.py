"""All published runs, those of mechanisms first."""

from benchmarks.published import linkages, stiff
from benchmarks.published.amplifier import AMPLIFIER
from benchmarks.published.andrews import ANDREWS
from benchmarks.published.car_axis import CAR_AXIS
from benchmarks.published.elastic_crank import ELASTIC_CRANK

MECHANISMS = (
    ANDREWS,
    CAR_AXIS,
    ELASTIC_CRANK,
    linkages.DOUBLE_FOUR_BAR,
    linkages.ONE,
    linkages.TWO,
    linkages.TEN,
    linkages.PENDULUM,
    linkages.FOUR_PENDULUMS,
)
STIFF = (
    stiff.HIRES,
    stiff.ROBERTSON,
    stiff.VAN_DER_POL,
    stiff.OREGONATOR,
    stiff.PLEIADES,
    stiff.RING_MODULATOR,
    stiff.BEAM,
    AMPLIFIER,
)
