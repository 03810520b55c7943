"""Calls of importers in any order: what each phase of the standard allows, and bad arguments."""

import ctypes as c
from types import SimpleNamespace

import numpy as np
import pytest
from fmus import fmpy

import lumped as lp
from lumped.components import Fixed, Inertia, SpringDamper, Torque
from lumped.ops import where

OK, DISCARD, ERROR = 0, 2, 3
EXCHANGE, COSIMULATION = 0, 1


ODD = "größer than 9 rad/s, <1> & \"yes\" or 'no' \\ ??/ %s #"


class Größe(lp.Component):
    """A body on a spring & "more"; a level that falls and cannot be negative."""

    fast: lp.Var = lp.var("1", ODD)
    level: lp.Var = lp.var("1", "level", start=1.0, state="always")
    drive: Torque = Torque(tau=1.0)
    body: Inertia = Inertia(J=2.0)
    spring: SpringDamper = SpringDamper(c=8.0, d=0.5)
    wall: Fixed = Fixed()

    def connections(self):
        yield from lp.chain(self.drive, self.body, self.spring, self.wall)

    def equations(self):
        yield self.fast == where(self.body.w > 9.0, 1.0, 0.0)
        yield lp.der(self.level) == -lp.ops.sqrt(self.level)


@pytest.fixture(scope="module", params=["2.0", "3.0"])
def exported(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("calls") / "unit.fmu"
    system = lp.assemble(Größe())
    lp.export_fmu(system, path, version=request.param, inputs=["drive.tau"], outputs=["fast"])
    facts, folder = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    kind = facts.coSimulation
    major = request.param[0]
    place = fmpy.platform if major == "2" else fmpy.platform_tuple
    name = f"{kind.modelIdentifier}{fmpy.sharedLibraryExtension}"
    library = c.CDLL(f"{folder}/binaries/{place}/{name}")
    names = {v.name: v.valueReference for v in facts.modelVariables}
    return SimpleNamespace(library=library, facts=facts, names=names, major=major)


LOG2 = c.CFUNCTYPE(None, c.c_void_p, c.c_char_p, c.c_int, c.c_char_p, c.c_char_p)
LOG3 = c.CFUNCTYPE(None, c.c_void_p, c.c_int, c.c_char_p, c.c_char_p)


class Callbacks(c.Structure):
    """Those of version 2.0."""

    _fields_ = (
        ("logger", LOG2),
        *((name, c.c_void_p) for name in ("allocate", "free", "finished", "environment")),
    )


def numbers(*values):
    return (c.c_double * max(len(values), 1))(*values)


def references(*values):
    return (c.c_uint32 * max(len(values), 1))(*values)


class Instance:
    """An instance and all calls of its version, by their short names."""

    def __init__(self, exported, kind):
        self.exported, self.kind, self.told = exported, kind, []
        self.prefix, self.facts = f"fmi{exported.major}", exported.facts
        token = self.facts.guid.encode()
        make = "Instantiate" + (
            "" if self.prefix == "fmi2" else ("ModelExchange", "CoSimulation")[kind]
        )
        function = getattr(exported.library, self.prefix + make)
        function.restype = c.c_void_p
        if self.prefix == "fmi2":
            self.log = LOG2(lambda *message: self.told.append(message[-1].decode()))
            self.callbacks = Callbacks(logger=self.log)
            found = function(b"one", kind, token, None, c.byref(self.callbacks), 0, 1)
        else:
            self.log = LOG3(lambda *message: self.told.append(message[-1].decode()))
            more = (True, True, None, c.c_size_t(0)) if kind else ()
            last = (None, self.log, None) if kind else (None, self.log)
            flags = (c.c_bool(f) if isinstance(f, bool) else f for f in (False, True, *more))
            found = function(b"one", token, None, *flags, *last)
        self.own = c.c_void_p(found)
        assert self.own

    def raw(self, name, *arguments):
        return getattr(self.exported.library, self.prefix + name)(self.own, *arguments)

    def free(self):
        self.raw("FreeInstance")

    def get(self, *names):
        return self.get_at(*(self.exported.names[n] for n in names))

    def get_at(self, *places):
        found, n = numbers(*[0.0] * len(places)), c.c_size_t(len(places))
        last = (n,) if self.prefix == "fmi3" else ()
        name = "GetFloat64" if last else "GetReal"
        status = self.raw(name, references(*places), n, found, *last)
        return status, list(found)[: len(places)]

    def set(self, **values):
        values = {name.replace("__", "."): value for name, value in values.items()}
        n = c.c_size_t(len(values))
        last = (n,) if self.prefix == "fmi3" else ()
        name = "SetFloat64" if last else "SetReal"
        places = references(*(self.exported.names[n] for n in values))
        return self.raw(name, places, n, numbers(*values.values()), *last)

    def setup(self, start=0.0):
        return self.raw("SetupExperiment", 0, c.c_double(0), c.c_double(start), 0, c.c_double(0))

    def initialise(self, start=0.0):
        more = (False, c.c_double(0), c.c_double(start), False, c.c_double(0))
        return self.raw("EnterInitializationMode", *(more if self.prefix == "fmi3" else ()))

    def derivative(self, name="GetDirectionalDerivative"):
        unknown, known = (references(self.exported.names[n]) for n in ("der(body.w)", "drive.tau"))
        one, found, room = c.c_size_t(1), numbers(0.0), numbers(1.0)
        if self.prefix == "fmi2":
            return self.raw(name, unknown, one, known, one, room, found)
        return self.raw(name, unknown, one, known, one, room, one, found, one)

    def update(self):
        if self.prefix == "fmi2":
            return self.raw("NewDiscreteStates", (c.c_double * 6)())
        return self.raw("UpdateDiscreteStates", *((c.c_bool * 1)() for _ in range(5)), numbers(0.0))

    def completed(self):
        return self.raw("CompletedIntegratorStep", 1, (c.c_int * 1)(), (c.c_int * 1)())

    def vector(self, name, count):
        found = numbers(*[0.0] * count)
        return self.raw(name, found, c.c_size_t(count))

    def step(self, begin=0.0, length=0.01):
        times = c.c_double(begin), c.c_double(length)
        if self.prefix == "fmi2":
            return self.raw("DoStep", *times, 1)
        flags = ((c.c_bool * 1)() for _ in range(3))
        return self.raw("DoStep", *times, True, *flags, numbers(0.0))

    def count(self, name):
        return self.raw(name, c.byref(c.c_size_t(0)))

    def keep(self):
        kept = c.c_void_p(None)
        name = "GetFMUstate" if self.prefix == "fmi2" else "GetFMUState"
        status = self.raw(name, c.byref(kept))
        self.raw("Free" + name[3:], c.byref(kept))
        return status

    def status(self):
        return self.raw("GetRealStatus", 2, numbers(0.0))

    def to(self, phase):
        """Go to a phase: instantiated, initialisation, event, continuous-time, step, terminated."""
        event = self.kind == COSIMULATION and self.prefix == "fmi3"
        end = "EnterStepMode" if event else None if self.kind else "EnterContinuousTimeMode"
        way = {"I": 0, "N": 1, "E": 2, "S": 3, "C": 3, "T": 4}[phase]
        calls = (self.initialise, lambda: self.raw("ExitInitializationMode"))
        calls += (lambda: self.raw(end) if end else OK, lambda: self.raw("Terminate"))
        assert [call() for call in calls[:way]] == [OK] * way
        return self


SHARED = {
    "EnterInitializationMode": (Instance.initialise, "I", "I"),
    "ExitInitializationMode": (None, "N", "N"),
    "EnterContinuousTimeMode": (None, "E", ""),
    "Reset": (None, "INECT", "INEST"),
    "GetFMUstate": (Instance.keep, "INECT", "INEST"),
    "GetDirectionalDerivative": (Instance.derivative, "NECT", "NEST"),
    "Update": (Instance.update, "E", "E"),
    "CompletedIntegratorStep": (Instance.completed, "C", ""),
    "SetReal": (lambda i: i.set(drive__tau=1.0), "INEC", "INES"),
    "SetContinuousStates": (lambda i: i.vector("SetContinuousStates", 3), "C", ""),
    "GetContinuousStates": (lambda i: i.vector("GetContinuousStates", 3), "NECT", ""),
    "GetEventIndicators": (lambda i: i.vector("GetEventIndicators", 1), "NECT", ""),
    "DoStep": (Instance.step, "", "S"),
}
ONLY = {
    "2": {
        "SetupExperiment": (Instance.setup, "I", "I"),
        "Terminate": (None, "EC", "S"),
        "GetReal": (lambda i: i.get("body.w")[0], "NECT", "NST"),
        "EnterEventMode": (None, "EC", ""),
        "SetTime": (lambda i: i.raw("SetTime", c.c_double(0)), "EC", ""),
        "GetDerivatives": (lambda i: i.vector("GetDerivatives", 3), "NECT", ""),
        "GetRealStatus": (Instance.status, "", "ST"),
        "Nominals": (lambda i: i.vector("GetNominalsOfContinuousStates", 3), "INECT", ""),
    },
    "3": {
        "Terminate": (None, "EC", "ES"),
        "GetFloat64": (lambda i: i.get("body.w")[0], "INECT", "INEST"),
        "GetAdjointDerivative": (lambda i: i.derivative("GetAdjointDerivative"), "NECT", "NEST"),
        "EnterEventMode": (None, "C", "S"),
        "EnterStepMode": (None, "", "E"),
        "SetTime": (lambda i: i.raw("SetTime", c.c_double(0)), "C", ""),
        "Rates": (lambda i: i.vector("GetContinuousStateDerivatives", 3), "NECT", ""),
        "Nominals": (lambda i: i.vector("GetNominalsOfContinuousStates", 3), "NECT", ""),
        "States": (lambda i: i.count("GetNumberOfContinuousStates"), "INECT", ""),
        "EnterConfigurationMode": (None, "", ""),
    },
}
"""Functions, and phases of model exchange and co-simulation in which the standard allows them."""


def test_each_function_may_be_called_in_the_phases_of_the_standard(exported):
    """FMI 2.0.4, 3.2.3 and 4.2.4; FMI 3.0, 2.3, 3.2 and 4.2. Any other call is an error."""
    calls = SHARED | ONLY[exported.major]
    for kind, phases in ((EXCHANGE, "INECT"), (COSIMULATION, "INEST")):
        if exported.major == "2" and kind == COSIMULATION:
            phases = "INST"  # its events are its own
        for name, (call, *allowed) in calls.items():
            for phase in phases:
                unit = Instance(exported, kind).to(phase)
                found = call(unit) if call else unit.raw(name)
                expected = OK if phase in allowed[kind] else ERROR
                assert found == expected, (name, kind, phase, unit.told)
                assert bool(unit.told) is bool(expected)
                unit.free()


def test_after_an_error_values_can_be_read_and_the_unit_reset(exported):
    for kind in (EXCHANGE, COSIMULATION):
        unit = Instance(exported, kind).to("SC"[kind == EXCHANGE])
        status, before = unit.get("body.w", "drive.tau")
        kept, word = c.c_void_p(None), "FMUstate" if exported.major == "2" else "FMUState"
        assert unit.raw("Get" + word, c.byref(kept)) == OK
        assert unit.initialise() == ERROR
        assert "must not be called in the" in unit.told[-1]
        assert unit.get("body.w", "drive.tau") == (status, before) == (OK, before)
        assert (
            unit.raw("EnterContinuousTimeMode") == unit.step() == unit.set(drive__tau=2.0) == ERROR
        )
        assert unit.raw("Set" + word, kept) == unit.set(drive__tau=2.0) == OK
        unit.raw("Free" + word, c.byref(kept))
        assert unit.raw("Reset") == OK
        unit.to("SC"[kind == EXCHANGE])
        assert unit.get("body.w", "drive.tau") == (OK, before)
        unit.free()


def test_bad_arguments_are_refused_and_change_nothing(exported):
    unit = Instance(exported, COSIMULATION).to("N")
    for bad in (np.nan, np.inf):
        assert unit.set(drive__tau=7.0, body__w=bad) == DISCARD
        assert unit.set(drive__tau=7.0, body__J=bad) == DISCARD
    assert unit.set(drive__tau=7.0, body__J=-1.0) == DISCARD
    assert "body.J = -1 is out of range: it must be greater than 0" in unit.told[-1]
    assert unit.get("drive.tau", "body.w", "body.J") == (OK, [1.0, 0.0, 2.0])
    assert unit.set(drive__tau=7.0, body__J=3.0) == OK
    assert unit.get("der(body.w)") == (OK, [pytest.approx(7.0 / 3.0, rel=1e-14)])
    last = max(exported.names.values()) + 1
    for place in (last + 1, 2**31, 2**32 - 1):
        unit = Instance(exported, COSIMULATION).to("S")
        assert unit.get_at(place)[0] == ERROR
        assert f"value reference {place}" in unit.told[-1]
        unit.free()
    for begin, length in ((0.0, 0.0), (0.0, -0.1), (0.0, np.nan), (0.5, 0.1), (np.nan, 0.1)):
        unit = Instance(exported, COSIMULATION).to("S")
        assert unit.step(begin, length) == ERROR, (begin, length)
        unit.free()
    for name in ("GetContinuousStates", "SetContinuousStates", "GetEventIndicators"):
        unit = Instance(exported, EXCHANGE).to("C")
        assert unit.vector(name, 4) == ERROR
        assert "4 numbers where there are" in unit.told[-1]
        unit.free()


def oscillation(t, tau):
    """Speed from rest by the closed form: J w' + d w + c phi = tau."""
    J, stiffness, d = 2.0, 8.0, 0.5
    decay = d / (2 * J)
    own = np.sqrt(stiffness / J - decay**2)
    return tau / (J * own) * np.exp(-decay * t) * np.sin(own * t)


def test_instances_do_not_know_each_other_and_states_go_over(exported):
    """Two run by turns with other torques; a third takes up the bytes of the first's state."""
    units = {tau: Instance(exported, COSIMULATION) for tau in (0.5, -1.0)}
    for tau, unit in units.items():
        assert unit.set(drive__tau=tau) == OK
        unit.to("S")
    for k in range(20):
        for unit in units.values():
            assert unit.step(0.05 * k, 0.05) == OK
    for tau, unit in units.items():
        assert unit.get("body.w")[1][0] == pytest.approx(oscillation(1.0, tau), rel=1e-5)
    first, other = units.values()
    word = "FMUstate" if exported.major == "2" else "FMUState"
    back = "DeSerialize" if exported.major == "2" else "Deserialize"
    kept, size = c.c_void_p(None), c.c_size_t(0)
    assert first.raw("Get" + word, c.byref(kept)) == OK
    assert first.raw(f"Serialized{word}Size", kept, c.byref(size)) == OK
    stored = c.create_string_buffer(size.value)
    assert first.raw("Serialize" + word, kept, stored, size) == OK
    first.free()
    third, taken = Instance(exported, COSIMULATION), c.c_void_p(None)
    assert third.raw(back + word, stored, size, c.byref(taken)) == OK
    assert third.raw("Set" + word, taken) == OK
    assert third.step(1.0, 0.5) == OK
    assert third.get("body.w")[1][0] == pytest.approx(oscillation(1.5, 0.5), rel=1e-5)
    assert other.step(1.0, 0.5) == OK
    assert other.get("body.w")[1][0] == pytest.approx(oscillation(1.5, -1.0), rel=1e-5)
    for state in (kept, taken):
        third.raw("Free" + word, c.byref(state))
        assert not state
        third.raw("Free" + word, c.byref(state))
    stored[3] = bytes([stored.raw[3] ^ 1])  # of another model
    assert third.raw(back + word, stored, size, c.byref(taken)) == ERROR
    assert "not the bytes of a state of this model" in third.told[-1]
    assert not taken
    third.free()
    other.free()


def test_a_parameter_that_is_tuned_between_steps_acts_from_then_on(exported):
    """Twice the torque from rest, and back: differences of the closed form."""
    unit = Instance(exported, COSIMULATION).to("S")
    for k in range(20):  # the unit is ahead of its importer by then
        assert k != 10 or unit.set(drive__tau=0.2) == OK
        assert unit.step(0.05 * k, 0.05) == OK
    expected = oscillation(1.0, 1.0) + oscillation(0.5, 0.2 - 1.0)
    assert unit.get("body.w")[1][0] == pytest.approx(expected, rel=1e-5)
    unit.free()


def test_texts_of_any_letters_reach_the_importer(exported):
    facts = exported.facts
    assert facts.modelName == "Größe"
    assert facts.coSimulation.modelIdentifier.isascii()
    assert facts.description.startswith('A body on a spring & "more";')
    assert [v.description for v in facts.modelVariables if v.name == "fast"] == [ODD]
    unit = Instance(exported, EXCHANGE)
    assert unit.set(body__J=-1.0) == DISCARD
    assert unit.told[-1].startswith("Größe: body.J = -1")
    unit.free()


def test_a_trial_point_without_derivatives_can_be_left_again(exported):
    """A root of a negative number while the importer integrates."""
    unit = Instance(exported, EXCHANGE).to("C")
    name = "GetDerivatives" if exported.major == "2" else "GetContinuousStateDerivatives"
    assert unit.set(level=-1.0) == OK
    assert unit.vector(name, 3) == DISCARD
    assert "the derivative of level is not a finite number" in unit.told[-1]
    assert unit.set(level=4.0) == unit.vector(name, 3) == OK
    assert unit.get("der(level)") == (OK, [-2.0])
    unit.free()
