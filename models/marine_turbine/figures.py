"""Figures of the marine turbine."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.models.marine_turbine.drive import BLADES, LBF_IN, RPM, MarineTurbine
from lumped.models.marine_turbine.scenes import response, run_up
from lumped.models.panels import panels

# 1/min and lbf in, points of figure 8.10-5 as digitised in the source
# fmt: off
FIGURE = (
    (14.48, 69149), (19.05, 132979), (21.02, 180851), (24.56, 324468), (26.95, 468085),
    (28.11, 595745), (29.13, 739362), (30.08, 898936), (30.76, 1053191), (31.17, 1218085),
    (31.65, 1367021), (32.19, 1574468), (32.81, 1856383), (33.08, 2095745), (33.28, 2345745),
    (33.62, 2585106), (33.90, 2803191), (34.10, 3042553), (34.37, 3319149), (34.71, 3585106),
    (34.99, 3824468), (35.12, 3984043), (35.46, 4148936), (36.14, 3984043), (36.28, 3776596),
    (36.48, 3585106), (36.82, 3319149), (37.10, 3122340), (37.30, 2877660), (37.71, 2563830),
    (38.19, 2297872), (38.46, 2117021), (39.00, 1851064), (39.68, 1643617), (40.64, 1436170),
    (41.80, 1218085), (43.70, 1021277), (45.20, 893617), (46.91, 797872), (48.34, 744681),
    (50.04, 696809), (51.88, 659574), (53.72, 622340), (56.65, 569149), (58.89, 553191),
    (61.21, 521277), (64.00, 500000), (67.88, 473404), (72.58, 454787), (75.72, 457447),
    (78.78, 425532), (82.32, 425532), (87.50, 414894), (91.45, 409574), (97.11, 409574),
)
# fmt: on


@cache
def _steady() -> lp.vibration.OrderResponse:
    return response(np.arange(1.0, 100.1, 0.1))


def draw_shapes() -> Any:
    modes = lp.modes(lp.assemble(MarineTurbine()))
    return lp.vibration.mass_elastic(modes, shaft="propeller.phi").holzer(0).plot()


def draw_campbell() -> Any:
    speeds, system = np.linspace(0.0, 100.0, 5) * RPM, lp.assemble(MarineTurbine())
    return lp.campbell(system, speeds=speeds, orders={"blades": BLADES}).plot()


def draw_shafts() -> Any:
    return _steady().plot()


def draw_run_up() -> Any:
    run = run_up(grid=60_000)
    return lp.vibration.order_tracks(run, "shaft.tau", shaft="propeller.phi", turns=4).plot()


def draw_torque() -> Figure:
    steady = _steady()
    figure, axis = panels(x="speed of the propeller, 1/min", y=["vibratory torque, kN.m"])
    size = steady.magnitude("shaft.tau", BLADES) / 1e3
    axis.plot(steady.rpm, size, label="computed")
    rpm, torque = np.array(FIGURE).T
    axis.plot(rpm, torque * LBF_IN / 1e3, "o", markersize=4, label="figure 8.10-5, digitised")
    axis.set(xlim=(0, 100), ylim=(0, None))
    axis.legend()
    return figure
