"""Figures of the carrousel coiler."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from lumped.models.carrousel_coiler import drive, scenes, sizing
from lumped.models.carrousel_coiler.changeover import changeover, plan
from lumped.models.carrousel_coiler.shafts import jam
from lumped.models.carrousel_coiler.turret import half_turn
from lumped.models.panels import panels


def draw_winding_run() -> Figure:
    run = drive.winding(grid=1000, rtol=1e-9)
    motor = sizing.choose_motor()
    torque, w = run["drive.rotor.flange_a.tau"], run["drive.rotor.w"]
    labels = ("line speed, m/s", "speed, rad/s", "radius, m", "inertia, 10$^3$ kg m$^2$")
    figure, ((line, speeds), (radius, inertia), (torques, powers)) = panels(
        3, 2, size=(10, 8), x="time, s", y=(*labels, "torque, kN m", "power, MW")
    )
    figure.suptitle("Strip of 1 mm wound at 20 m/s under 80 kN in high gear")
    line.plot(run.t, run["drive.coil.w"] * run["drive.coil.R"], label="strip")
    speeds.plot(run.t, w, label="motor")
    speeds.plot(run.t, run["drive.coil.w"], label="mandrel")
    speeds.axhline(motor.base, color="grey", linestyle="--", label="base speed")
    radius.plot(run.t, run["drive.coil.R"], label="coil")
    J = run["drive.coil.J"] / 1e3
    inertia.plot(run.t, J + scenes.J_EMPTY / 1e3, label="at the mandrel, with rotor")
    inertia.plot(run.t, J, "--", label="coil alone")
    limit = motor.power / np.maximum(w, motor.base)
    torques.plot(run.t, torque / 1e3, label="motor")
    torques.plot(run.t, limit / 1e3, "--", label="limit of the motor")
    powers.plot(run.t, torque * w / 1e6, label="motor")
    powers.axhline(sizing.tension_power() / 1e6, color="grey", linestyle="--", label="(3.4)")
    powers.set(xlim=(0, run.t[-1]))
    return _finish(figure)


def draw_tension_deviation() -> Figure:
    radii = np.linspace(drive.MANDREL, drive.RADIUS, 80)
    title = "Deviation of the tension without inertia compensation"
    figure, axis = panels(
        size=(8, 5), title=title, x="radius of the coil, m", y=["tension - wanted, kN"]
    )
    for v, a, label in (
        (20.0, 0.0, "20 m/s, steady"),
        (10.0, 0.0, "10 m/s, steady"),
        (0.0, 1.0, "1 m/s$^2$ from rest"),
    ):
        found = scenes.tension_deviation(radii, v, a)
        axis.plot(radii, found / 1e3, label=label)
        if v == drive.SPEED:
            text = found - drive.strip_momentum(1.0)  # over the radius, to which it is proportional
            axis.plot(radii, text / 1e3, "C0--", label="20 m/s, with w dJ/dt of (3.5)")
    axis.axhline(0.0, color="grey", linewidth=0.8)
    axis.set(xlim=(drive.MANDREL, drive.RADIUS))
    return _finish(figure)


def draw_elastic_strip() -> Figure:
    title = "Tension of 10 m of elastic strip under torque control"
    figure, axis = panels(size=(8, 5), title=title, x="time, s", y=["tension, kN"])
    for share in (0.0, 0.8, 1.0):  # swings of 6 Hz are seen as bands
        run = scenes.elastic_winding(share, grid=6000, rtol=1e-8)
        axis.plot(run.t, run["strip.T"] / 1e3, linewidth=1, label=f"{100 * share:g} % compensated")
    axis.axhline(drive.TENSION / 1e3, color="grey", linestyle="--", linewidth=0.8)
    axis.set(xlim=(0, run.t[-1]))
    return _finish(figure)


def draw_gear_map() -> Figure:
    speeds = np.sort([*np.arange(100.0, 1300, 10), 812.4, 812.5, 1199.9, 1200.1])
    title = "Tension from the empty to the full coil; dots: gear chosen for a strip"
    figure, axis = panels(size=(8, 5), title=title, x="line speed, m/min", y=["tension, kN"])
    motors = ((sizing.choose_motor(), "-", "2348 kW"), (sizing.drawn_motor(), "--", "2160 kW"))
    for motor, line, name in motors:
        for ratio, color, gear in ((drive.I_HIGH, "C0", "high"), (drive.I_LOW, "C1", "low")):
            tension = sizing.greatest_tension(motor, speeds / 60, ratio)
            axis.plot(speeds, tension / 1e3, line, color=color, label=f"{gear} gear, {name}")
    for v, T in ((1200, 80), (780, 100), (400, 110), (1080, 90)):
        axis.plot(v, T, "ok")
        gear = sizing.gear_for(v / 60, 1e3 * T) or "none"
        axis.annotate(gear, (v, T), (-5, 5), textcoords="offset points", ha="right")
    axis.set(ylim=(0, 135))
    return _finish(figure)


def draw_gear_change() -> Figure:
    run = scenes.gear_change()
    title = "Low to high gear while turning: speeds jump, momentum is kept"
    figure, axis = panels(title=title, x="time, s", y=["speed, rad/s"])
    axis.plot(run.t, run["drive.rotor.w"], label="motor")
    axis.plot(run.t, run["drive.mandrel.w"], label="mandrel")
    axis.set(xlim=(0, run.t[-1]))
    return _finish(figure)


def draw_turret() -> Figure:
    title = "Half a turn of the turret while winding at 5 m/s under 80 kN"
    labels = ("speed, rad/s", "torque of the drive, kN m", "length, m")
    figure, (speeds, torques, lengths) = panels(3, size=(8, 8), title=title, x="time, s", y=labels)
    run, still = half_turn(grid=600), half_turn(turning=False, grid=600)
    speeds.plot(run.t, run["coil.w"], label="mandrel")
    speeds.plot(still.t, still["coil.w"], ":", color="C0", label="mandrel, turret at rest")
    torques.plot(run.t, -run["held.motor.tau"] / 1e3, label="on the sun")
    torques.plot(run.t, -run["turn.flange.tau"] / 1e3, label="on the turret")
    lengths.plot(run.t, run["coil.R"], label="radius of the coil")
    lengths.plot(run.t, run["path.length"], label="strip from the roll to the coil")
    lengths.set(xlim=(0, run.t[-1]), ylim=(0, None))
    return _finish(figure)


def draw_changeover() -> Figure:
    stages, _ = plan()
    run = changeover(grid=3000, rtol=1e-8)
    title = "Mandrel 1 winds through half a turn of the turret, its strip is cut, mandrel 2 goes on"
    labels = ("speed of the strip, m/s", "torque of the motor, kN m", "torque of the turret, kN m")
    figure, (speeds, torques, turret) = panels(3, size=(9, 8), title=title, x="time, s", y=labels)
    speeds.plot(run.t, run["coil.w"] * run["coil.R"], label="mandrel 1")
    speeds.plot(run.t, run["mandrel_2.w"] * drive.MANDREL, label="mandrel 2")
    torques.plot(run.t, np.abs(run["held.motor.tau"]) / 1e3, label="sun of mandrel 1")
    torques.plot(run.t, np.abs(run["motor_2.flange.tau"]) / 1e3, label="sun of mandrel 2")
    turning = (run.t > stages.turns) & (run.t < stages.turned)
    drives = np.where(turning, -run["turn.flange.tau"] / 1e3, np.nan)
    turret.plot(run.t, drives, label="drive, while it turns")
    turret.plot(run.t, np.where(turning, np.nan, -run["turn.flange.tau"] / 1e3), label="lock")
    turret.set(xlim=(0, run.t[-1]))
    return _finish(figure)


def draw_jam() -> Figure:
    title = "Mandrel jams with 400 kN m while winding at 20 m/s"
    labels = ("torque, kN m", "speed, rad/s")
    figure, (torque, speed) = panels(2, size=(9, 6), title=title, x="time, s", y=labels)
    unlimited = {"drive.coupling.static": 1e9}
    for label, changes in (("coupling without limit", unlimited), ("coupling that slips", {})):
        run = jam(grid=3000, parameters=changes)
        torque.plot(run.t, -run["drive.shaft.tau"] / 1e3, label=f"shaft, {label}")
        speed.plot(run.t, run["drive.rotor.w"] / drive.I_HIGH, label=f"motor over ratio, {label}")
    speed.plot(run.t, run["drive.mandrel.w"], "C1:", label="mandrel, coupling that slips")
    speed.set(xlim=(0, run.t[-1]))
    return _finish(figure)


def _finish(figure: Figure) -> Figure:
    for axis in figure.axes:
        axis.legend(fontsize="small")
    return figure
