"""Matrices of a planetary stage in its plane, written here with vectors of the lines of action."""

import numpy as np


def in_plane(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def stiffness(s, c_sun, c_carrier, c_ring, pins=True):
    """Springs of the stage: stiffnesses, and what each is stretched by and already was.

    Unknowns are x, y and angle of sun, carrier and ring, then of each planet, whose x and y are
    those of its centre.
    """
    n = len(s["psi"])
    r_s, r_p = s["r_s"], s["r_s"] * s["z_p"] / s["z_s"]
    r_r, a = r_s + 2 * r_p, (r_s + r_p) / np.cos(s["alpha"])
    rows, values, errors = [], [], []

    def add(c, error=0.0, **parts):
        row = np.zeros(9 + 3 * n)
        for name, part in parts.items():
            at = {"sun": 0, "carrier": 3, "ring": 6}.get(name)
            at = 9 + 3 * int(name[1:]) if at is None else at
            row[at : at + 3] = part
        rows.append(row)
        values.append(c)
        errors.append(error)

    for name, c in (("sun", c_sun), ("carrier", c_carrier), ("ring", c_ring)):
        add(c, **{name: (1, 0, 0)})
        add(c, **{name: (0, 1, 0)})
    for i, psi in enumerate(s["psi"]):
        out, along = in_plane(psi), in_plane(psi + np.pi / 2)
        me, each = f"p{i}", {k: s[k][i] for k in ("c_s", "c_r", "c_b", "pin_t", "pin_r")}
        for other, r, sign, way in (
            ("sun", r_s, 1, psi - s["alpha"]),
            ("ring", r_r, -1, psi + s["alpha"]),
        ):
            line = in_plane(way + np.pi / 2)  # in which the central wheel pushes its flank
            push = {other: (*line, r), me: (*-line, sign * r_p)}
            add(each["c_s" if other == "sun" else "c_r"], **push)
        for way, turned, error in ((out, 0.0, each["pin_r"]), (along, a, each["pin_t"])):
            add(each["c_b"], error, carrier=(*way, turned), **{me: (*-way, 0)})
    return np.array(rows), np.array(values), np.array(errors)


def static(s, torque, c_sun, c_carrier, c_ring):
    """Mesh forces at the sun with a torque on it, ring and carrier held."""
    rows, c, errors = stiffness(s, c_sun, c_carrier, c_ring)
    free = [i for i in range(rows.shape[1]) if i not in (5, 8)]
    load = np.zeros(rows.shape[1])
    load[2] = torque
    K = rows.T @ (c[:, None] * rows)
    pull = rows.T @ (c * errors)
    q = np.zeros(rows.shape[1])
    q[free] = np.linalg.solve(K[np.ix_(free, free)], (load - pull)[free])
    return (c * (rows @ q + errors))[6::4]
