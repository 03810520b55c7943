"""Draw cascade control and a sequence of positions: ``python docs/elements/draw_control.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt

import lumped as lp
from lumped.components import (
    AngleSensor,
    CascadeControl,
    Constant,
    Gain,
    Inertia,
    PointToPoint,
    PositionSequencer,
    SpeedSensor,
    Torque,
)

FOLDER = Path(__file__).parent
J = 0.5


class Table(lp.Component):
    """A rigid table of 0.5 kg.m2 under cascade control."""

    control: CascadeControl = CascadeControl(K=8.0, v_max=3.0, k=20.0, T_i=0.3, f_max=8.0)
    drive: Torque = Torque()
    body: Inertia = Inertia(J=J)
    turns: AngleSensor = AngleSensor()
    tacho: SpeedSensor = SpeedSensor()

    def connections(self):
        """Yield the loop."""
        yield lp.connect(self.control.y, self.drive.tau)
        yield lp.connect(self.drive.flange, self.body.flange_a)
        yield lp.connect(self.body.flange_b, self.turns.flange, self.tacho.flange)
        yield lp.connect(self.turns.phi, self.control.measured)
        yield lp.connect(self.tacho.w, self.control.v_measured)


class Moved(Table):
    """The table follows a move; the gains are 0 where nothing is fed forward."""

    move: PointToPoint = PointToPoint(distance=3.0, v_max=2.0, a_max=8.0, start_time=0.1)
    v: Gain = Gain(k=1.0)
    f: Gain = Gain(k=J)

    def connections(self):
        """Yield what the control is told of the move."""
        yield from super().connections()
        yield lp.connect(self.move.s, self.control.wanted)
        yield lp.connect(self.move.v, self.v.u)
        yield lp.connect(self.move.a, self.f.u)
        yield lp.connect(self.v.y, self.control.v_feed)
        yield lp.connect(self.f.y, self.control.f_feed)


class Sent(Table):
    """The table is sent to three positions."""

    control: CascadeControl = Table.control.with_({"a": 12.0})
    order: PositionSequencer = PositionSequencer(targets=(1.5, 3.0, 0.5), tolerance=0.01, dwell=0.4)
    none: Constant = Constant(k=0.0)

    def connections(self):
        """Yield the orders."""
        yield from super().connections()
        yield lp.connect(self.order.y, self.control.wanted)
        yield lp.connect(self.turns.phi, self.order.measured)
        yield lp.connect(self.none.y, self.control.v_feed, self.control.f_feed)


def panels():
    """A figure of two panels, one above the other."""
    figure, axes = plt.subplots(2, figsize=(6, 4.2), sharex=True, layout="constrained")
    for axis in axes:
        axis.grid(color="0.9")
        axis.spines[["top", "right"]].set_visible(False)
    axes[1].set_xlabel("time, s")
    return figure, axes


def cascade_control():
    """Error and torque of a move with and without feed-forward."""
    figure, (above, below) = panels()
    for label, v, f in (
        ("nothing fed forward", 0.0, 0.0),
        ("speed", 1.0, 0.0),
        ("speed and torque", 1.0, J),
    ):
        system = lp.assemble(Moved(v=Gain(k=v), f=Gain(k=f)))
        run = lp.simulate(system, until=2.5, grid=1000)
        above.plot(run.t, run["move.s"] - run["turns.phi"], label=label)
        below.plot(run.t, run["drive.tau"])
    above.set(title="A move of 3 rad at 2 rad/s", ylabel="error, rad")
    below.set(ylabel="torque, N.m")
    above.legend(frameon=False, fontsize="small")
    figure.savefig(FOLDER / "cascade_control.png", dpi=80)
    plt.close(figure)


def position_sequencer():
    """Wanted and actual position, and speed."""
    figure, (above, below) = panels()
    run = lp.simulate(lp.assemble(Sent()), until=6.0, grid=1500)
    above.plot(run.t, run["order.y"], "--", label="wanted")
    above.plot(run.t, run["turns.phi"], label="table")
    below.plot(run.t, run["body.w"], color="C1")
    above.set(title="Positions 1.5, 3 and 0.5 rad, 0.4 s at each", ylabel="angle, rad")
    below.set(ylabel="speed, rad/s")
    above.legend(frameon=False, fontsize="small")
    figure.savefig(FOLDER / "position_sequencer.png", dpi=80)
    plt.close(figure)


if __name__ == "__main__":
    cascade_control()
    position_sequencer()
