"""The page of one visitor: sliders, pictures, files, and the link that restores them."""

from __future__ import annotations

import base64
import binascii
import time
from collections.abc import Callable, Sequence
from functools import partial
from html import escape
from typing import Any

from bokeh.document import Document
from bokeh.models import (
    Button,
    Column,
    CustomJSTickFormatter,
    FileInput,
    FlexBox,
    MultiSelect,
    Row,
    Select,
    UIElement,
)
from bokeh.models import Slider as Handle

from lumped.compiler.parameter_file import parameter_text, parameters_in
from lumped.errors import OptionError
from lumped.explorer.computing import Computing, Found, in_words
from lumped.explorer.live_text import STYLE, LiveText, Post
from lumped.explorer.measured import Measured, read_measured
from lumped.explorer.pictures import PICTURES, Picture
from lumped.explorer.sliders import Slider, slider
from lumped.explorer.state import from_query, query
from lumped.explorer.study import Moment, Study, Values
from lumped.explorer.views import View, views
from lumped.optimisation.identification import Identification
from lumped.optimisation.identify import identify
from lumped.support.text_table import number
from lumped.support.units import amount

_RATIO = "return Number((10 ** tick).toPrecision(4)).toString()"
_PLAIN = "return Number(tick.toPrecision(4)).toString()"


def _fault(text: str) -> str:
    return f'<span class="fault">{escape(text)}</span>'


def _styled(kind: type[FlexBox], classes: str, *parts: UIElement, **options: Any) -> Any:
    """A row or column that the style sheet knows by its classes."""
    return kind(*parts, css_classes=classes.split(), stylesheets=[STYLE], **options)


class _Card:
    """Place of a picture, with what is said about it."""

    def __init__(self, view: View, post: Post) -> None:
        self.view, self._post = view, post
        self.picture: Picture | None = None
        self.told = LiveText(post, "computing ...", name=f"told {view.title}")
        self._head = LiveText(post, f"<h2>{escape(view.title)}</h2>").model
        kind = "card whole" if view.kind == "schematic" else "card"
        self.model = _styled(Column, kind, self._head, self.told.model)

    def show(self, study: Study, found: Found, overlay: Measured | None) -> None:
        """Draw what was found; what could not be made is told, and the last picture stays."""
        if found.shown is None:
            self.told.write(_fault(found.error))
            return
        if self.picture is None:
            self.picture = PICTURES[self.view.kind](study, found.shown, self._post)
            if overlay is not None:
                self.picture.overlay(overlay)
            self.model.children = [self._head, self.told.model, *self.picture.models]
        else:
            self.picture.show(found.shown)
        self.told.write("")


class Page:
    """The page of one visitor.

    Parameters
    ----------
    doc : Document
        Of the visitor.
    study : Study
        What is shown.
    sliders : sequence of Slider
        Those at first.
    text : str
        Query string of the link.
    told : callable
        Called with the changed parameters whenever they change.
    """

    def __init__(
        self,
        doc: Document,
        study: Study,
        sliders: Sequence[Slider],
        text: str,
        told: Callable[[Values], None],
    ) -> None:
        self._doc, self._study, self._told = doc, study, told
        self._post = Post(doc)
        self._sliders = tuple(sliders)
        self._values = study.base | {each.name: each.default for each in sliders}
        self._handles: dict[str, tuple[Handle, LiveText]] = {}
        self._choice = Select(title="Add or remove a slider", name="choose")
        self._vary = MultiSelect(
            title="Identify from them (Ctrl for several)",
            size=4,
            sizing_mode="stretch_width",
            name="vary",
        )
        self._actions = self._buttons()
        self._is_setting = False
        self._measured: Measured | None = None
        self._moment = Moment(study, self._values)
        self._cards = {view.title: _Card(view, self._post) for view in views(study)}
        self._message = LiveText(self._post, name="message")
        self._status = LiveText(self._post, "computing ...", name="status")
        self._side = _styled(Column, "side", LiveText(self._post).model)
        self._lay_out()
        self._computing = Computing([card.view for card in self._cards.values()], self._show_later)
        doc.on_session_destroyed(lambda _: self._computing.end())
        self._link: str | None = text
        doc.on_event("document_ready", lambda _: self._ready())

    def _ready(self) -> None:
        """Restore what the link says; nothing that was written before would be seen."""
        if self._link is None:  # the connection was lost and is there again
            self._post.again()
            return
        text, self._link = self._link, None
        if text:
            self._attempt(self._restore, text)
        self._fill_side()
        self._begin()

    # -- layout ------------------------------------------------------------------------------

    def _lay_out(self) -> None:
        head = LiveText(self._post, f"<h2>{escape(self._study.system.name)}</h2>").model
        cards = _styled(Row, "cards", *(card.model for card in self._cards.values()))
        top = Row(head, self._status.model, sizing_mode="stretch_width")
        column = _styled(Column, "main", top, self._message.model, cards)
        whole = _styled(Row, "wide", self._side, column, sizing_mode="stretch_width")
        whole.tags = [self._post.model]
        self._doc.add_root(whole)
        self._doc.title = f"{self._study.system.name} - lumped"

    def _fill_side(self) -> None:
        """Sliders under the names of their parts, then what one does with them."""
        system, names = self._study.system, [each.name for each in self._sliders]
        groups: dict[str, list[UIElement]] = {}
        for each in self._sliders:
            if each.part not in groups:
                head = escape(each.part or system.name)
                groups[each.part] = [LiveText(self._post, f"<h3>{head}</h3>").model]
            if each.name not in self._handles:
                note = LiveText(self._post, name=f"note {each.name}")
                self._handles[each.name] = self._handle(each), note
            handle, note = self._handles[each.name]
            groups[each.part] += [handle, note.model]
        self._place()
        parts: dict[str, list[tuple[str, str]]] = {"": [("", "...")]}
        for name in system.parameters:
            part, _, own = name.rpartition(".")
            mark = " (remove)" if name in names else ""
            parts.setdefault(part or system.name, []).append((name, own + mark))
        self._choice.options, self._choice.value = parts, ""
        self._vary.options = names
        self._side.children = [
            _styled(Column, "group", *group, sizing_mode="stretch_width")
            for group in (*groups.values(), self._actions)
        ]

    def _handle(self, each: Slider) -> Handle:
        low, high = each.ends
        unit = "" if each.unit == "1" else f", {each.unit}"
        handle = Handle(
            start=low,
            end=high,
            value=each.position(self._values[each.name]),
            step=each.step,
            title=f"{each.name.rpartition('.')[2]}: {each.text}{unit}",
            format=CustomJSTickFormatter(code=_RATIO if each.is_ratio else _PLAIN),
            sizing_mode="stretch_width",
            stylesheets=[STYLE],
            name=each.name,
        )
        handle.on_change("value", partial(self._on_move, each))
        return handle

    def _buttons(self) -> list[UIElement]:
        told = "The address of this page holds its sliders and values."
        self._choice.on_change("value", lambda _, __, new: self._attempt(self._choose, new))
        back = Button(label="Reset", name="reset")
        back.on_click(lambda: self._attempt(self._set, {s.name: s.default for s in self._sliders}))
        save = Button(label="Save parameters", name="save")
        save.on_click(self._save)
        fit = Button(label="Identify", name="identify")
        fit.on_click(lambda: self._attempt(self._identify))
        return [
            self._choice,
            Row(back, save, sizing_mode="stretch_width"),
            self._input("Load parameters (.toml, .json)", ".toml,.json", self._load, "load"),
            self._input("Measured curves (.csv, .uff)", ".csv,.uff,.unv", self._lay_over, "data"),
            self._vary,
            fit,
            LiveText(self._post, told).model,
        ]

    def _input(
        self, title: str, endings: str, then: Callable[[str, bytes], None], name: str
    ) -> FileInput:
        given = FileInput(accept=endings, title=title, name=name)

        def read() -> None:
            try:
                held = base64.b64decode(str(given.value), validate=True)
            except binascii.Error:
                raise OptionError(f"{given.filename}: the file arrived damaged.") from None
            then(str(given.filename), held)

        def on_arrival(_: str, __: object, new: object) -> None:
            if new:  # the name of the file arrives after its content
                self._doc.add_next_tick_callback(lambda: self._attempt(read))

        given.on_change("value", on_arrival)
        return given

    # -- what the visitor does ---------------------------------------------------------------

    def _attempt(self, action: Callable[..., None], *given: Any) -> None:
        """Do something, or say in words why not."""
        try:
            action(*given)
        except Exception as fault:  # functions of the user may raise anything
            self._message.write(_fault(in_words(fault)))
        else:
            self._message.write("")

    def _on_move(self, each: Slider, _: str, __: float, new: float) -> None:
        if not self._is_setting:
            self._attempt(lambda: self._change({each.name: each.value(new)}))

    def _change(self, changes: Values) -> None:
        values = self._values | changes
        self._study.system.theta(values)  # refuses what does not go together
        for each in self._sliders:
            if each.name in changes:
                each.check(changes[each.name])
                self._handles[each.name][1].write("")
        self._values = values
        self._begin()

    def _set(self, changes: Values) -> None:
        """Change values and move their sliders."""
        self._change(changes)
        self._place()

    def _place(self) -> None:
        self._is_setting = True
        for each in self._sliders:
            self._handles[each.name][0].value = each.position(self._values[each.name])
        self._is_setting = False

    def _choose(self, name: str) -> None:
        if not name:
            return
        shown = [each.name for each in self._sliders]
        if name in shown:
            if len(shown) == 1:
                raise OptionError("One slider must stay.")
            self._sliders = tuple(each for each in self._sliders if each.name != name)
        else:
            system = self._study.system
            new = slider(system, system.theta(self._study.base), name)
            values = {name: new.default} | self._values
            new.check(values[name])
            self._values = values
            self._sliders = (*self._sliders, new)
        self._fill_side()
        self._begin()

    def _restore(self, text: str) -> None:
        self._sliders, values = from_query(self._study, self._sliders, text)
        self._values = {each.name: each.default for each in self._sliders} | values

    def _save(self) -> None:
        name = f"{self._study.system.name}.toml"
        text = parameter_text(self._study.system, name, self._moment.parameters)
        self._post.file(name, text)

    def _load(self, path: str, held: bytes) -> None:
        self._set(parameters_in(self._study.system, path, held))

    def _lay_over(self, path: str, held: bytes) -> None:
        self._measured = read_measured(self._study.system, path, held)
        for card in self._cards.values():
            if card.picture is not None:
                card.picture.overlay(self._measured)

    def _identify(self) -> None:
        data, chosen = self._measured, list(self._vary.value)
        if data is None:
            raise OptionError("Identify: choose a file of measured curves first.")
        vary = {s.name: (s.low, s.high) for s in self._sliders if s.name in chosen}
        if not vary:
            raise OptionError("Identify: choose which sliders the curves shall move.")
        moment = self._moment
        self._status.write("identifying ...")

        def search_parameters() -> None:
            try:
                result = identify(
                    self._study.system,
                    vary=vary,
                    t=data.t,
                    measured=data.curves,
                    parameters=moment.parameters,
                    start=moment.start,
                )
            except Exception as fault:
                self._doc.add_next_tick_callback(partial(self._say, _fault(in_words(fault))))
                return
            self._doc.add_next_tick_callback(partial(self._show_identification, result))

        self._computing.later(search_parameters)

    def _say(self, text: str) -> None:
        self._message.write(text)
        self._status.write("")

    def _show_identification(self, found: Identification) -> None:
        self._attempt(self._set, found.parameters)
        for name, (low, high) in found.intervals.items():
            open_ = name in found.unknown
            told = "not identified" if open_ else f"{number(low)} .. {number(high)}"
            self._handles[name][1].write(f"{found.level:.0%}: {told}")
        self._message.write(f"<pre>{escape(repr(found))}</pre>")

    # -- pictures ----------------------------------------------------------------------------

    def _begin(self) -> None:
        self._began = time.perf_counter()
        self._moment = Moment(self._study, dict(self._values))
        self._told(self._moment.values)
        self._computing.begin(self._moment, self._sliders)

    def _show_later(self, moment: Moment, found: list[Found], coming: list[View]) -> None:
        """Show from the thread of the page what a thread has made."""
        self._doc.add_next_tick_callback(partial(self._show, moment, found, coming))

    def _show(self, moment: Moment, found: list[Found], coming: list[View]) -> None:
        for made in found:
            self._cards[made.view.title].show(self._study, made, self._measured)
        for each in self._sliders:
            if each.name in moment.follows:
                value = amount(moment.follows[each.name], each.unit)
                self._handles[each.name][1].write(f"follows from the start: {value}")
        if moment is self._moment:
            self._told(moment.parameters)
        for view in coming:
            self._cards[view.title].told.write("computing ...")
        seconds = time.perf_counter() - self._began
        self._status.write("computing ..." if coming else f"made in {1e3 * seconds:.0f} ms")
        self._post.link(query(self._study, self._sliders, moment.values))
