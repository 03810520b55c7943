"""Components of straight-line motion by their rotational twins."""

import lumped.components
from lumped.components import translation

NAMES = {
    "Force": "Torque",
    "ForceSensor": "TorqueSensor",
    "Mass": "Inertia",
    "PositionSensor": "AngleSensor",
    "RelativePositionSensor": "RelativeAngleSensor",
    "SupportFriction": "BearingFriction",
    **{f"{kind}Force": f"{kind}Torque" for kind in ("Inverse", "Linear", "Quadratic", "Sign")},
}
TWINS = {
    getattr(translation, name): getattr(lumped.components, NAMES.get(name, name))
    for name in translation.__all__
    if NAMES.get(name, name) in lumped.components.__all__
}
