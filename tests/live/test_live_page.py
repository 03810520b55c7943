"""Pages that compute their runs, in a browser without a network."""

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import Browser, opened

import lumped as lp
from lumped import functionals as f
from lumped.cli import main
from lumped.components import Brake, Inertia, SpringDamper, Torque
from lumped.errors import OptionError, UnknownNameError
from lumped.language.validity import Range
from lumped.models import machine

PUBLISHED = ("pilger_mill", "reversing_mill", "carrousel_coiler", "rotary_arm", "eccentric_shear")
READY = "typeof shown === 'object' && shown !== null || place('fault').textContent"
CURVES = "({t: [...shown.t], columns: shown.columns.map(c => [...c])})"
MOVED = """(() => {{
  const own = sliders.find(s => data.parameters[s.place].name === {name})
  const input = [...document.querySelectorAll(".slider input")][sliders.indexOf(own)]
  input.value = Number(input.value) + {steps} * Number(input.step)
  const before = shown
  input.dispatchEvent(new Event("input"))
  return new Promise(done => {{
    const look = () => shown === before ? requestAnimationFrame(look) : done()
    look()
  }})
}})()"""


@pytest.fixture(name="browser")
def without_network(tmp_path: Path) -> Iterator[Browser]:
    with opened(tmp_path / "profile") as found:
        rates = {"latency": 0, "downloadThroughput": 0, "uploadThroughput": 0}
        found.call("Network.emulateNetworkConditions", offline=True, **rates)
        yield found


def shown(browser: Browser, page: Path, query: str = "") -> None:
    browser.open(page, query=query)
    browser.wait(READY)


def move(browser: Browser, name: str, steps: int) -> None:
    """Move a slider and wait for the run."""
    moved = MOVED.format(name=json.dumps(name), steps=steps)
    answer = browser.call("Runtime.evaluate", expression=moved, awaitPromise=True)
    assert "exceptionDetails" not in answer, answer


def deviation(browser: Browser, run: lp.Trajectory, names: list[str]) -> float:
    """Greatest difference between curves of the page and a run, in shares of their ranges.

    At events the run has two rows; the page has one of them.
    """
    found = browser.value(CURVES)
    times = np.array(found["t"])
    slack = 1e-14 * times[-1]
    first = np.searchsorted(run.t, times - slack)
    last = np.searchsorted(run.t, times + slack, side="right") - 1
    assert (last >= first).all()
    worst = 0.0
    for name, values in zip(names, found["columns"], strict=True):
        reference = run[name]
        error = np.minimum(np.abs(values - reference[first]), np.abs(values - reference[last]))
        worst = max(worst, float(error.max()) / (float(np.ptp(reference)) or 1.0))
    return worst


def numbers(browser: Browser) -> dict[str, float]:
    """Numbers of the run by their texts."""
    found = browser.value("data.numbers.map((n, i) => [n.text, String(shown.numbers[i])])")
    return {text: float(value) for text, value in found}


def parameters(browser: Browser) -> dict[str, float]:
    """All parameters of the page."""
    return dict(browser.value("data.parameters.map((p, i) => [p.name, values[i]])"))


@pytest.mark.parametrize("name", PUBLISHED)
def test_pages_of_the_published_machines(name: str, browser: Browser, tmp_path: Path, capsys):
    file = tmp_path / f"{name}.html"
    assert main(["report", name, "--live", "-o", str(file)]) == 0
    shown(browser, file)
    assert browser.value("place('fault').textContent") == ""
    browser.value("shown = null, show()")
    chosen = machine(name)
    names = list(chosen.ABOUT.watched.values())
    first = chosen.scene(chosen.ABOUT.until, grid=1)
    moved = browser.value("data.parameters[sliders[0].place].name")
    move(browser, moved, 2)
    assert browser.value("place('fault').textContent") == ""
    values = parameters(browser)
    assert values[moved] != first.system.parameters[moved]

    def simulated(changed: dict[str, float]) -> lp.Trajectory:
        return lp.simulate(
            first.system,
            until=float(first.t[-1]),
            grid=1000,
            start=chosen.start_values(first.system),
            parameters=values | changed,
            method="steps",
        )

    run = simulated({})
    beside = simulated({moved: float(np.nextafter(values[moved], np.inf))})
    rounding = max(  # arcs are those of the browser: what the last digit of a parameter changes
        np.abs(run[name] - beside[name]).max() / np.ptp(run[name]) for name in names
    )
    error = deviation(browser, run, names)
    times = sorted(browser.value("shown.events.filter(e => !e.isTimed).map(e => e.t)"))
    changes = sorted(e.time for e in run.events if e.kind != "time")
    told = browser.value("shown.events.filter(e => e.isTimed).map(e => e.t)")
    timed = {e.time for e in run.events if e.kind == "time" and e.time < run.t[-1]}
    np.testing.assert_allclose(np.unique(told), sorted(timed), rtol=1e-12)
    drawn = browser.value("place('state').textContent")
    with capsys.disabled():
        print(
            f"\n{name}: curves {error:.1e} of their range (the last digit of {moved}: "
            f"{rounding:.1e}), {len(times)} events; {drawn}",
            end="",
        )
    assert error < max(1e-12, 10 * rounding)
    np.testing.assert_allclose(times, changes, rtol=1e-12)
    peaks = numbers(browser)
    for quantity in names:
        span = float(np.ptp(run[quantity])) or 1.0
        assert peaks[f"highest({quantity})"] >= run[quantity].max() - 1e-9 * span
        assert peaks[f"lowest({quantity})"] <= run[quantity].min() + 1e-9 * span
    assert browser.errors == []
    assert {url.split(":")[0] for url in browser.requests} <= {"file", "data"}


class Braked(lp.Component):
    """A motor, a shaft, and a load that a brake stops and holds from time to time."""

    drive: Torque = Torque(tau=30.0)
    motor: Inertia = Inertia(J=0.4)
    shaft: SpringDamper = SpringDamper(c=900.0, d=0.6)
    load: Inertia = Inertia(J=1.7)
    brake: Brake = Brake(f_max=100.0, u=0.5 + 0.5 * lp.ops.sin(3.0 * lp.time))

    def connections(self):
        yield from lp.chain(self.drive, self.motor, self.shaft, self.load, self.brake)


OF_A_RUN = {
    "peak": f.peak("shaft.tau"),
    "highest": f.highest("load.w"),
    "lowest": f.lowest("shaft.tau", between=(0.5, 2.0)),
    "swing": f.swing("shaft.tau"),
    "final": f.final("load.phi"),
    "integral": f.integral("shaft.tau"),
    "mean": f.mean("shaft.tau", between=(0.2, 1.0)),
    "rms": f.rms("shaft.tau"),
    "at": f.at_time(1.25, "load.w"),
    "count": f.count("brake"),
    "instant": f.instant("brake", after="stuck"),
    "last instant": f.instant("brake", number=-1),
    "never": f.instant("brake", number=500),
    "beside": f.at_event("shaft.tau", "brake", number=1),
    "span": f.span(between=(0.5, 2.0)),
    "loss": f.loss("brake"),
    "impulse": f.impulse("brake", number=None),
}


def test_numbers_of_a_run_are_those_of_an_ensemble(browser: Browser, tmp_path: Path):
    system = lp.assemble(Braked(), keep=["load.phi"])
    sliders: dict[str, Any] = {"shaft.c": (300.0, 2000.0), "brake.f_max": ("40 N", "200 N")}
    page = lp.live_page(
        system, tmp_path / "p.html", until="4 s", sliders=sliders, plots=["load.w", "shaft.tau"],
        numbers=OF_A_RUN,
    )  # fmt: skip
    shown(browser, page)
    move(browser, "shaft.c", -90)
    move(browser, "brake.f_max", 7)
    values = parameters(browser)
    drawn = "document.getElementById('s-value of brake').querySelector('text').textContent"
    torque = system.parameter_values()["brake.c_geo"] * values["brake.f_max"] * 0.5  # of friction
    assert browser.value(drawn) == f"{torque:.3g} N.m"
    moved = {name: values[name] for name in sliders}
    stop = round((900.0 - 300.0) / 4.25) - 90  # of 400 of 4.25 N.m/rad each
    assert values["shaft.c"] == pytest.approx(300.0 + stop * 4.25, rel=1e-12)
    found = lp.ensemble(system, over=[moved], until=4.0, of=OF_A_RUN)
    told = numbers(browser)
    for label in OF_A_RUN:
        expected = float(found[label][0])
        assert told[label] == pytest.approx(expected, rel=1e-12, abs=1e-12, nan_ok=True), label
    assert np.isnan(told["never"])
    assert "does not happen" in browser.value("place('numbers').textContent")
    run = lp.simulate(system, until=4.0, grid=1000, parameters=values, method="steps")
    assert deviation(browser, run, ["load.w", "shaft.tau"]) < 1e-12


def test_jumps_of_functions_of_time_are_events(browser: Browser, tmp_path: Path):
    begins = lp.ops.where(lp.time >= 0.1, 5.0, 0.0)
    pulse = lp.ops.interpolate(lp.time, [0, 0.3, 0.4, 0.5], [0, 0, 2.0, 0], period=0.5)
    rig = lp.compose(
        pull=Torque(tau=begins),
        push=Torque(tau=pulse),
        body=Inertia(J=2.0),
        connections=lambda m: [lp.connect(m.pull.flange, m.push.flange, m.body.flange_a)],
    )
    page = lp.live_page(rig, tmp_path / "p.html", until=0.95, plots=["body.w"])
    shown(browser, page)
    found = browser.value("shown.events.map(e => [e.t, e.name + ': ' + e.after])")
    assert [t for t, _ in found] == pytest.approx([0.1, 0.3, 0.4, 0.5, 0.8, 0.9], rel=1e-12)
    assert found[0][1] == "pull.tau: time >= 0.1"
    assert found[4][1] == "push.tau: time >= 0.8 and time < 0.9"
    assert len(found) == browser.value("shown.eventCount")
    words = browser.value("place('events').textContent")
    assert all(text in words for _, text in found)
    run = lp.simulate(lp.assemble(rig), until=0.95)
    assert [e.after for e in run.events] == [text.split(": ")[1] for _, text in found]


class Shaken(lp.Component):
    """An oscillator under a load that sets in at instants that no formula tells."""

    k: lp.Param = lp.param("1/s2", "stiffness of unit mass", 9.0)
    x: lp.Var = lp.var("m", "position", start=0.3)
    v: lp.Var = lp.var("m/s", "speed", start=0.0)

    def equations(self):
        pushed = lp.time + 0.3 * lp.ops.sin(5.0 * lp.time) > 0.4
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == lp.ops.where(pushed, 1.0, -1.0) - self.k * self.x


def test_a_number_with_a_kink_beside_instants_that_no_formula_tells(
    browser: Browser, tmp_path: Path
):
    system = lp.assemble(Shaken())
    wanted = f.peak(abs(system.model.x) - 0.5 * system.model.x)
    page = lp.live_page(system, tmp_path / "p.html", until=2.0, plots=["x"], numbers=[wanted])
    shown(browser, page)
    assert browser.value("place('fault').textContent") == ""
    expected = lp.ensemble(system, over=[{"k": 9.0}], until=2.0, of=[wanted])
    (value,) = expected[str(wanted)]
    assert numbers(browser)[str(wanted)] == pytest.approx(value, rel=1e-6)


def test_parameters_come_and_go_by_link_and_file(browser: Browser, tmp_path: Path):
    page = lp.live_page(
        Braked(), tmp_path / "p.html", until=1.0, sliders=["shaft.c"], plots=["load.w"]
    )
    shown(browser, page, query="#motor.J=0.55&shaft.c=812.5")
    browser.wait("values[data.parameters.findIndex(p => p.name === 'motor.J')] === 0.55")
    values = parameters(browser)
    assert values["shaft.c"] == 812.5
    text = browser.value("parameterFile(data.name, data.parameters, values)")
    file = tmp_path / "found.toml"
    file.write_text(text)
    system = lp.assemble(Braked())
    assert lp.exchange.read_parameters(system, file) == values
    written = lp.exchange.write_parameters(
        system, tmp_path / "own.json", parameters={"load.J": "2.5 kg.m2"}
    ).read_text()
    browser.value(f"setAll(readParameters({json.dumps(written)}, data.parameters))")
    assert parameters(browser) == system.parameters | {"load.J": 2.5}
    assert "#load.J=2.5" in browser.wait(
        "place('link').href.includes('load') && place('link').href"
    )
    for wrong, words in (
        ('{"load.K": 1}', "The model has no parameter load.K."),
        ('"load.J" = "2.5 N"', "load.J = 2.5 N: give it in kg.m2."),
        ('"load.J" = "two"', "load.J = two is no number."),
    ):
        assert words in browser.value(
            f"(() => {{ try {{ readParameters({json.dumps(wrong)}, data.parameters) }}"
            " catch (fault) { return fault.message } })()"
        )
    browser.value("location.hash = '#load.K=1'")
    assert "no parameter load.K" in browser.wait("place('fault').textContent")


class Runaway(lp.Component):
    """``x' = k x^2``, so ``x = 1 / (1 - k t)``."""

    k: lp.Param = lp.param("1/s", "rate", 0.3, min=0)
    x: lp.Var = lp.var("1", "what grows", start=1.0)

    def equations(self):
        yield lp.der(self.x) == self.k * self.x**2


class Fitted(lp.Component):
    """A hole that must not be smaller than its play."""

    play: lp.Param = lp.param("m", "play between both parts", 0.5, min=0)
    hole: lp.Param = lp.param("m", "diameter of the hole", 1.0, min=play)
    w: lp.Var = lp.var("1/s", "what fades", start=1.0)

    def equations(self):
        yield lp.der(self.w) == -self.hole * self.w


class Limited(Runaway):
    """The same, known up to 3."""

    def valid(self):
        yield Range(self.x, 0.0, 3.0, "1", "what grows", "Take a smaller rate")


def test_a_run_that_fails_is_told_in_words_and_keeps_its_curve(browser: Browser, tmp_path: Path):
    page = lp.live_page(
        Runaway(), tmp_path / "p.html", until=1.5, sliders={"k": (0.1, 1.1)}, plots=["x"], rtol=1e-9
    )
    shown(browser, page)
    assert browser.value("place('fault').textContent") == ""
    browser.value("setAll([[0, 1.0]])")
    words = browser.wait("place('fault').textContent")
    assert "runs to infinity" in words
    assert "x = " in words
    found = browser.value(CURVES)
    t, x = np.array(found["t"]), np.array(found["columns"][0])
    assert 0.99 < t[-1] < 1.0
    np.testing.assert_allclose(x[t < 0.9], 1 / (1 - t[t < 0.9]), rtol=1e-7)
    browser.value("setAll([[0, -0.2]])")
    words = browser.wait(
        "place('fault').textContent.includes('out of range') && place('fault').textContent"
    )
    assert "k = -0.2 is out of range: it must be at least 0" in words
    browser.value("setAll([[0, 0.2]])")
    browser.wait("place('fault').textContent === ''")


@pytest.mark.parametrize(
    ("model", "moved", "value", "words"),
    [
        (Fitted(), "play", 1.5, r"The run ends early: Fitted: hole must be at least play \(.*\)"),
        (Limited(), "k", 0.8, r".*what grows lies outside 0 to 3 1.*Take a smaller rate\."),
    ],
)
def test_what_does_not_go_together_is_told(
    model: lp.Component, moved: str, value: float, words: str, browser: Browser, tmp_path: Path
):
    page = lp.live_page(model, tmp_path / "p.html", until=1.0, sliders=[moved])
    shown(browser, page)
    assert browser.value("place('fault').textContent") == ""
    browser.value(f"setAll([[data.parameters.findIndex(p => p.name === '{moved}'), {value}]])")
    assert re.fullmatch(words, browser.wait("place('fault').textContent"))


@pytest.mark.parametrize(
    ("options", "fault", "text"),
    [
        ({"until": -1.0}, OptionError, "until = -1"),
        ({"grid": 0}, OptionError, "grid = 0"),
        ({"sliders": ["motor.k"]}, UnknownNameError, r"motor\.k"),
        ({"numbers": [f.rms("load.w"), f.rms("load.w")]}, OptionError, "named twice"),
        ({"plots": []}, OptionError, "name quantities to draw"),
        ({}, OptionError, r"pip install lumped\[cross\]"),  # all else is refused before
    ],
)
def test_wrong_calls(options: dict, fault: type, text: str, tmp_path: Path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ziglang", None)
    with pytest.raises(fault, match=text):
        lp.live_page(Braked(), tmp_path / "p.html", **({"until": 1.0} | options))
    assert not list(tmp_path.iterdir())
