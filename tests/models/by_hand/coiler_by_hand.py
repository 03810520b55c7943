"""Carrousel coiler by hand: loads of a run, gears, bearings and turret, with numpy."""

import numpy as np

T, r, R, h, b, rho = 80e3, 0.305, 1.0, 1e-3, 1.25, 7850.0
v, up, down, ratio, eta, g = 20.0, 1.0, 1.25, 1.354, 0.92, 9.80665
DEG = np.pi / 180
NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)


def wind():
    """Weights, s, motor speed and torque into the gears at Gauss points of the parts of a run."""
    length = np.pi * (R**2 - r**2) / h
    t1, t3 = v / up, v / down
    t2 = (length - v * t1 / 2 - v * t3 / 2) / v
    parts = []
    for start, last, speed, a in (
        (0, t1, 0, up),
        (v * t1 / 2, t2, v, 0),
        (length - v * t3 / 2, t3, v, -down),
    ):
        t = last * (NODES + 1) / 2
        s, speed = start + speed * t + a * t**2 / 2, speed + a * t
        radius = np.sqrt(r**2 + h * s / np.pi)
        dw = a / radius - h * speed**2 / (2 * np.pi * radius**3)
        mass = np.pi * rho * b * (radius**2 - r**2)
        J = 500 + mass * (radius**2 + r**2) / 2
        friction = 0.003 * 0.2 * np.hypot(T, g * (2500 + mass))
        at_mandrel = T * radius + 300e6 * b * h**2 / 4 + friction + J * dw
        assert at_mandrel.min() > 0  # the motor drives
        parts.append((last * WEIGHTS / 2, ratio * speed / radius, at_mandrel / (eta * ratio)))
    return map(np.concatenate, zip(*parts, strict=True))


def end_of_steady():
    """Torque into the gears just before the line slows down, N.m: its peak."""
    radius = np.sqrt(R**2 - h * v**2 / (2 * down) / np.pi)
    mass = np.pi * rho * b * (radius**2 - r**2)
    dw = -h * v**2 / (2 * np.pi * radius**3)
    J = 500 + mass * (radius**2 + r**2) / 2
    friction = 0.003 * 0.2 * np.hypot(T, g * (2500 + mass))
    return (T * radius + 93.75 + friction + J * dw) / (eta * ratio)


def dynamic_factor():
    """Power at the end of the acceleration over the static power (3.3) there."""
    radius = np.sqrt(r**2 + h * v**2 / (2 * up) / np.pi)
    mass = np.pi * rho * b * (radius**2 - r**2)
    J = 500 + mass * (radius**2 + r**2) / 2
    static = T * radius + 93.75 + 0.003 * 0.2 * np.hypot(T, g * (2500 + mass))
    dw = up / radius - h * v**2 / (2 * np.pi * radius**3)
    return (static + (J + eta * 600 * ratio**2) * dw) / static


def stage():
    """Helix, pressure angle, radii, width and both contact ratios of 30/41 teeth, module 16."""
    centre = 0.58
    beta = np.arccos(0.016 * 71 / 2 / centre)
    alpha = np.arctan(np.tan(20 * DEG) / np.cos(beta))
    radii = 0.016 * np.array([30, 41]) / np.cos(beta) / 2
    arms = np.sqrt((radii + 0.016) ** 2 - (radii * np.cos(alpha)) ** 2)
    pitch = np.pi * 0.016 / np.cos(beta) * np.cos(alpha)
    width = 0.7 * 2 * radii[0]
    ratios = (arms.sum() - centre * np.sin(alpha)) / pitch, width * np.sin(beta) / (np.pi * 0.016)
    return beta, alpha, radii, width, *ratios


def numbers():
    """Value of each row of the parts, and the digit to which it is compared."""
    share, w, torque = wind()
    turned = share @ w
    equivalent = (share @ (torque ** (10 / 3) * w) / turned) ** 0.3
    mean, peak = turned / share.sum(), end_of_steady()
    beta, alpha, radii, width, eps, overlap = stage()
    base = np.arctan(np.tan(beta) * np.cos(alpha))
    Y_eps = 0.25 + 0.75 * np.cos(base) ** 2 / eps
    Y_beta = max(1 - min(overlap, 1) * beta / DEG / 120, 0.75)
    u, size = 41 / 30, width * 2 * radii[0]
    root = 2 * 1.4 * peak / size / 0.016 * 2.52 * 1.625 * Y_eps * Y_beta
    Z_H = np.sqrt(2 * np.cos(base) / (np.tan(alpha) * np.cos(alpha) ** 2))
    Z_E = np.sqrt(2.06e11 / (2 * np.pi * (1 - 0.09)))
    line = 2 * 1.4 * peak / (size * 2 * radii[0]) * (u + 1) / u
    flank = Z_E * Z_H * np.sqrt(np.cos(beta) / eps * line)
    least = 2 * 1.4 * peak * np.cos(12 * DEG) ** 2 * 2.52 * 1.625 * Y_eps  # Y_beta = 1
    least = (least / (0.7 * 30**2 * 400e6 / 1.4)) ** (1 / 3)
    force = 1 / radii[0]
    radial = np.hypot(force / 2, force * np.tan(alpha) / 2 + np.tan(beta) / 0.8)
    axial = force * np.tan(beta)
    load = 0.67 * radial + 3.0 * axial if axial > 0.33 * radial else radial + 2.0 * axial
    hours = 1e6 * (2.0e6 / (1.5 * load * equivalent)) ** (10 / 3) / (60 * mean * 30 / np.pi)
    wrap = 4 * np.sqrt(2) * 80
    rho_ = np.arctan(0.1)
    turret = turret_torque() / 1e3
    return {
        "greatest motor power over that of (3.3) there": (dynamic_factor(), 1e-6),
        "ratio of the reducer, high gear": (1.354, 1e-9),
        "helix angle of the reducer": (beta / DEG, 1e-9),
        "helix angle of the gear seat": (np.arccos(0.016 * 152 / 2.5) / DEG, 1e-9),
        "transverse contact ratio, high gear": (eps, 1e-9),
        "overlap ratio, high gear": (overlap, 1e-9),
        "torque into the gears, peak": (peak / 1e3, 1e-5),
        "torque into the gears, equivalent": (equivalent / 1e3, 1e-5),
        "mean speed of the motor": (mean * 30 / np.pi, 1e-4),
        "least module by the root, (3.25)": (1e3 * least, 1e-5),
        "contact safety of the high gear under the peak torque": (1300e6 / flank, 1e-6),
        "root safety of the high gear under the peak torque": (400e6 / root, 1e-6),
        "life of the worse pinion bearing": (hours, 1.0),
        "torque of the coupling": (1.5 * 1.08 * T / (eta * ratio) / 1e3, 1e-6),
        "nominal torque of the coupling": (112.0, 1e-9),
        "turret drive with its mass, least torque of half a turn": (turret.min(), 1e-4),
        "turret drive with its mass, greatest torque of half a turn": (turret.max(), 1e-4),
        "pull of the cylinder that expands the mandrel": (wrap * np.tan(10 * DEG + rho_), 1e-9),
        "pull of the cylinder that holds the mandrel": (wrap * np.tan(10 * DEG - rho_), 1e-9),
    }


def turret_torque(t=None):
    """Driving torque of the turret over the 12 s of its half turn, N.m, clockwise.

    As drawn: x to the right, y up, winding clockwise over the top. Speeds by differences of angles.
    """
    t = np.linspace(0, 12, 601)[1:-1] if t is None else t
    top = np.pi / 9

    def turned(t):
        left = 12 - t
        ends = np.where(left < 3, np.pi - top * left**2 / 6, top * (t - 1.5))
        return np.where(t < 3, top * t**2 / 6, ends)

    def state(t):
        """Axis, radius, contact and angle wound absolutely, from the length of strip."""
        theta = turned(t)
        axis = 1.25 * np.array([-np.cos(theta), np.sin(theta)])
        to_roll = np.array([[-4.0], [1.8]]) - axis
        D2 = (to_roll**2).sum(axis=0)
        start = np.pi * (0.45**2 - r**2) / h + np.sqrt(2.75**2 + 1.8**2 - 0.45**2)
        wound = start + 5.0 * (5.0 + t) - np.sqrt(D2 - 0.5**2)
        for _ in range(60):  # the free length depends on the radius a little
            radius = np.sqrt(r**2 + h * wound / np.pi)
            wound = start + 5.0 * (5.0 + t) - np.sqrt(D2 - radius**2)
        psi = np.unwrap(np.arctan2(to_roll[1], to_roll[0]) - np.arccos(radius / np.sqrt(D2)))
        angle = 2 * np.pi * (radius - r) / h - psi  # clockwise
        return theta, axis, radius, psi, angle

    theta, axis, radius, psi, _ = state(t)
    e = 1e-3
    fine = np.linspace(-1e-3, 1e-3, 3)
    angles = np.array([state(t + s)[4] for s in fine])
    dw = np.diff(angles, 2, axis=0)[0] / e**2
    contact = axis + radius * np.array([np.cos(psi), np.sin(psi)])
    pull = np.array([[-4.0], [1.8]]) - contact
    pull = T * pull / np.hypot(*pull)
    mass = np.pi * rho * b * (radius**2 - r**2)
    J = 500 + mass * (radius**2 + r**2) / 2
    turning = np.where(t < 3, top / 3, np.where(t > 9, -top / 3, 0.0))
    spin = 2 * (T * radius + J * dw)  # sun and mandrel on the turret, 1 + k
    other = 2 * 500 * 2 * turning  # mandrel 2 turns twice as fast as the turret, its sun stands
    tension = axis[0] * pull[1] - axis[1] * pull[0]
    weight = mass * g * 1.25 * np.cos(theta)
    return spin + other + tension + weight + (120e3 + mass * 1.25**2) * turning
