"""Energy, losses and supply of belts, strips, cranks, linkages, planetary stages and vehicles."""

from collections.abc import Iterator

import numpy as np
from library_rigs import MESH, STAGE
from power_terms import Energy, Motion, Power, bounded

import lumped as lp
from lumped.components import cam_follower, gravity, linkages, tyre, vehicle, winding
from lumped.components.engines import crank
from lumped.components.gearing import belts, harmonic_drive, planetary_stage, planets
from lumped.components.loads import hoist
from lumped.components.shafts import cardan


def strip_energy(at: Motion) -> complex:
    return at.p["c"] * at.rel(at.q) ** 2 / 2 if at.rel(at.q).real > 0 else 0.0


def strip_heat(at: Motion) -> float:
    tension = at.p["c"] * max(0.0, at.rel(at.q))
    return np.clip(at.p["d"] * at.rel(at.v), -tension, tension) * at.rel(at.v)


def strands(at: Motion) -> Iterator[tuple[complex, complex]]:
    """Elastic tension of each strand of a belt if it pulls, and its rate of stretch."""
    p = at.p
    c = p["EA"] / np.sqrt(p["distance"] ** 2 - (p["r_a"] - p["r_b"]) ** 2)
    by_load, rate = (
        p["r_a"] * (y["flange_a"] - y["support"]) - p["r_b"] * (y["flange_b"] - y["support"])
        for y in (at.q, at.v)
    )
    for side in (1, -1):
        pull = p["F_0"] + side * c * by_load
        yield (pull if pull.real > 0 else 0.0), side * rate


def belt_energy(at: Motion) -> complex:
    p = at.p
    c = p["EA"] / np.sqrt(p["distance"] ** 2 - (p["r_a"] - p["r_b"]) ** 2)
    return sum(pull**2 for pull, _ in strands(at)) / (2 * c)


def belt_heat(at: Motion) -> float:
    return sum(np.clip(at.p["d"] * rate, -pull, pull) * rate for pull, rate in strands(at))


def hoisted(at: Motion) -> tuple[complex, complex, complex]:
    """Stretch of the rope of a hoist, its rate, and its free length."""
    wound, rate = (at.p["r"] * y["drum"] for y in (at.q, at.v))
    return wound - at.q["load"], rate - at.v["load"], at.p["l_0"] - wound


def rope_energy(at: Motion) -> complex:
    e, _, length = hoisted(at)
    stretch = at.p["EA"] * e**2 / (2 * length) if e.real > 0 else 0.0
    return stretch - at.p["m_l"] * at.p["g"] * length**2 / 2


def rope_heat(at: Motion) -> float:
    e, rate, length = hoisted(at)
    tension = at.p["EA"] * max(0.0, e) / length
    return np.clip(at.p["D"] / length * rate, -tension, tension) * rate


def coil_radius(at: Motion) -> complex:
    turns = (at.q["flange"] - at.q["tangent"]) / (2 * np.pi)
    return at.p["r"] + at.p["h"] / at.p["fill"] * turns


def coil_energy(at: Motion) -> complex:
    J = np.pi * at.p["rho"] * at.p["b"] * at.p["fill"] / 2 * (coil_radius(at) ** 4 - at.p["r"] ** 4)
    return J * at.v["flange"] ** 2 / 2


def strip_brought_in(at: Motion) -> float:
    """Kinetic energy of the strip that enters, with the speed of the coil's surface."""
    p, R = at.p, coil_radius(at)
    mass_flow = p["rho"] * p["b"] * p["h"] * R * (at.v["flange"] - at.v["tangent"])
    return mass_flow * (R * at.v["flange"]) ** 2 / 2


def in_plane(angle: complex) -> np.ndarray:
    return np.array([np.cos(angle), np.sin(angle)])


def frame(at: dict[str, complex]) -> np.ndarray:
    return np.array([at["frame_x"], at["frame_y"]])


def crank_slider(at: Motion) -> complex:
    """Energy of the slider and of the rod by the motion of its own centre, and their weights."""
    p, along = at.p, in_plane(at.p["axis"])
    angle, w = at.q["flange"] + p["phase"], at.v["flange"]
    pin, v_pin = p["r"] * in_plane(angle), p["r"] * w * in_plane(angle + np.pi / 2)
    s, v = (y["slider"] - frame(y) @ along for y in (at.q, at.v))
    end = s * along + p["e"] * in_plane(p["axis"] + np.pi / 2)
    rod, v_rod = end - pin, v * along - v_pin
    w_rod = (rod[0] * v_rod[1] - rod[1] * v_rod[0]) / p["L"] ** 2
    mid, v_mid = (
        frame(y) + z for y, z in ((at.q, pin + p["k"] * rod), (at.v, v_pin + p["k"] * v_rod))
    )
    end, v_end = frame(at.q) + end, frame(at.v) + v * along
    moving = p["m_rod"] * v_mid @ v_mid + p["J_rod"] * w_rod**2 + p["m"] * v_end @ v_end
    return moving / 2 - p["g"] * in_plane(p["down"]) @ (p["m_rod"] * mid + p["m"] * end)


def rotating_mass(at: Motion) -> complex:
    p, angle = at.p, at.q["flange"] + at.p["phase"]
    place = frame(at.q) + p["r"] * in_plane(angle)
    v = frame(at.v) + p["r"] * at.v["flange"] * in_plane(angle + np.pi / 2)
    moving = p["m"] * v @ v + p["J"] * at.v["flange"] ** 2
    return moving / 2 - p["g"] * in_plane(p["down"]) @ (p["m"] * place)


def working(at: Motion) -> float:
    """Shape of a beta function, the greatest value 1."""
    p, v = at.p, at.v["flange"] - at.v["support"]
    z = (at.q["flange"] - at.q["support"] + 10) / 20
    top = p["p"] / (p["p"] + p["q"])
    shape = (z / top) ** p["p"] * ((1 - z) / (1 - top)) ** p["q"]
    force = p["forward"] if v > 0 else p["backward"]
    return v * bounded(v, p["v_0"]) * force * shape


def downhill_and_wind(at: Motion) -> float:
    p, v = at.p, at.v["coupling"]
    drag = p["rho"] / 2 * p["cd"] * p["A"] * (v - p["v_wind"]) * abs(v - p["v_wind"])
    return -v * (drag + p["m"] * p["g"] * np.sin(np.arctan(p["inclination"])))


def rolling_resistance(at: Motion) -> float:
    p, v = at.p, at.v["coupling"]
    level = np.cos(np.arctan(p["inclination"]))
    return p["cr"] * p["m"] * p["g"] * level * bounded(v, p["v_reg"]) * v


def plane_length(at: Motion) -> complex:
    return np.sqrt((at.q["b_x"] - at.q["a_x"]) ** 2 + (at.q["b_y"] - at.q["a_y"]) ** 2)


def plane_elastic(at: Motion) -> complex:
    return at.p["c"] * (plane_length(at) - at.p["length0"]) ** 2 / 2


def plane_viscous(at: Motion) -> float:
    stretching = sum(
        (at.q[f"b_{i}"] - at.q[f"a_{i}"]) * (at.v[f"b_{i}"] - at.v[f"a_{i}"]) for i in "xy"
    )
    return at.p["d"] * (stretching / plane_length(at)) ** 2


def bar_energy(at: Motion) -> complex:
    """By the velocities of both ends, which say how fast it turns and where its centre goes."""
    p, k = at.p, at.p["k"]
    v = [(1 - k) * at.v[f"a_{i}"] + k * at.v[f"b_{i}"] for i in "xy"]
    y = (1 - k) * at.q["a_y"] + k * at.q["b_y"]
    turning = sum((at.v[f"b_{i}"] - at.v[f"a_{i}"]) ** 2 for i in "xy") / p["length"] ** 2
    return (p["m"] * (v[0] ** 2 + v[1] ** 2) + p["J"] * turning) / 2 + p["m"] * p["g"] * y


def tread_energy(at: Motion) -> complex:
    p = at.p
    return p["f_n"] * p["mu"] * p["B"] * p["C"] * at.x["e"] ** 2 / (2 * p["sigma"])


def tread_heat(at: Motion) -> float:
    """What the tread slips, and its damper takes."""
    p, z = at.p, at.x["e"] / at.p["sigma"]
    v, u = at.v["hub"], p["R"] * at.v["wheel"]
    V = (abs(v) + abs(u)) / 2
    x = p["B"] * abs(u - v) / V
    magic = np.sin(p["C"] * np.arctan(x - p["E"] * (x - np.arctan(x))))
    slips = p["C"] * abs(u - v) * p["B"] * z / magic
    stretched = p["T_d"] * np.exp(-((V / p["v_low"]) ** 2)) * (u - v - slips) / p["sigma"]
    return p["f_n"] * p["mu"] * p["B"] * p["C"] * (z * slips + stretched * (u - v))


def stage_energy(at: Motion) -> complex:
    p, x = at.p, at.x
    return (
        p["n"]
        * (p["c_s"] * x["s_s"] ** 2 + p["c_r"] * x["s_r"] ** 2 + p["J_p"] * x["w_p"] ** 2)
        / 2
    )


def stage_heat(at: Motion) -> float:
    p, v = at.p, at.v
    r_s, r_r = p["r_s"], p["ratio"] * p["r_s"]
    rolled = (r_r - r_s) / 2 * (at.x["w_p"] - v["carrier"])
    at_sun = r_s * (v["sun"] - v["carrier"]) + rolled
    at_ring = r_r * (v["ring"] - v["carrier"]) - rolled
    return p["n"] * (p["d_s"] * at_sun**2 + p["d_r"] * at_ring**2)


def cardan_twist(at: Motion) -> complex:
    """Ends of the shaft by the tangents of both forks, in the turn of each flange."""
    p = at.p
    x, y = at.q["flange_a"] + p["phase"], at.q["flange_b"] + p["phase"] + p["psi"]
    near = x + along_turn(x, np.tan(x) / np.cos(p["beta_a"]))
    # fork b is a right angle further at both of its sides
    far = y + along_turn(y, np.tan(y) / np.cos(p["beta_b"]))
    return far - p["psi"] - near


def along_turn(x: complex, tangent: complex) -> complex:
    """What an angle with this tangent is ahead of x, less than a right angle."""
    return np.arctan((tangent - np.tan(x)) / (1 + tangent * np.tan(x)))


def splines(at: Motion) -> complex:
    """Work up to a twist by the areas below the three lines."""
    p, x = at.p, at.x["phi_rel"] * np.sign(at.x["phi_rel"].real)
    a = p["T1"] / p["K1"]
    b = a + (p["T2"] - p["T1"]) / p["K2"]
    if x.real < a:
        return p["K1"] * x**2 / 2
    if x.real < b:
        return p["T1"] * a / 2 + (p["T1"] + p["K2"] * (x - a) / 2) * (x - a)
    work = p["T1"] * a / 2 + (p["T1"] + p["T2"]) * (b - a) / 2
    return work + (p["T2"] + p["K3"] * (x - b) / 2) * (x - b)


def follower(at: Motion) -> complex:
    """Kinetic energy, and work against the preloaded spring."""
    p, s = at.p, at.q["follower"]
    return p["m"] * at.v["follower"] ** 2 / 2 + (p["F_0"] + p["c"] * s / 2) * s


def varied(mean: float, angle: complex) -> complex:
    return mean * (1 + sum(share * np.cos(k * angle + p) for k, share, p in MESH))


def planet_energy(at: Motion) -> complex:
    """Elastic energy of the meshes of one planet, and its kinetic energy."""
    p, q, v, x = at.p, at.q, at.v, at.x
    elastic = varied(p["c_s"], 20 * (q["sun"] - q["carrier"]) + p["gamma_s"]) * x["s_s"] ** 2
    elastic += p["c_r"] * x["s_r"] ** 2
    a = p["r_s"] * (20 + 25) / 20 / np.cos(p["alpha"])
    across = np.array([v["carrier_x"], v["carrier_y"]])
    if "s_radial" in x:
        elastic += p["c_b"] * (x["s_radial"] ** 2 + x["s_tangential"] ** 2)
        velocity = np.array([x["v_radial"], x["v_tangential"]])
    else:
        velocity = across + a * v["carrier"] * in_plane(p["psi"] + np.pi / 2)
    return (elastic + p["m"] * velocity @ velocity + p["J"] * x["w_p"] ** 2) / 2


def planet_heat(at: Motion) -> float:
    p, rates = at.p, at.rates
    meshes = p["d_s"] * rates["s_s"] ** 2 + p["d_r"] * rates["s_r"] ** 2
    if "s_radial" in rates:
        meshes += p["d_b"] * (rates["s_radial"] ** 2 + rates["s_tangential"] ** 2)
    return meshes


def two_planets(at: Motion) -> Iterator[tuple[complex, ...]]:
    """Deflections of the meshes of two opposite planets, and yields of their bearings.

    What is no state follows from the sum of both deflections, which the spin does not change.
    """
    x, alpha = at.x, at.p["alpha"]
    common = None
    for i, psi in enumerate((0.0, np.pi)):
        own = {
            name: x.get(f"planets[{i}].{name}")
            for name in ("s_s", "s_r", "s_radial", "s_tangential")
        }
        across = 0.0
        if "at_sun.x" in x:
            for name, way in (("sun", psi - alpha), ("ring", psi + alpha)):
                across += [x[f"at_{name}.x"], x[f"at_{name}.y"]] @ in_plane(way + np.pi / 2)
            carried = [x["at_carrier.x"], x["at_carrier.y"]] @ in_plane(psi + np.pi / 2)
            across -= 2 * np.cos(alpha) * carried
        if common is None:
            common = own["s_s"] + own["s_r"] - across
            common += 2 * np.cos(alpha) * (own["s_tangential"] or 0.0)
        elif own["s_radial"] is None:
            own["s_r"] = common + across - own["s_s"]
        else:
            left = common + across - own["s_s"] - own["s_r"]
            own["s_tangential"] = -left / (2 * np.cos(alpha))
        yield tuple(own[name] or 0.0 for name in own)


def stage_one_by_one(at: Motion) -> complex:
    p, x = at.p, at.x
    a = p["r_s"] * (20 + 25) / 20 / np.cos(p["alpha"])
    total = 0.0
    for i, (s_s, s_r, out, along) in enumerate(two_planets(at)):
        total += STAGE["c_s"][i] * s_s**2 + STAGE["c_r"] * s_r**2
        total += 1.5 * (out**2 + along**2) + p["J_p"] * x[f"planets[{i}].w_p"] ** 2
        if "at_sun.x" in x:
            velocity = [x[f"planets[{i}].v_radial"], x[f"planets[{i}].v_tangential"]]
        else:
            velocity = [0.0, a * at.v["carrier"]]
        total += p["m_p"] * np.dot(velocity, velocity)
    for name in ("sun", "carrier", "ring"):
        if "at_sun.x" in x:
            y, v = ([x[f"at_{name}.{d}{e}"] for e in "xy"] for d in ("", "v_"))
            total += p[f"c_{name}"] * np.dot(y, y) + p[f"m_{name}"] * np.dot(v, v)
    return total / 2


def stage_one_by_one_heat(at: Motion) -> float:
    h = 1e-30
    moved = {name: at.x[name] + 1j * h * at.rates[name] for name in at.x}
    pairs = two_planets(Motion(at.p, at.q, at.v, at.a, moved, at.rates))
    lost = sum(STAGE["d_s"] * (s_s.imag / h) ** 2 for s_s, *_ in pairs)
    for name in ("sun", "carrier", "ring"):
        if "at_sun.x" in at.x:
            v = [at.x[f"at_{name}.v_{e}"] for e in "xy"]
            lost += at.p[f"d_{name}"] * np.dot(v, v)
    return lost


def swinging(at: Motion) -> complex:
    p = at.p
    height = p["R"] * np.sin(at.q["flange"] + p["phi0"])
    return (p["J"] + p["m"] * p["R"] ** 2) * at.v["flange"] ** 2 / 2 + p["m"] * p["g"] * height


def lowered(at: Motion) -> float:
    return -at.p["f"] * at.p["R"] * np.cos(at.q["flange"] + at.p["phi0"]) * at.v["flange"]


STORED: dict[type[lp.Component], Energy] = {
    hoist.HoistRope: rope_energy,
    belts.Belt: belt_energy,
    cam_follower.CamFollower: follower,
    cardan.CardanShaft: lambda at: at.p["c"] * cardan_twist(at) ** 2 / 2,
    harmonic_drive.HarmonicDrive: splines,
    planetary_stage.ElasticPlanetary: stage_energy,
    planetary_stage.PlanarPlanetaryStage: stage_one_by_one,
    planetary_stage.PlanetaryStage: stage_one_by_one,
    planets.Planet: planet_energy,
    planets.PlanetOnBearing: planet_energy,
    linkages.Bar: bar_energy,
    linkages.PlaneSpring: plane_elastic,
    tyre.Tyre: tread_energy,
    gravity.SwingingMass: swinging,
    crank.CrankSlider: crank_slider,
    crank.RotatingMass: rotating_mass,
    vehicle.Vehicle: lambda at: (
        (at.p["m"] + at.p["J"] / at.p["R"] ** 2) * at.v["coupling"] ** 2 / 2
    ),
    winding.Coil: coil_energy,
    winding.Strip: strip_energy,
}


DISSIPATED: dict[type[lp.Component], Power] = {
    hoist.HoistRope: rope_heat,
    belts.Belt: belt_heat,
    planetary_stage.ElasticPlanetary: stage_heat,
    planetary_stage.PlanarPlanetaryStage: stage_one_by_one_heat,
    planetary_stage.PlanetaryStage: stage_one_by_one_heat,
    planets.Planet: planet_heat,
    planets.PlanetOnBearing: planet_heat,
    linkages.PlaneSpring: plane_viscous,
    tyre.Tyre: tread_heat,
    crank.StrokeLoad: working,
    vehicle.Vehicle: rolling_resistance,
    winding.Strip: strip_heat,
}


SUPPLIED: dict[type[lp.Component], Power] = {
    gravity.Weight: lowered,
    vehicle.Vehicle: downhill_and_wind,
    winding.Coil: strip_brought_in,
}
