"""The report on a torsional vibration calculation, as an engineer hands it in."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from lumped.drawing.page_frame import report_page
from lumped.drawing.page_print import find_printer, write_page
from lumped.drawing.torsional_sections import lead, sections
from lumped.drawing.torsional_study import Limits, study
from lumped.support.arguments import checked
from lumped.support.display_units import Units
from lumped.timeloop.results.trajectory import Trajectory
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.speeds.campbell import Campbell


@checked
def torsional_report(
    response: OrderResponse | Mapping[str, OrderResponse],
    path: str | Path,
    *,
    title: str = "",
    about: Mapping[str, str | Sequence[str]] | None = None,
    limits: Limits = (),
    operation: tuple[float | str, float | str] | None = None,
    margin: float | None = None,
    orders: Iterable[float] | None = None,
    modes: Modes | None = None,
    campbell: Campbell | None = None,
    heat: Mapping[str, Mapping[str, ArrayLike]] | None = None,
    runs: Mapping[str, Trajectory] | None = None,
    assumptions: Iterable[str] = (),
    units: Units = None,
) -> Path:
    """Write a report on a torsional vibration calculation, to read or to print on A4.

    It has the verdict, the schematic, the mass-elastic table, natural frequencies with their
    shapes, Holzer tables of those that the orders reach, the Campbell diagram, each quantity of
    the responses (largest orders, and all orders together against the limits, the responses side
    by side), dissipated power, transients with their peaks, all data, and the assumptions with
    residuals. The page loads no other files.

    Parameters
    ----------
    response : OrderResponse or mapping of str to OrderResponse
        From `lumped.vibration.order_response`; by captions where there are several, such as
        ``{"all cylinders fire": ..., "cylinder 1 misfires": ...}``. The first is that of the drive
        whose data, modes and critical speeds are told.
    path : str or Path
        File to write: .html, or .pdf where Chromium, Chrome or Edge is on the PATH, or its path in
        the environment variable LUMPED_CHROMIUM.
    title : str
        Title of the page; if empty, the name of the model.
    about : mapping of str to str or sequence of str, optional
        What stands below the title, such as the plant, the author and the sources.
    limits : iterable of Limit, or mapping of str to iterable of Limit
        Limits of all responses, or by the captions of responses and runs.
    operation : tuple, optional
        First and last speed of operation, rad/s, or with a unit: ``("1450 rpm", "1550 rpm")``.
    margin : float, optional
        Least distance of the critical speeds of `orders` from the operation, as a share.
    orders : iterable of float, optional
        Orders of the Campbell diagram; default is all. The report names those left out.
    modes : Modes, optional
        Default is those at the mean state in the middle of the operation, by `mean_modes`.
    campbell : Campbell, optional
        Default is that of the first response, by `mean_campbell`.
    heat : mapping of str to mapping of str to array_like, optional
        Mean dissipated power, W, at each speed of a response, by its caption and the part.
    runs : mapping of str to Trajectory, optional
        Transients, by captions: their quantities are those of the responses and of the limits.
    assumptions : iterable of str, optional
        To stand before those of the methods.
    units : mapping of str to str or str, optional
        Units to show, see `lumped.display_units`; default is what the session shows, or, if nothing
        was chosen, "engineering": torques in kN.m, stresses in MPa, angles in deg, speeds in 1/min.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    OptionError
        If there is no response, the operation makes no sense, an order was not computed, a run has
        none of the quantities, or a PDF cannot be printed.
    UnknownNameError
        If a limit is for a quantity that was not computed, or a caption is unknown, or a unit is
        given for a name that does not exist.
    UnitError
        If a limit or speed has a unit of another dimension, or a unit to show does.
    """
    target = Path(path)
    printer = find_printer(target)
    found = study(
        response,
        limits=limits,
        operation=operation,
        margin=margin,
        orders=orders,
        found_modes=modes,
        found_campbell=campbell,
        heat=heat or {},
        runs=runs or {},
        units=units,
    )
    parts = list(sections(found, assumptions))
    page = report_page(title or found.system.name, parts, lead(found, about or {}))
    write_page(target, page, printer)
    return target
