"""Energy balances of runs whose powers vary within a step, and of all kinds of ports."""

from dataclasses import replace

import numpy as np
import pytest
from rows import assemble_rows, in_a_row

import lumped as lp
from lumped.components import (
    CrankSlider,
    Damper,
    Fixed,
    FixedTemperature,
    Ground,
    Heated,
    Inertia,
    Resistor,
    Speed,
    VoltageSource,
    translation,
)
from lumped.errors import EquationError
from lumped.language.port import PortQuantity
from lumped.simulation.works import integrate_powers


def balance(system, **options):
    """Energy balance of a run."""
    return lp.simulate(system, certify=True, **options).certificate.energy


R_CRANK, L_ROD, RAM, SPEED = 0.1, 0.4, 5.0, 50.0


def driven_crank():
    """A ram on a crank of constant speed, which starts at dead centre."""
    return assemble_rows(
        "drive.flange crank.flange",
        "crank.slider ram.flange_a",
        drive=Speed(w=SPEED),
        crank=CrankSlider(r=R_CRANK, L=L_ROD),
        ram=translation.Mass(m=RAM),
        keep=["crank.flange.phi"],
    )


@pytest.mark.parametrize("until", [0.1, 1.0, 30.0])
def test_a_crank_at_constant_speed_gives_its_ram_what_that_stores(until):
    audit = balance(driven_crank(), until=until)
    y = R_CRANK * np.sin(SPEED * until)
    slope = -y * (1 + R_CRANK * np.cos(SPEED * until) / np.sqrt(L_ROD**2 - y**2))
    stored = 0.5 * RAM * (SPEED * slope) ** 2
    assert audit.change == pytest.approx(stored, rel=1e-6)
    assert audit.supplied == pytest.approx(stored, rel=1e-6)
    assert audit.error < 1e-9


def test_an_integral_that_does_not_settle_is_told(monkeypatch):
    monkeypatch.setattr("lumped.simulation.works._MOST_NODES", 0)
    audit = balance(driven_crank(), until=1.0)
    assert audit.error > abs(audit.supplied - audit.change) / audit.turnover > 1e-3


@pytest.mark.parametrize("power", [lambda t: np.cos(40 * t) ** 2, lambda t: np.abs(t - 0.3)])
def test_works_of_one_long_step_are_those_of_the_closed_form(power):
    run = lp.simulate(lp.assemble(in_a_row(body=Inertia(J=1.0))), until=1.0)

    def again(times):
        return replace(run, pieces=(replace(run.pieces[0], t=times),))

    works, unsettled = integrate_powers(
        again, lambda piece: power(piece.t)[:, None], np.array([0.0]), np.array([1.0]), 0.0
    )
    exact = 0.5 + np.sin(80) / 160 if power(0.3) > 1e-9 else (0.3**2 + 0.7**2) / 2
    assert unsettled == 0
    assert works == pytest.approx(exact, rel=1e-9)


class OilPort(lp.Port):
    """Pressure in Pa and volume flow in m3/s."""

    kind = "oil port"
    potential, potential_name = PortQuantity("Pa", "pressure", "potential"), "p"
    flow, flow_name = PortQuantity("m3/s", "volume flow into the component", "flow"), "q"


class Pump(lp.Component):
    """What the shaft gives, the oil takes."""

    flange = lp.Flange()
    oil = OilPort()
    V: lp.Param = lp.param("m3/rad", "displacement")

    def equations(self):
        yield self.oil.through() == -self.V * lp.der(self.flange.phi)
        yield self.flange.tau == self.V * self.oil.across()


class Hose(lp.Component):
    """Elastic hose with a leak."""

    oil = OilPort()
    C: lp.Param = lp.param("m3/Pa", "capacity", above=0)
    R: lp.Param = lp.param("Pa.s/m3", "resistance of the leak", above=0)

    def equations(self):
        p = self.oil.across()
        yield self.oil.through() == self.C * lp.der(p) + p / self.R

    def loss(self):
        return self.oil.across() ** 2 / self.R

    def stored(self):
        return self.C * self.oil.across() ** 2 / 2


def test_a_port_of_pressure_and_flow_carries_its_power():
    q, C, R, t = 1e-4, 1e-12, 1e10, 0.05
    system = assemble_rows(
        *("drive.flange pump.flange", "pump.oil hose.oil"),
        drive=Speed(w=100.0),
        pump=Pump(V=q / 100.0),
        hose=Hose(C=C, R=R),
    )
    audit = balance(system, until=t, rtol=1e-9)
    a, b = np.exp(-t / (R * C)), R * C
    supplied = q * q * R * (t - b * (1 - a))  # p = q R (1 - exp(-t / R C))
    assert audit.supplied == pytest.approx(supplied, rel=1e-7)
    assert audit.change == pytest.approx(C * (q * R * (1 - a)) ** 2 / 2, rel=1e-7)
    lost = q * q * R * (t - 2 * b * (1 - a) + b / 2 * (1 - a * a))
    assert audit.dissipated == pytest.approx(lost, rel=1e-7)
    assert dict(audit.works) == {"drive": pytest.approx(supplied, rel=1e-7)}
    assert audit.error < 1e-7
    assert audit.uncounted == ()
    assert repr(audit).count("\n") == 0


class Coil(lp.Component):
    """Inductance that says what it stores."""

    p = lp.Pin()
    n = lp.Pin()
    L: lp.Param = lp.param("H", "inductance", above=0)

    def equations(self):
        yield self.p.i + self.n.i == 0
        yield self.p.v - self.n.v == self.L * lp.der(self.p.i)

    def stored(self):
        return self.L * self.p.i**2 / 2


class Heater(Resistor):
    """Resistor that says what it turns to heat."""

    def loss(self):
        return self.R * self.i**2


class HotHeater(Heated, Heater):
    """Heater that warms what is around it."""


@pytest.mark.parametrize("is_hot", [False, True])
def test_what_a_source_gives_a_coil_stores_and_a_resistor_turns_to_heat(is_hot):
    v, R, L, t = 10.0, 2.0, 0.1, 0.2
    pins = ("source.p r.p", "r.n coil.p", "source.n coil.n ground.pin")
    parts = {"source": VoltageSource(v=v), "coil": Coil(L=L), "ground": Ground()}
    if is_hot:
        heated = {"r": HotHeater(R=R), "air": FixedTemperature(T=300.0)}
        system = assemble_rows(*pins, "r.heat air.port", **parts, **heated)
    else:
        system = assemble_rows(*pins, **parts, r=Heater(R=R))
    audit = balance(system, until=t, rtol=1e-9)
    a, T = np.exp(-R * t / L), L / R
    given = v * v / R * (t - T * (1 - a))
    lost = v * v / R * (t - 2 * T * (1 - a) + T / 2 * (1 - a * a))
    works = dict(audit.works)
    assert audit.change == pytest.approx(L * (v / R * (1 - a)) ** 2 / 2, rel=1e-6)
    assert works.pop("source") == pytest.approx(given, rel=1e-6)
    if is_hot:  # the air takes what is no more lost; 300 K do not count
        assert works.pop("air") == pytest.approx(-lost, rel=1e-6)
    assert not works
    assert audit.dissipated == pytest.approx(0 if is_hot else lost, rel=1e-6, abs=1e-9)
    assert audit.supplied == pytest.approx(given - (lost if is_hot else 0), rel=1e-6)
    assert audit.error < 1e-7


class GasPort(lp.Port):
    """Pressure in Pa and mass flow in kg/s, whose product is no power."""

    kind = "gas port"
    potential, potential_name = PortQuantity("Pa", "pressure", "potential"), "p"
    flow, flow_name = PortQuantity("kg/s", "mass flow into the component", "flow"), "m"


class Piston(lp.Component):
    """Body that a gas of given pressure drives: its torque is 2e-6 m3 times the pressure."""

    flange = lp.Flange()
    gas = GasPort()

    def equations(self):
        yield self.flange.tau == -2e-6 * self.gas.across()
        yield self.gas.through() == 0

    def stored(self):
        return 0 * self.flange.phi


class Bottle(lp.Component):
    """Gas of 5 MPa."""

    gas = GasPort()

    def equations(self):
        yield self.gas.across() == 5e6


def test_a_port_of_unknown_power_is_named(tmp_path):
    system = assemble_rows(
        *("bottle.gas piston.gas", "piston.flange body.flange_a"),
        bottle=Bottle(),
        piston=Piston(),
        body=Inertia(J=2.0),
    )
    run = lp.simulate(system, until=3.0, certify=True)
    audit = run.certificate.energy
    assert set(audit.uncounted) == {"bottle.gas", "piston.gas"}
    energy = 0.5 * 2.0 * (10.0 / 2.0 * 3.0) ** 2
    assert audit.change == pytest.approx(energy, rel=1e-9)
    assert audit.error == pytest.approx(1.0, rel=1e-6)  # all came from the gas
    assert "not counted are ports" in repr(run.certificate)
    text = lp.drawing.report_html(system, tmp_path / "x.html", runs={"": run}).read_text()
    assert "Not counted are ports" in text
    assert "bottle.gas, piston.gas" in text
    assert "the gap holds what flows there" in text
    assert "The gap is the error of the run" not in text


def test_a_certificate_tells_of_the_energies_in_its_last_line():
    model = in_a_row(body=Inertia(J=2.0, w=3.0), brake=Damper(d=1.0), wall=Fixed())
    certificate = lp.simulate(lp.assemble(model), until=1.0, certify=True).certificate
    assert repr(certificate).splitlines()[-1] == repr(certificate.energy)


@pytest.mark.parametrize("name", ["stored", "loss"])
@pytest.mark.parametrize("given", [5, "5 J", lambda self: "c x^2", lambda self: [self.w]])
def test_an_energy_that_is_no_method_or_no_expression_is_refused(name, given, tmp_path):
    kind = type("Odd", (Inertia,), {name: given})
    system = lp.assemble(in_a_row(body=kind(J=1.0), brake=Damper(d=1.0), wall=Fixed()))
    expected = rf"body \(Odd\): {name} gives .* def {name}\(self\), that returns an expression"
    with pytest.raises(EquationError, match=expected):
        lp.simulate(system, until=1.0, certify=True)
    with pytest.raises(EquationError, match=expected):
        lp.simulate(system, until=1.0).save(tmp_path / "run.npz")
