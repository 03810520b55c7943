"""Balance of the pilger mill by the equations of its source, as restored."""

import numpy as np
from pilger_turns import L1, E, L, R

from lumped.models.pilger_mill.stand import SETS, SPEED


class ByHand:
    """F1 and F2 of a set by equations (1) to (30), as restored, at 1440 angles."""

    def __init__(self, name):
        p, w, f = SETS[name], SPEED[name], np.radians(np.arange(1440) / 4)
        t, t1 = np.arcsin((R * np.sin(f) + E) / L), np.arcsin(R * np.cos(f) / L1)
        V = w * R * (np.sin(f) + np.tan(t) * np.cos(f))
        V1 = -w * R * (np.cos(f) + np.tan(t1) * np.sin(f))
        bow, bow1 = R * np.cos(f) ** 2 / (L * np.cos(t) ** 3), R * np.sin(f) ** 2 / L1
        bow1 = bow1 / np.cos(t1) ** 3
        a = w**2 * R * (np.cos(f) - np.tan(t) * np.sin(f) + bow)
        a1 = w**2 * R * (np.sin(f) - np.tan(t1) * np.cos(f) + bow1)
        turn, turn1 = w * R * np.cos(f) / (L * np.cos(t)), -w * R * np.sin(f) / (L1 * np.cos(t1))
        xi = w**2 * R / L * (np.sin(t) * bow - np.sin(f) / np.cos(t))
        xi1 = w**2 * R / L1 * (np.sin(t1) * bow1 - np.cos(f) / np.cos(t1))
        ends = -np.sqrt((L + R) ** 2 - E**2), -np.sqrt((L - R) ** 2 - E**2)
        s = np.clip((-(R * np.cos(f) + L * np.cos(t)) - ends[0]) / (ends[1] - ends[0]), 0, 1)
        q = p["al"] / (p["al"] + p["be"])
        shape = (s / q) ** p["al"] * ((1 - s) / (1 - q)) ** p["be"]
        load = p["T_f"] * np.where(V > 0, 1.0, p["back"]) * shape * np.abs(V) / (w * R) + p["M0"]
        rods, rods1 = 2 * p["m_rod"], 2 * p["m_rod_1"]
        inertia = (p["m1"] + 1100 * (0.21 / 0.19) ** 2 + rods) * V * a + rods1 * V1 * a1
        slender = 1 / 12 - 0.05**2
        inertia += rods * slender * L**2 * turn * xi + rods1 * slender * L1**2 * turn1 * xi1
        self.torque, self.more = inertia / w + load, V1 * a1 / w
        self.along, self.up, self.rod = -(p["m1"] + 0.45 * rods) * a, -a1, 0.45 * rods1
        self.x, self.y = w**2 * np.cos(f), w**2 * np.sin(f)
        self.turning = (p["m_pin"] + 0.55 * (rods + rods1)) * R

    def force(self, m2, U):
        pull = self.turning - 4 * U
        up = (m2 + self.rod) * self.up - pull * self.y
        return np.hypot(self.along - pull * self.x, up).max()

    def fluctuation(self, m2):
        return np.ptp(self.torque + m2 * self.more) / 0.96

    def best_sectors(self, m2):
        return golden(lambda U: self.force(m2, U), 2500.0, 3800.0)

    def curves(self):
        """Force and torque without counterweight and sectors, and by each of them."""
        none = np.zeros_like(self.x)
        force = [
            [self.along - self.turning * self.x, self.rod * self.up - self.turning * self.y],
            [none, self.up],
            [4 * self.x, 4 * self.y],
        ]
        return np.array(force), np.array([self.torque, self.more, none]) / 0.96


def golden(cost, a, b):
    """Least of a convex function by golden section, to rounding for a kink."""
    ratio = (np.sqrt(5) - 1) / 2
    c, d = b - ratio * (b - a), a + ratio * (b - a)
    low, high = cost(c), cost(d)
    for _ in range(52):
        if low < high:
            b, d, high = d, c, low
            c = b - ratio * (b - a)
            low = cost(c)
        else:
            a, c, low = c, d, high
            d = a + ratio * (b - a)
            high = cost(d)
    return (a + b) / 2
