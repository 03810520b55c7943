"""Component library."""

if not __name__.startswith("lumped."):
    raise ImportError(
        f"The component library was imported as {__name__!r}; its name is 'lumped.components'. "
        "Install the project and write 'from lumped.components import ...'."
    )

from lumped.components.compliance import Damper, Spring, SpringDamper
from lumped.components.gears import IdealGear, RackAndPinion
from lumped.components.inertia import Inertia
from lumped.components.sources import Fixed, Position, Speed, Torque

__all__ = [
    "Damper",
    "Fixed",
    "IdealGear",
    "Inertia",
    "Position",
    "RackAndPinion",
    "Speed",
    "Spring",
    "SpringDamper",
    "Torque",
]
