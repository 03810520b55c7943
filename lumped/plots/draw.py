"""A described picture becomes a figure."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypedDict

from lumped.errors import OptionError
from lumped.plots.picture import Picture
from lumped.support.optional_packages import extra

Backend = Literal["matplotlib", "plotly"]


class Canvas(TypedDict, total=False):
    """What draws a picture, and where; each `plot` takes them by name.

    Attributes
    ----------
    backend : {"matplotlib", "plotly"}
        What draws it; plotly makes an interactive figure.
    ax : matplotlib Axes, or an array of as many as there are panels, optional
        Where matplotlib draws; default is a new figure, which needs no display.
    """

    backend: Annotated[Backend, "matplotlib"]
    ax: Annotated[Any, None]


def draw(picture: Picture, backend: Backend = "matplotlib", ax: Any = None) -> Any:
    """Draw a picture.

    Parameters
    ----------
    picture : Picture
        What is drawn.
    backend : {"matplotlib", "plotly"}
        What draws it; plotly makes an interactive figure.
    ax : matplotlib Axes, or an array of as many as there are panels, optional
        Where matplotlib draws; default is a new figure, which needs no display.

    Returns
    -------
    matplotlib.figure.Figure or plotly.graph_objects.Figure

    Raises
    ------
    OptionError
        If plotly is not installed, or `ax` does not fit.
    """
    if backend == "plotly":
        if ax is not None:
            raise OptionError(
                f"{picture.title}: ax = belongs to matplotlib; leave it out for plotly."
            )
        extra("plotly", "interactive", 'backend="plotly"')
        from lumped.plots.plotly_figure import PlotlyFigure

        return PlotlyFigure(picture).figure
    from lumped.plots.matplotlib_figure import matplotlib_figure

    return matplotlib_figure(picture, ax)
