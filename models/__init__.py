"""Machines of the literature, each with the numbers of its source.

Five follow publications. Three are reconstructed examples: their numbers come from public programs,
and the publications behind these were not read.
"""

if not __name__.startswith("lumped."):
    raise ImportError(
        f"The machines were imported as {__name__!r}; their name is 'lumped.models'. "
        "Install the project and write 'from lumped.models import ...'."
    )

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, cast

from lumped.errors import UnknownNameError, nearest
from lumped.language.component import Component
from lumped.support.text_table import compared

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lumped.compiler.system import System
    from lumped.models.about import About, Measure
    from lumped.timeloop.result import OperatingPoint, Trajectory

__all__ = ["MACHINES", "MARKS", "Machine", "Row", "machine"]

MACHINES = {
    "carrousel_coiler": "Winding drive of a carrousel coiler",
    "pilger_mill": "Crank drive of the cold pilger mill LG90 with its counterweight",
    "eccentric_shear": "Floating-shaft crank shear with elliptical gears",
    "reversing_mill": "Stand drive of the reversing cold rolling mill 400",
    "rotary_arm": "Mandrel rotary arm of a tube mill's front table",
    "marine_turbine": "Reconstructed example: geared steam turbines of a ship and their propeller",
    "diesel_genset": "Reconstructed example: six-cylinder diesel engine and its generator",
    "turbine_generator": "Reconstructed example: turbine generator with short circuits",
}


MARKS = {
    "P": "printed",
    "R": "restored by derivation",
    "I": "inferred from the published results",
    "A": "assumed, as the source does not give it",
}
"""Origins of a number, by their letters."""


class Row(NamedTuple):
    """A quantity as published and as computed.

    Attributes
    ----------
    quantity, unit : str
        Its name and unit.
    published : float or None
        Printed value; None if the source gives none, or a range.
    computed : float
        Value of the model.
    place, remark : str
        Place of the printed value, with one of the `MARKS` in brackets: origin of the source's
        number, or basis of the computed one. Explanation of a deviation.
    bounds : (float or None, float or None) or None
        Printed range, if the source prints one instead of a value; None for an open end.
    fitted : bool
        Whether a value that the source does not give was fitted to this number: then the row
        proves nothing.
    """

    quantity: str
    unit: str
    published: float | None
    computed: float
    place: str
    remark: str
    bounds: tuple[float | None, float | None] | None = None
    fitted: bool = False

    @property
    def mark(self) -> str:
        """Key of `MARKS`."""
        return self.place.partition("[")[2][:1]

    @property
    def printed(self) -> bool:
        """The source gives a value or a range."""
        return self.published is not None or self.bounds is not None

    @property
    def texts(self) -> tuple[str, str, str]:
        """Published and computed value and their deviation (`support.text_table.compared`)."""
        return compared(self.published, self.computed, self.bounds, self.fitted)


class Machine(Protocol):
    """Contents of the module of a machine; `ABOUT` has the texts of its report."""

    ABOUT: "About"

    def rows(self) -> list[Row]:
        """Published and computed numbers."""

    def plots(self) -> "dict[str, Figure]":
        """Figures by name."""

    def model(self) -> Component:
        """The machine to draw."""

    def scene(self, until: float = ..., **options: Any) -> "Trajectory":
        """The run of the report, also for error against run time; options of `lumped.simulate`."""

    def start_values(
        self, system: "System", parameters: Mapping[str, Any] | None = None
    ) -> dict[str, float] | None:
        """Start values of that run; None where its start must be searched for."""

    def begin(
        self, system: "System", parameters: Mapping[str, Any] | None = None
    ) -> "OperatingPoint":
        """Start of that run with changed parameters; some of them may follow from it."""

    def measures(self, parameters: Mapping[str, Any] | None = None) -> "list[Measure]":
        """Numbers that show the effect of changed parameters on that run."""


def machine(name: str) -> Machine:
    """Import the module of a machine.

    Parameters
    ----------
    name : str
        Its name in `MACHINES`.

    Returns
    -------
    Machine

    Raises
    ------
    UnknownNameError
        If there is no such machine.
    """
    if name not in MACHINES:
        raise UnknownNameError(f"There is no machine '{name}'. {nearest(name, MACHINES)}")
    return cast(Machine, import_module(f"lumped.models.{name}"))
