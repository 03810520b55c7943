"""Units of FMI as components, against equations, closed forms and other solvers."""

import pickle

import numpy as np
import pytest
import scipy
from c_units import c_unit

import lumped as lp
from lumped import errors
from lumped.components import (
    Damper,
    Fixed,
    Inertia,
    SampledPI,
    SampleHold,
    SpeedSensor,
    SpringDamper,
    Torque,
    from_fmu,
)
from lumped.exchange import unit_process
from lumped.kernel import engine
from lumped.ops import sin

T_S = 0.01


class PI(lp.Component):
    """``M = k (e + x / T_i)``, ``x' = e``."""

    wanted: lp.Input = lp.Input("rad/s", "wanted speed")
    measured: lp.Input = lp.Input("rad/s", "measured speed")
    M = lp.Output("N.m", "torque")
    x: lp.Var = lp.var("rad", "integral")
    k: lp.Param = lp.param("N.m.s/rad", "gain", 5.0)
    T_i: lp.Param = lp.param("s", "integral time", 0.5)

    def equations(self):
        e = self.wanted - self.measured
        yield lp.der(self.x) == e
        yield self.k * (e + self.x / self.T_i) == self.M


def drive(controller, *, held):
    """Two masses and a controller; between samples and holds if it does not sample by itself."""
    parts = {
        "motor": Torque(),
        "rotor": Inertia(J=2.0),
        "shaft": SpringDamper(c=400.0, d=0.5),
        "roll": Inertia(J=3.0),
        "friction": Damper(d=0.3),
        "ground": Fixed(),
        "sensor": SpeedSensor(),
        "pi": controller,
    }
    if held:
        parts |= {"sample": SampleHold(T_s=T_S), "hold": SampleHold(T_s=T_S)}

    def connections(m):
        yield from lp.chain(m.motor, m.rotor, m.shaft, m.roll, m.friction, m.ground)
        yield lp.connect(m.rotor.flange_b, m.sensor.flange)
        if held:
            yield lp.connect(m.sensor.w, m.sample.u)
            yield lp.connect(m.sample.y, m.pi.measured)
            yield lp.connect(m.pi.M, m.hold.u)
            yield lp.connect(m.hold.y, m.motor.tau)
        else:
            yield lp.connect(m.sensor.w, m.pi.measured)
            yield lp.connect(m.pi.M, m.motor.tau)

    return lp.assemble(lp.compose(**parts, connections=connections))


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    folder = tmp_path_factory.mktemp("units")
    system = lp.assemble(PI(wanted=0.0, measured=0.0))
    for version in ("2.0", "3.0"):
        lp.export_fmu(
            system,
            folder / f"pi_{version}.fmu",
            version=version,
            inputs=["wanted", "measured"],
            outputs=["M"],
            rtol=1e-10,
        )
    return folder


def unit_of(folder, version="3.0", kind="co_simulation", **values):
    return from_fmu(folder / f"pi_{version}.fmu", kind=kind, T_s=T_S, wanted=10.0, **values)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("kind", ["co_simulation", "model_exchange"])
def test_a_controller_as_a_unit_does_what_its_equations_do(exported, version, kind):
    options = {"until": 1.0, "grid": np.arange(0.5, 100) * T_S, "rtol": 1e-12}
    system = drive(unit_of(exported, version, kind), held=False)
    run = lp.simulate(system, **options)
    expected = lp.simulate(drive(PI(wanted=10.0), held=True), **options)
    error = np.abs(run["rotor.w"] - expected["rotor.w"]).max()
    print(f"{version} {kind}: largest deviation {error:.1e} rad/s")
    assert error < 1e-9
    assert system.quantity("pi.M").unit == "N.m"
    assert system.quantity("pi.measured").unit == "rad/s"


class Sampling(lp.Component):
    """A controller in a computer, with the names of the other."""

    wanted: lp.Input = lp.Input("rad/s", "wanted speed")
    measured: lp.Input = lp.Input("rad/s", "measured speed")
    M = lp.Output("N.m", "torque")
    law = SampledPI(T_s=T_S, k=5.0, T_i=0.5)

    def connections(self):
        yield lp.connect(self.wanted, self.law.wanted)
        yield lp.connect(self.measured, self.law.measured)
        yield lp.connect(self.law.y, self.M)


def test_a_unit_that_samples_at_its_own_events_takes_the_inputs_of_the_instant(tmp_path):
    options = {"until": 1.0, "grid": np.arange(0.5, 100) * T_S, "rtol": 1e-12}
    expected = lp.simulate(drive(Sampling(wanted=10.0), held=False), **options)
    path = tmp_path / "sampling.fmu"
    signals = {"inputs": ["wanted", "measured"], "outputs": ["M"]}
    lp.export_fmu(lp.assemble(Sampling(wanted=0.0, measured=0.0)), path, **signals)
    for kind in ("co_simulation", "model_exchange"):
        unit = from_fmu(path, kind=kind, T_s=T_S, wanted=10.0)
        run = lp.simulate(drive(unit, held=False), **options)
        error = np.abs(run["rotor.w"] - expected["rotor.w"]).max()
        print(f"{kind}: largest deviation {error:.1e} rad/s")
        assert error < 1e-9


def test_parameters_of_a_unit_have_their_names_and_values(exported):
    equations, system = drive(PI(wanted=10.0), held=True), drive(unit_of(exported), held=False)
    for changes in ({"pi.k": 8.0}, {"pi.k": 3.0, "pi.T_i": 0.2}, {"pi.wanted": -4.0}):
        runs = [
            lp.simulate(s, until=0.5, rtol=1e-10, parameters=changes) for s in (equations, system)
        ]
        assert abs(runs[0]["rotor.w"][-1] - runs[1]["rotor.w"][-1]) < 1e-9
    gains = np.linspace(1, 9, 5)
    options = {"until": 0.5, "rtol": 1e-10, "of": {"w": lp.functionals.final("rotor.w")}}
    swept = [lp.sweep(s, over={"pi.k": gains}, **options)["w"] for s in (equations, system)]
    assert np.abs(swept[0] - swept[1]).max() < 1e-8


@pytest.mark.parametrize("kind", ["co_simulation", "model_exchange"])
def test_a_run_goes_on_where_its_unit_was(exported, kind):
    system = drive(unit_of(exported, kind=kind), held=False)
    whole = lp.simulate(system, until=1.0, rtol=1e-12)
    point = pickle.loads(pickle.dumps(whole.point(0.505)))
    rest = lp.simulate(point.system, start=point, until=1.0, rtol=1e-12)
    last = lp.simulate(point.system, start=rest.point(0.8), until=1.0, rtol=1e-12)
    errors = [abs(run["rotor.w"][-1] - whole["rotor.w"][-1]) for run in (rest, last)]
    print("deviation of runs that go on:", errors)
    assert max(errors) < 1e-9
    late = [
        lp.simulate(s, begin=1.0, until=1.5)["rotor.w"][-1]
        for s in (system, drive(PI(wanted=10.0), held=True))
    ]
    assert abs(late[0] - late[1]) < 1e-5
    assert late[0] > 5


def test_an_interrupt_leaves_no_answer_behind(exported, monkeypatch):
    system = drive(unit_of(exported), held=False)
    expected = lp.simulate(system, until=0.3)["rotor.w"]
    read, calls = unit_process.read, []

    def interrupted(stream):
        calls.append(stream)
        if len(calls) == 12:
            raise KeyboardInterrupt
        return read(stream)

    monkeypatch.setattr(unit_process, "read", interrupted)
    with pytest.raises(errors.Interrupted) as caught:
        lp.simulate(system, until=0.3)
    assert abs(caught.value.partial.t[-1] - 11 * T_S) < 1e-9
    assert np.array_equal(lp.simulate(system, until=0.3)["rotor.w"], expected)


def test_a_certificate_runs_a_unit_again(exported):
    run = lp.simulate(drive(unit_of(exported), held=False), until=0.3, certify=True)
    assert run.certificate["rotor.w"].relative < 1e-5


def test_all_engines_ask(exported):
    system = drive(unit_of(exported, "2.0"), held=False)
    found = []
    for name in ("llvm", "c", "python"):
        with engine.using(name):
            found.append(lp.simulate(system, until=0.1, grid=5)["rotor.w"])
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[0], found[2])


def test_a_drive_as_a_unit_is_the_drive(tmp_path):
    system = drive(PI(wanted=10.0), held=False)
    run = lp.simulate(system, until=1.0, rtol=1e-11, grid=50)
    names = ["rotor.w", "roll.w", "shaft.tau"]
    lp.export_fmu(system, tmp_path / "drive.fmu", outputs=names, rtol=1e-10)
    for kind in ("co_simulation", "model_exchange"):
        unit = from_fmu(tmp_path / "drive.fmu", kind=kind, T_s=0.02, rtol=1e-12)
        times = run.t[:-1] + 1e-3
        again = lp.simulate(lp.assemble(lp.compose(unit=unit)), until=1.0, grid=times)
        for name in names:
            given = again[f"unit.{name.replace('.', '_')}"]
            error = np.abs(given - run[name][:-1]).max() / np.abs(run[name]).max()
            print(f"{kind} {name}: {error:.1e} of its largest value")
            assert error < 1e-9


class VanDerPol(lp.Component):
    """``x'' = mu (1 - x^2) x' - x``."""

    x: lp.Var = lp.var("1", "place", 2.0)
    v: lp.Var = lp.var("1/s", "its rate")
    mu: lp.Param = lp.param("1/s", "damping", 1.0)

    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == self.mu * (1 - self.x**2) * self.v - self.x


def test_an_oscillator_as_a_unit_against_scipy(tmp_path):
    lp.export_fmu(lp.assemble(VanDerPol()), tmp_path / "oscillator.fmu", rtol=1e-10)
    times = np.arange(1, 40) * 0.5
    exact = scipy.integrate.solve_ivp(
        lambda t, y: [y[1], 1.5 * (1 - y[0] ** 2) * y[1] - y[0]],
        (0, 20),
        [2.0, 0.0],
        method="DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-12,
    ).y[0]
    for kind in ("co_simulation", "model_exchange"):
        unit = from_fmu(tmp_path / "oscillator.fmu", kind=kind, T_s=0.5, mu=1.5, outputs=["x"])
        run = lp.simulate(lp.assemble(lp.compose(unit=unit)), until=20.0, grid=times + 0.25)
        error = np.abs(run["unit.x"] - exact).max()
        print(f"{kind}: {error:.1e}")
        assert error < 1e-7


class Ball(lp.Component):
    """Falls from 1 m and bounces; ``h'' = -g``."""

    h: lp.Var = lp.var("m", "height", 1.0, state="always")
    v: lp.Var = lp.var("m/s", "its rate", state="always")
    g: lp.Param = lp.param("m/s2", "gravity", 9.81)
    e: lp.Param = lp.param("1", "restitution", 0.7)

    def equations(self):
        yield lp.der(self.h) == self.v
        yield lp.der(self.v) == -self.g
        yield lp.when(self.h < 0, {self.v: -self.e * self.v, self.h: 0.0})


def height(t, g=9.81, e=0.7):
    """Height after any number of bounces."""
    begin, h, v = 0.0, 1.0, 0.0
    while True:
        hit = (v + np.sqrt(v * v + 2 * g * h)) / g
        if begin + hit >= t:
            return h + v * (t - begin) - g * (t - begin) ** 2 / 2
        begin, h, v = begin + hit, 0.0, e * (g * hit - v)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_state_events_of_a_unit_between_samples(tmp_path, version):
    lp.export_fmu(lp.assemble(Ball()), tmp_path / "ball.fmu", version=version)
    times = np.arange(1, 40) * 0.05
    exact = [height(t) for t in times]
    for kind in ("co_simulation", "model_exchange"):
        path, signals = tmp_path / "ball.fmu", {"outputs": ["h"], "T_s": 0.05}
        unit = from_fmu(path, kind=kind, rtol=1e-12, **signals)
        run = lp.simulate(lp.assemble(lp.compose(unit=unit)), until=2.0, grid=times + 0.02)
        error = np.abs(run["unit.h"] - exact).max()
        print(f"{version} {kind}: {error:.1e} m after {len(run.events)} samples")
        assert error < 1e-8


STAIR = """
static int count; static double next_event;
static void begin(void) { count = 1; next_event = 1.0; }
static int step(void) { return to > next_event + 1e-12 ? 3 : 0; }
static bool at_event(double* next) {
  while (t >= next_event - 1e-12) { count++; next_event += 1.0; }
  *next = next_event; return true; }
static void output(void) { v[0] = count; }
"""


def test_time_events_of_a_unit_are_met(tmp_path):
    """The unit fails where a step goes beyond its next event."""
    path = c_unit(
        tmp_path,
        "stair",
        '<Int32 name="counter" valueReference="0" causality="output"/>',
        STAIR,
        flags='hasEventMode="true" canHandleVariableCommunicationStepSize="true"',
    )
    for T_s in (0.3, 2.5):
        unit = from_fmu(path, T_s=T_s)
        times = np.arange(1, 10 / T_s) * T_s
        run = lp.simulate(lp.assemble(lp.compose(stair=unit)), until=10.0, grid=times + 0.1 * T_s)
        assert np.array_equal(run["stair.counter"], 1 + np.floor(times + 1e-9))


FEEDTHROUGH = """
static void begin(void) { memset(v, 0, sizeof v); v[4] = 2.0; v[5] = 1.0; }
static int step(void) { return 0; }
static bool at_event(double* next) { return false; }
static void output(void) {
  for (int i = 0; i < 4; i++) v[10 + i] = v[4] * v[i];
  v[14] = v[6]; v[15] = v[7]; v[16] = v[5]; v[17] = strcmp(word, "given") == 0;
  for (int i = 0; i < 3; i++) v[20 + i] = v[30 + i] + i; }
"""
SIGNALS = """
<Float64 name="speed" valueReference="0" causality="input" unit="rpm" start="0"/>
<Float64 name="temperature" valueReference="1" causality="input" unit="degC" start="0"/>
<Float64 name="moment" valueReference="2" causality="input" unit="kNm" start="0"/>
<Float64 name="plain" valueReference="3" causality="input" start="0"/>
<Float64 name="axis.k[1]" valueReference="4" causality="parameter" variability="fixed" start="2"/>
<Int32 name="mode" valueReference="5" causality="parameter" variability="fixed" start="1"/>
<Boolean name="on" valueReference="6" causality="input" start="false"/>
<Int32 name="gear" valueReference="7" causality="input" start="0"/>
<String name="label" valueReference="8" causality="parameter" variability="fixed">
<Start value="none"/></String>
<Float64 name="speed out" valueReference="10" causality="output" unit="rpm"/>
<Float64 name="temperature out" valueReference="11" causality="output" unit="degC"/>
<Float64 name="moment out" valueReference="12" causality="output" unit="kNm"/>
<Float64 name="plain out" valueReference="13" causality="output"/>
<Boolean name="is on" valueReference="14" causality="output"/>
<Int32 name="gear out" valueReference="15" causality="output"/>
<Int32 name="mode out" valueReference="16" causality="output"/>
<Int32 name="is given" valueReference="17" causality="output"/>
<Float64 name="three out" valueReference="20" causality="output"><Dimension start="3"/></Float64>
<Float64 name="three" valueReference="30" causality="input" start="0 0 0">
<Dimension start="3"/></Float64>
"""
UNITS = """<UnitDefinitions>
<Unit name="rpm"><BaseUnit s="-1" rad="1" factor="0.10471975511965977"/></Unit>
<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>
<Unit name="kNm"><BaseUnit kg="1" m="2" s="-2" factor="1000"/></Unit>
</UnitDefinitions>"""


@pytest.fixture(scope="module")
def feedthrough(tmp_path_factory):
    folder = tmp_path_factory.mktemp("feedthrough")
    return c_unit(folder, "feedthrough", SIGNALS, FEEDTHROUGH, units=UNITS, arrays=(20, 30))


def test_signals_of_all_types_arrive_in_si_units(feedthrough):
    given = {"speed": 50.0, "temperature": 300.0, "moment": 4e3, "plain": 7.0}
    given |= {f"three_{i}": float(i) for i in (1, 2, 3)}
    unit = from_fmu(feedthrough, axis_k_1=1.0, mode=4, label="given", on=1.0, gear=3.0, **given)
    system = lp.assemble(lp.compose(unit=unit))
    for name, unit_of_it in (("speed", "rad/s"), ("temperature", "K"), ("moment", "N.m")):
        assert system.quantity(f"unit.{name}").unit == unit_of_it
    run = lp.simulate(lp.assemble(lp.compose(unit=unit)), until=0.1)
    expected = {"is_on": 1, "gear_out": 3, "mode_out": 4, "is_given": 1}
    expected |= {f"{n}_out": given[n] for n in ("speed", "temperature", "moment", "plain")}
    expected |= {f"three_out_{i}": float(2 * i - 1) for i in (1, 2, 3)}
    for name, value in expected.items():
        assert abs(run[f"unit.{name}"][-1] - value) <= 1e-12 * abs(value), name
    with pytest.raises(
        errors.DeclarationError, match=r"^unit .feedthrough.: mode = 1.5: .* of type Int32"
    ):
        lp.assemble(lp.compose(unit=unit.with_({"mode": 1.5})))
    doubled = lp.simulate(run.system, until=0.1, parameters={"unit.axis_k_1": 2.0})
    assert abs(doubled["unit.speed_out"][-1] - 100.0) < 1e-12


THREE = ("three_1", "three_2", "three_3")


def chain_of(path, names):
    """Units that pass a signal on, declared in an order of their own."""

    def connections(m):
        yield lp.connect(m.first.plain_out, m.hold.u)
        yield lp.connect(m.hold.y, m.second.plain)

    idle = dict.fromkeys(("speed", "temperature", "moment", "on", "gear", *THREE), 0.0)
    idle |= {"axis_k_1": 1.0, "T_s": T_S}
    parts = {
        "first": from_fmu(path, plain=sin(30 * lp.time), **idle),
        "second": from_fmu(path, **idle),
        "hold": SampleHold(T_s=T_S),
    }
    return lp.assemble(lp.compose(**{n: parts[n] for n in names}, connections=connections))


@pytest.mark.parametrize("names", [("first", "hold", "second"), ("second", "hold", "first")])
def test_a_value_passes_all_units_within_one_instant(feedthrough, names):
    times = np.arange(0.5, 30) * T_S
    run = lp.simulate(chain_of(feedthrough, names), until=0.3, grid=times)
    exact = np.sin(30 * np.floor(times / T_S) * T_S)
    assert np.abs(run["second.plain_out"] - exact).max() < 1e-12


def test_what_needs_equations_is_refused_by_name(exported, tmp_path):
    system = drive(unit_of(exported), held=False)
    final = lp.functionals.final("rotor.w")
    for ask in (
        lambda: lp.gradient(system, of=[final], to=["rotor.J"], until=0.1),
        lambda: lp.sensitivity(system, of=["rotor.w"], to=["rotor.J"], until=0.1),
        lambda: lp.periodic(system, period=T_S),
        lambda: lp.export_fmu(system, tmp_path / "x.fmu"),
        lambda: lp.exchange.export_modelica(system, tmp_path / "x.mo"),
    ):
        with pytest.raises(errors.OptionError, match=r"pi asks unit 'pi_3.0.fmu'"):
            ask()
    assert "held: pi" in str(lp.linearise(system))


LATE = """
#include <stdbool.h>
static void begin(void) { memset(v, 0, sizeof v); }
static int step(void) {
  if (to < 0.5) return 0;
  switch ((int)v[0]) {
    case 1: abort();
    case 2: *(volatile int*)0 = 1;
    case 3: tell(0, %s3, %s"the valve %s", "is stuck"); return 3;
    case 4: v[9] = 0.0 / 0.0; return 0;
    case 5: return -1;
    case 6: exit(7);
  }
  return 0; }
static bool at_event(double* next) { return false; }
static void output(void) { v[1] = v[9]; }
"""
CHOICE = {
    "3.0": '<Float64 name="fault" valueReference="0" causality="parameter" variability="fixed" '
    'start="0"/><Float64 name="y" valueReference="1" causality="output"/>',
    "2.0": '<ScalarVariable name="fault" valueReference="0" causality="parameter" '
    'variability="fixed"><Real start="0"/></ScalarVariable>'
    '<ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>',
}


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_unit_that_fails_is_named_and_what_was_computed_is_kept(tmp_path, version):
    code = LATE.replace("%s3, %s", '"u", 3, "c", ' if version == "2.0" else '3, "c", ', 1)
    if version == "3.0":
        code = code.replace('"the valve %s", "is stuck"', '"the valve is stuck"')
    path = c_unit(tmp_path, "late", CHOICE[version], code, version=version)
    system = lp.assemble(lp.compose(valve=from_fmu(path, T_s=0.1)))
    faults = {
        1.0: "its binary crashed .SIGABRT",
        2.0: "its binary crashed .SIGSEGV",
        3.0: "It said: the valve is stuck",
        4.0: "its output y is nan",
        6.0: "its binary crashed .exit code 7",
    }
    if version == "3.0":
        faults[5.0] = "it asks to end the simulation"
    for fault, text in faults.items():
        with pytest.raises(errors.SolverError, match=text) as caught:
            lp.simulate(system, until=1.0, parameters={"valve.fault": fault})
        assert "at t = 0.5 s valve asks unit 'late.fmu'" in str(caught.value)
        assert caught.value.partial.t[-1] == 0.5
        assert len(caught.value.partial.t) > 100
    assert lp.simulate(system, until=1.0).t[-1] == 1.0
    swept = lp.sweep(
        system,
        over={"valve.fault": [0.0, 1.0, 0.0, 3.0]},
        until=1.0,
        of={"y": lp.functionals.final("valve.y")},
    )
    assert np.array_equal(np.isnan(swept["y"]), [False, True, False, True])
    assert "SIGABRT" in str(swept)


def without(name):
    return lambda folder: folder / name


def other_platform(folder):
    import zipfile

    with zipfile.ZipFile(folder / "pi_2.0.fmu") as held:
        text = held.read("modelDescription.xml")
    path = folder / "windows.fmu"
    with zipfile.ZipFile(path, "w") as made:
        made.writestr("modelDescription.xml", text)
        made.writestr("binaries/win64/PI.dll", b"")
    return path


def text_file(folder):
    path = folder / "text.fmu"
    path.write_text("no unit")
    return path


@pytest.mark.parametrize(
    ("path", "options", "text"),
    [
        (without("none.fmu"), {}, "there is no file"),
        (text_file, {}, "cannot be read as a unit of FMI"),
        (other_platform, {}, "has binaries for win64, not for linux64"),
        (without("pi_3.0.fmu"), {"kind": "both"}, "'both'"),
        (without("pi_3.0.fmu"), {"units": {"wantd": "rad/s"}}, "'wantd'.*wanted"),
        (without("pi_3.0.fmu"), {"outputs": ["mesured"]}, "'mesured'.*measured"),
        (without("pi_3.0.fmu"), {"gain": 3.0}, "PI has no 'gain'"),
        (without("pi_3.0.fmu"), {"k": "3 N.m"}, "must be of the kind N.m.s/rad"),
    ],
)
def test_bad_input_is_told(exported, path, options, text):
    with pytest.raises(errors.LumpedError, match=text):
        from_fmu(path(exported), **options)


def test_a_unit_without_a_step_needs_one_and_one_with_clocks_is_refused(exported, tmp_path):
    with pytest.raises(errors.ParameterError, match="T_s"):
        lp.assemble(lp.compose(pi=from_fmu(exported / "pi_3.0.fmu", wanted=1.0, measured=0.0)))
    variables = (
        '<Clock name="tick" valueReference="9" causality="input" intervalVariability="constant"'
    )
    path = c_unit(tmp_path, "ticking", CHOICE["3.0"] + variables + ' intervalDecimal="1"/>', STAIR)
    with pytest.raises(errors.DeclarationError, match=r"has clocks .tick."):
        from_fmu(path)
    unknown = CHOICE["3.0"].replace('name="y"', 'name="y" unit="furlong"')
    path = c_unit(
        tmp_path,
        "furlong",
        unknown,
        STAIR,
        units=UNITS.replace("rpm", "furlong", 1).replace(
            '<BaseUnit s="-1" rad="1" factor="0.10471975511965977"/>', ""
        ),
    )
    with pytest.raises(errors.DeclarationError, match="'furlong'"):
        from_fmu(path)
    assert from_fmu(path, units={"y": "kN"}) is not None
