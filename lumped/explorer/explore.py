"""`explore`: the page, on this computer only."""

from __future__ import annotations

import asyncio
import os
import threading
import webbrowser
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from urllib.parse import urlencode, urljoin, urlsplit

from lumped.compiler.assemble import assemble
from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError
from lumped.explorer.found_analyses import find_analyses
from lumped.explorer.sliders import Ends, Slider
from lumped.explorer.study import (
    Analysis,
    Start,
    Study,
    choose_quantities,
    choose_sliders,
    read_end,
)
from lumped.language.component import Component
from lumped.support.arguments import checked
from lumped.support.optional_packages import extra
from lumped.vibration.rules.limits import Limit

if TYPE_CHECKING:
    from bokeh.document import Document


class Explorer:
    """A page that browsers on this computer can open, until `stop` or the end of the program.

    In a notebook it shows itself.

    Attributes
    ----------
    url : str
        Its address; that of a JupyterHub where ``JUPYTER_BOKEH_EXTERNAL_URL`` names one.
    system : System
        The drive.
    """

    def __init__(self, study: Study, sliders: Sequence[Slider]) -> None:
        self.system = study.system
        self._study, self._sliders = study, sliders
        self._values = study.base | {each.name: each.default for each in sliders}
        self._is_ready = threading.Event()
        self._ended = threading.Event()
        self._fault: Exception | None = None
        threading.Thread(target=self._serve, name="explorer", daemon=True).start()
        self._is_ready.wait()
        if self._fault is not None:
            raise self._fault

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters as last moved on the page, to give to an analysis as ``parameters=``."""
        return dict(self._values)

    def open(self) -> None:
        """Open it in a browser, and wait until it is stopped or interrupted (Ctrl-C)."""
        try:
            webbrowser.open(self.url)
            while not self._ended.wait(0.5):
                pass
        except KeyboardInterrupt:
            self.stop()

    def stop(self) -> None:
        """Close the page."""
        with suppress(RuntimeError):  # closed before
            self._loop.call_soon_threadsafe(self._loop.stop)
        self._ended.wait()

    def __repr__(self) -> str:
        if self._ended.is_set():
            return f"{self.system.name}: the page is closed"
        return f"{self.system.name}: open {self.url} in a browser"

    def _repr_html_(self) -> str:
        return f'<iframe src="{self.url}" style="width: 100%; height: 900px; border: 0"></iframe>'

    def _serve(self) -> None:
        from bokeh.application import Application
        from bokeh.application.handlers.function import FunctionHandler
        from bokeh.resources import Resources
        from bokeh.server.server import BaseServer
        from bokeh.server.tornado import BokehTornado
        from bokeh.server.util import bind_sockets
        from tornado.httpserver import HTTPServer
        from tornado.httputil import HTTPServerRequest
        from tornado.ioloop import IOLoop
        from tornado.web import ErrorHandler

        class Pages(BokehTornado):  # type: ignore[misc]
            """Scripts come from where the page is, also below a path of a hub; no other names."""

            def find_handler(self, request: HTTPServerRequest, **options: Any) -> Any:
                if request.host_name in {host.partition(":")[0] for host in origins}:
                    return super().find_handler(request, **options)
                return self.get_handler_delegate(request, ErrorHandler, {"status_code": 403})

            def resources(self, absolute_url: str | bool | None = None) -> Resources:
                return super().resources(absolute_url or True)

        self._loop = asyncio.new_event_loop()
        asyncio.set_event_loop(self._loop)
        try:
            sockets, port = bind_sockets("127.0.0.1", 0)
            self.url, origins = _address(port)
            pages = Pages(
                {"/": Application(FunctionHandler(self._open_page))},
                extra_websocket_origins=origins,
                absolute_url=self.url if len(origins) > 2 else None,
            )
            http = HTTPServer(pages)
            http.add_sockets(sockets)
            server = BaseServer(IOLoop.current(), pages, http)
            server.start()
        except Exception as fault:
            self._fault = fault
            return
        finally:
            self._is_ready.set()
        try:
            self._loop.run_forever()
        finally:
            server.stop()
            http.stop()
            self._ended.set()

    def _open_page(self, doc: Document) -> None:
        from lumped.explorer.page import Page

        context = doc.session_context
        given = {} if context is None or context.request is None else context.request.arguments
        query = urlencode([(k, v.decode()) for k, values in given.items() for v in values])
        Page(doc, self._study, self._sliders, query, self._keep_values)

    def _keep_values(self, values: Mapping[str, float]) -> None:
        self._values = dict(values)


def _address(port: int) -> tuple[str, list[str]]:
    """Where browsers find the page, and which hosts their addresses may have.

    Another computer reaches the same port through a tunnel. A JupyterHub passes it on
    (jupyter-server-proxy); it tells where by the variables that Bokeh reads, too.
    """
    hosts = [f"127.0.0.1:{port}", f"localhost:{port}"]
    hub = os.environ.get("JUPYTER_BOKEH_EXTERNAL_URL")
    if hub is None:
        return f"http://{hosts[0]}/", hosts
    prefix = os.environ.get("JUPYTERHUB_SERVICE_PREFIX", "/")
    return urljoin(urljoin(hub, prefix), f"proxy/{port}/"), [*hosts, urlsplit(hub).netloc]


@checked
def explore(
    model: Component | System,
    *,
    sliders: Iterable[Name] | Mapping[str, Ends] | Mapping[Name, Ends] | None = None,
    until: float | str | None = None,
    start: Start | None = None,
    parameters: Changes | None = None,
    of: Iterable[Name] | None = None,
    inputs: Iterable[Name] = (),
    limits: Iterable[Limit] = (),
    analyses: Mapping[str, Analysis] | None = None,
) -> Explorer:
    """A page on which one moves parameters and sees at once what changes.

    It shows the schematic with its values, natural frequencies, mode shapes and their
    sensitivities, all at the start point, and what is asked for below. What takes long is computed
    after what does not. The page runs on this computer and takes nothing but values of parameters,
    which are checked against their ranges, and files of such values and of measured curves.

    Parameters
    ----------
    model : Component or System
        The drive; a model is assembled.
    sliders : iterable of names, or mapping of name to (low, high), optional
        Parameters to move, and the ends of their sliders, numbers or with units; default is the ten
        that have most effect on the lowest three modes, then on the run. More can be chosen on the
        page.
    until : float or str, optional
        End of a run, s, or with a unit; without it there is none.
    start : mapping of name to float, or callable, optional
        Start values, or a function that gives them, or an `OperatingPoint`, for the changed
        parameters, a mapping of name to float. Parameters that the operating point determines
        (`start_point(free=...)`) follow from it.
    parameters : mapping of name to float, optional
        Parameters that are changed from the model at first.
    of : iterable of names, optional
        Quantities of the run and of the response; default is the first five states.
    inputs : iterable of names, optional
        Parameters that vary sinusoidally, for a frequency response (see `frequency_response`).
    limits : iterable of Limit, optional
        What quantities of the run may reach; without a run, of the first order response.
    analyses : mapping of str to callable, optional
        Further pictures by their titles: functions of the changed parameters (a mapping of name to
        float) that give a Campbell diagram, a frequency response or an order response. Default is
        an order response and a Campbell diagram where torques follow from the angle of a shaft, or
        a Campbell diagram where natural frequencies depend on the speed, up to a tenth above the
        greatest speed of the run, or of the start without one.

    Returns
    -------
    Explorer

    Raises
    ------
    OptionError
        If Bokeh is not installed, the model has no parameter, or sliders or times make no sense.
    UnknownNameError
        If a name does not exist, or is bound to others.
    ParameterError
        If a value is out of range.
    UnitError
        If a value has a unit of another dimension.
    """
    extra("bokeh", "explore", "explore")
    system = model if isinstance(model, System) else assemble(model)
    end = None if until is None else read_end(until, "explore")
    theta = system.theta(parameters)
    changed = {system.key(name): 0.0 for name in parameters or {}}
    base = {n: v for n, v in zip(system.parameters, theta.tolist(), strict=True) if n in changed}
    names = choose_quantities(system, of)
    if not names and (end is not None or inputs):
        raise OptionError(f"{system.name}: explore: name quantities to show, with `of`.")
    system.function(names)  # refuses what is unknown or was left out
    varied = [system.key(name) for name in inputs]
    system.places(varied)
    study = Study(
        system,
        base,
        end,
        {} if start is None else start,
        names,
        tuple(varied),
        tuple(limits),
        dict(analyses or {}),
    )
    if analyses is None:
        study = replace(study, analyses=find_analyses(study))
    return Explorer(study, choose_sliders(study, sliders))
