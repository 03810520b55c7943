"""Friction elements of the reference cases."""

import numpy as np

from lumped.components import BearingFriction, Brake, Clutch, OneWayClutch, Stribeck, translation

ROTATION = {
    "bearing_friction": BearingFriction,
    "brake": Brake,
    "clutch": Clutch,
    "one_way_clutch": OneWayClutch,
}
TRANSLATION = {
    "bearing_friction": translation.SupportFriction,
    "brake": translation.Brake,
    "mass_with_stops_and_friction": translation.MassWithStopAndFriction,
}
PRESSED = {"mu": "characteristic", "cgeo": "c_geo", "fn_max": "f_max"}
PARAMETERS = {
    ("bearing_friction", False): {"table": "characteristic"},
    ("bearing_friction", True): {"table": "characteristic"},
    ("brake", False): PRESSED,
    ("brake", True): PRESSED,
    ("clutch", False): PRESSED,
    ("one_way_clutch", False): PRESSED,
    ("mass_with_stops_and_friction", True): {"L": "length", "smin": "s_min", "smax": "s_max"},
}


def plain(facts):
    """A component's facts with its friction as rows or a curve."""
    facts = dict(facts)
    if facts.get("table") == "stribeck_table":
        curve = [(v, 5 + v + 10 * np.exp(-2 * v)) for v in 12 * np.arange(50) / 49]
        facts["table"] = [[float(v), float(f)] for v, f in curve]
    if facts["type"] == "mass_with_stops_and_friction":
        viscous, coulomb, more, decay = (
            facts.pop(key) for key in ("F_prop", "F_Coulomb", "F_Stribeck", "fexp")
        )
        facts["characteristic"] = Stribeck(coulomb, coulomb + more, decay, viscous)
        facts["peak"] = 1.001
    return facts
