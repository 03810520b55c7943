"""Machines of the literature, each with the numbers of its source.

Five follow publications. Three are reconstructed examples: their numbers come from public programs,
and the publications behind these were not read.
"""

if not __name__.startswith("lumped."):
    raise ImportError(
        f"The machines were imported as {__name__!r}; their name is 'lumped.models'. "
        "Install the project and write 'from lumped.models import ...'."
    )

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import lumped as lp
from lumped.errors import UnknownNameError, nearest
from lumped.language.component import Component
from lumped.support.text_table import format_comparison

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lumped.compiler.system import System
    from lumped.models.about import About, Measure
    from lumped.simulation.work_precision import WorkPrecision
    from lumped.timeloop.results.operating_point import OperatingPoint
    from lumped.timeloop.results.trajectory import Trajectory

__all__ = ["MACHINES", "MARKS", "Machine", "Row", "list_rows", "machine"]

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
        """Published and computed value and their deviation (`format_comparison`)."""
        return format_comparison(self.published, self.computed, self.bounds, self.fitted)


def list_rows(
    unit: str, place: str, remarks: Mapping[str, str], computed: Iterable[float]
) -> list[Row]:
    """Rows of what the source does not print.

    Parameters
    ----------
    unit, place : str
        As in `Row`, of all of them.
    remarks : mapping of str to str
        Remarks by the quantities.
    computed : iterable of float
        Values of the model, in the same order.
    """
    return [
        Row(quantity, unit, None, float(value), place, remark)
        for (quantity, remark), value in zip(remarks.items(), computed, strict=True)
    ]


def _none(_: "System", __: Mapping[str, Any] | None) -> dict[str, float]:
    return {}


@dataclass
class Machine:
    """A published machine.

    Attributes
    ----------
    name : str
        Its name in `MACHINES`.
    ABOUT : About
        Description in its report.
    rows : callable
        Published and computed numbers.
    model : callable
        The machine to draw.
    run : callable
        The run of the report: its end, s, as `until`, and options of `lumped.simulate`.
    effects : callable
        Numbers, besides the extremes of that run, that show what changed parameters do; from the
        run and the parameters.
    given : callable
        Start values of that run in a system with changed parameters.
    searched : callable, optional
        Start of that run where it must be searched for; some parameters may follow from it.
    short : float
        End, s, of the run whose error is shown against run time.
    grid : int
        Output intervals of the run whose extremes are compared.
    """

    name: str
    ABOUT: "About"
    rows: Callable[[], list[Row]]
    model: Callable[[], Component]
    run: "Callable[..., Trajectory]"
    effects: "Callable[[Trajectory, Mapping[str, Any] | None], Iterable[Measure]]"
    short: float
    given: "Callable[[System, Mapping[str, Any] | None], dict[str, float]]" = _none
    searched: "Callable[[System, Mapping[str, Any] | None], OperatingPoint] | None" = None
    grid: int = 4000

    def scene(self, until: float | None = None, **options: Any) -> "Trajectory":
        """The run of the report; it ends at `short` unless `until` is given."""
        return self.run(until=self.short if until is None else until, **options)

    def accuracy(
        self, parameters: Mapping[str, Any] | None = None, **options: Any
    ) -> "WorkPrecision":
        """Error against run time of the run that ends at `short`, as `work_precision`."""
        run = self.scene(parameters=parameters, grid=1)
        until, start = float(run.t[-1]), run.point(0.0)
        return lp.simulation.work_precision(run.system, until=until, start=start, **options)

    def plots(self) -> "dict[str, Figure]":
        """Figures by the names of their captions."""
        figures = import_module(f"lumped.models.{self.name}.figures")
        return {name: getattr(figures, f"draw_{name}")() for name in self.ABOUT.captions}

    def start_values(
        self, system: "System", parameters: Mapping[str, Any] | None = None
    ) -> dict[str, float] | None:
        """Start values of the run; None where its start must be searched for."""
        return None if self.searched else self.given(system, parameters)

    def begin(
        self, system: "System", parameters: Mapping[str, Any] | None = None
    ) -> "OperatingPoint":
        """Start of the run with changed parameters."""
        if self.searched:
            return self.searched(system, parameters)
        start = self.given(system, parameters)
        return lp.start_point(system, parameters=parameters, start=start)

    def measures(self, parameters: Mapping[str, Any] | None = None) -> "list[Measure]":
        """Numbers that show the effect of changed parameters on the run."""
        from lumped.models.about import extremes

        run = self.scene(self.ABOUT.until, parameters=parameters, grid=self.grid)
        return [*self.effects(run, parameters), *extremes(run, self.ABOUT)]


def machine(name: str) -> Machine:
    """The description of a machine.

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
    return cast(Machine, import_module(f"lumped.models.{name}").MACHINE)
