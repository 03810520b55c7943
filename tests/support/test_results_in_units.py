"""Results in the units that were chosen, against the arrays in SI units and factors by hand."""

import re
from functools import cache
from math import pi

import numpy as np
import pytest
from rows import assemble_row

import lumped as lp
from lumped import functionals as fun
from lumped.cli import main
from lumped.components import Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptionError, UnitError, UnknownNameError
from lumped.vibration import Limit, order_response, verdict

RPM = 60 / (2 * pi)
SHOWN = {
    "rad/s": ("rpm", RPM),
    "N.m": ("kN.m", 1e-3),
    "rad": ("deg", 180 / pi),
    "Hz": ("1/min", 60.0),
    "kg.m2": ("kg.cm2", 1e4),
    "N.m/rad": ("kN.m/rad", 1e-3),
    "W": ("kW", 1e-3),
    "J": ("kJ", 1e-3),
    "N.m.s/rad": ("kN.m.s/rad", 1e-3),
    "s": ("ms", 1e3),
}
"""Units that are chosen, and their factors."""
CHOICE = {unit: shown for unit, (shown, _) in SHOWN.items()}
FACTORS = {unit: factor for unit, (_, factor) in SHOWN.items()}
LAST = re.compile(r"(?:^|, )([A-Za-z][\w./]*)$")


@cache
def system():
    return assemble_row(
        motor=Torque(tau=40.0),
        a=Inertia(J=2.0),
        shaft=SpringDamper(c=300.0, d=0.5),
        b=Inertia(J=1.0),
        mount=SpringDamper(c=80.0, d=0.4),
        wall=Fixed(),
    )


@cache
def run():
    return lp.simulate(system(), until=0.8, grid=200)


@cache
def response():
    excitations = {"motor.tau": {1: 2000.0, 2: 500j}}
    return order_response(
        system(), speeds=[5.0, 8.0, 12.0], of=["shaft.tau", "a.w"], excitations=excitations
    )


@cache
def modes():
    return lp.modes(system())


RESULTS = {
    "run": run,
    "point": lambda: run().point(0.5),
    "modes": modes,
    "energies": lambda: lp.vibration.modal_energies(modes()),
    "campbell": lambda: lp.campbell(system(), speeds=[1.0, 40.0], orders=[1, 2]),
    "order response": response,
    "verdict": lambda: verdict(response(), [Limit("shaft.tau", 300.0), Limit("a.w", 9.0)]),
    "order sensitivity": lambda: lp.vibration.order_sensitivity(response(), "shaft.tau"),
    "masses": lambda: lp.vibration.mass_elastic(modes(), shaft="a.phi"),
    "holzer": lambda: lp.vibration.mass_elastic(modes(), shaft="a.phi").holzer(1),
    "frequency response": lambda: lp.frequency_response(
        system(), inputs=["motor.tau"], outputs=["a.w"], hertz=np.linspace(0.5, 5.0, 40)
    ),
    "gradient": lambda: lp.gradient(
        system(), of=[fun.peak("shaft.tau"), fun.final("a.w")], by=["a.J"], until=0.4
    ),
    "sensitivity": lambda: lp.sensitivity(
        system(), of=["shaft.tau", fun.peak("a.w")], by=["a.J"], until=0.4
    ),
    "ensemble": lambda: lp.ensemble(
        system(), over={"a.J": [1.0, 2.0, 3.0]}, until=0.4, of={"most": fun.peak("shaft.tau")}
    ),
    "sizing": lambda: lp.simulation.sizing(run(), of=("motor.tau", "a.w")),
}
MADE = {name: cache(make) for name, make in RESULTS.items()}


def told(result, units):
    with lp.display_units(units):
        return repr(result)


def cells(text):
    return [re.split(r"\s{2,}", line.strip()) for line in text.splitlines()]


@pytest.mark.parametrize("name", MADE)
def test_printed_tables_have_the_chosen_units_and_numbers_times_their_factors(name):
    """Cells that differ are a unit, a head with one, or a number; lines of text are left out."""
    result, changed = MADE[name](), 0
    plain, shown = (cells(told(result, units)) for units in (None, CHOICE))
    pairs = [(a, b) for a, b in zip(plain, shown, strict=True) if len(a) > 1 and len(a) == len(b)]
    for before, after in pairs:
        for a, b in zip(before, after, strict=True):
            try:
                was, now = float(a), float(b)
            except ValueError:
                for unit in LAST.findall(a) if a != "speed, rad/s" else ():  # which stands beside
                    assert (unit in FACTORS) == (unit not in LAST.findall(b))
                continue
            if was and was != now:
                nearest = min(FACTORS.values(), key=lambda f: abs(np.log(abs(now / was) / f)))
                assert now / was == pytest.approx(nearest, rel=2e-5)
                changed += 1
    assert changed > 0


def test_a_row_of_a_run_is_that_of_its_array():
    units = {"shaft.phi_rel": "deg"}
    row = next(row for row in cells(told(run(), units)) if row[0] == "shaft.phi_rel")
    turned = run()["shaft.phi_rel"] * 180 / pi
    expected = [turned[0], turned[-1], turned.min(), turned.max()]
    assert [float(cell) for cell in row[1:5]] == pytest.approx(expected, rel=1e-5)
    assert row[5] == "deg"


def test_arrays_stay_in_si_units():
    expected = run()["a.w"].copy()
    with lp.display_units(CHOICE):
        np.testing.assert_array_equal(run()["a.w"], expected)
        np.testing.assert_array_equal(run().table(["a.w"])[:, 0], expected)
        assert run().point(0.5)["a.w"] == run().point(0.5)["a.w"]
        np.testing.assert_array_equal(lp.simulate(system(), until=0.8, grid=200)["a.w"], expected)


def test_curves_and_labels_of_a_run():
    figure = run().plot(["a.w", "shaft.tau"], units={"w": "rpm", "N.m": "kN.m", "s": "ms"})
    speed, torque = figure.axes
    np.testing.assert_allclose(speed.lines[0].get_ydata(), RPM * run()["a.w"], rtol=1e-14)
    np.testing.assert_allclose(speed.lines[0].get_xdata(), 1e3 * run().t, rtol=1e-14)
    np.testing.assert_allclose(torque.lines[0].get_ydata(), 1e-3 * run()["shaft.tau"], rtol=1e-14)
    assert speed.get_ylabel().endswith(", rpm")
    assert torque.get_ylabel().endswith(", kN.m")
    assert torque.get_xlabel() == "time, ms"


def test_data_frames_and_data_sets_carry_the_units():
    pytest.importorskip("xarray")
    frame = run().to_pandas(["a.w", "shaft.tau"], units={"a.w": "rpm"})
    np.testing.assert_allclose(frame["a.w"], RPM * run()["a.w"], rtol=1e-14)
    np.testing.assert_array_equal(frame["shaft.tau"], run()["shaft.tau"])
    assert frame.attrs["units"] == {"a.w": "rpm", "shaft.tau": "N.m"}
    with lp.display_units({"N.m": "kN.m"}):
        data = run().to_xarray(["shaft.tau"])
    np.testing.assert_allclose(data["shaft.tau"], 1e-3 * run()["shaft.tau"], rtol=1e-14)
    assert data["shaft.tau"].attrs["units"] == "kN.m"


@pytest.mark.parametrize("ending", ["csv", "nc", "npz"])
def test_files_have_other_units_only_if_they_are_asked_for(tmp_path, ending):
    with lp.display_units(CHOICE):
        plain = lp.load(run().save(tmp_path / f"plain.{ending}", ["a.w"]))
    shown = lp.load(run().save(tmp_path / f"shown.{ending}", ["a.w"], units={"w": "rpm"}))
    np.testing.assert_array_equal(plain["a.w"], run()["a.w"])
    np.testing.assert_allclose(shown["a.w"], RPM * run()["a.w"], rtol=1e-14)
    assert (plain.units["a.w"], shown.units["a.w"]) == ("rad/s", "rpm")


def test_axes_of_vibrations():
    diagram = MADE["campbell"]()
    (axis,) = diagram.plot(units={"rad/s": "rad/s", "Hz": "1/min"}).axes
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("speed, rad/s", "frequency, 1/min")
    np.testing.assert_allclose(axis.lines[0].get_xdata(), diagram.speeds, rtol=1e-14)
    np.testing.assert_allclose(axis.lines[0].get_ydata(), 60 * diagram.hertz[:, 0], rtol=1e-14)
    ray = axis.lines[diagram.hertz.shape[1]]  # the first order, in turns for each minute
    np.testing.assert_allclose(ray.get_ydata(), RPM * diagram.speeds, rtol=1e-14)
    (usual,) = diagram.plot().axes
    assert usual.get_xlabel() == "speed, 1/min"

    axis = response().plot(["shaft.tau"], units={"N.m": "kN.m", "speed": "rpm"}).axes[0]
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("speed, rpm", "amplitude, kN.m")
    np.testing.assert_allclose(axis.lines[0].get_xdata(), RPM * response().speeds, rtol=1e-14)
    size = 1e-3 * response().magnitude("shaft.tau", 1)
    np.testing.assert_allclose(axis.lines[0].get_ydata(), size, rtol=1e-14)

    found = MADE["frequency response"]()
    size, phase = found.plot(units={"Hz": "kHz", "a.w": "rpm"}).axes
    assert (size.get_ylabel(), phase.get_xlabel()) == ("magnitude, rpm/(N.m)", "frequency, kHz")
    expected = RPM * found.magnitude("a.w", "motor.tau")
    np.testing.assert_allclose(size.lines[0].get_ydata(), expected, rtol=1e-14)
    np.testing.assert_allclose(size.lines[0].get_xdata(), 1e-3 * found.hertz, rtol=1e-14)

    table = MADE["holzer"]()
    bars = table.plot(units={"N.m": "kN.m"}).axes[1]
    assert bars.get_ylabel() == "torque in the shafts, kN.m"
    heights = [bar.get_height() for bar in bars.patches]
    expected = [1e-3 * table.referred.torque(part) for part in ("shaft", "mount")]
    assert heights == pytest.approx(expected, rel=1e-14)

    title = modes().plot(units={"Hz": "1/min"}).axes[0].get_title()
    assert title.startswith(f"{60 * modes().hertz[0]:.4g} 1/min, ")


def test_histograms_and_motors():
    found = MADE["ensemble"]()
    axis = found.plot(units={"most": "kN.m"}).axes[0]
    assert axis.get_xlabel() == "most, kN.m"
    (low, high) = axis.patches[0].get_x(), axis.patches[-1].get_x() + axis.patches[-1].get_width()
    expected = 1e-3 * found["most"].min(), 1e-3 * found["most"].max()
    assert (low, high) == pytest.approx(expected, rel=1e-12)
    np.testing.assert_allclose(
        found.to_pandas(units={"N.m": "kN.m"})["most"], 1e-3 * found["most"], rtol=1e-14
    )
    motor = lp.simulation.sizing(
        run(), of=("motor.tau", "a.w"), rated=50.0, maximum=[(5.0, 90.0), (9.0, 60.0)]
    )
    axis = motor.plot(units={"rad/s": "rpm", "N.m": "kN.m"}).axes[0]
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("angular velocity, rpm", "torque, kN.m")
    assert np.max(axis.lines[1].get_ydata()) == pytest.approx(0.09)
    assert np.max(axis.lines[1].get_xdata()) == pytest.approx(9 * RPM)
    np.testing.assert_allclose(axis.lines[0].get_xdata(), RPM * run()["a.w"], rtol=1e-14)


def test_titles_of_rankings_tell_the_value_in_the_unit_of_its_quantity():
    found = MADE["gradient"]()
    value = 1e-3 * found.values[0]
    for units in ({"shaft.tau": "kN.m"}, {"tau": "kN.m"}, {"peak(shaft.tau)": "kN.m"}):
        (text,) = found.plot(units=units).texts
        assert text.get_text().endswith(f"= {value:.4g} kN.m")


def draw(units):
    return run().plot(units=units)


@pytest.mark.parametrize(
    ("use", "error", "text"),
    [
        (lambda: draw({"shaft.taux": "kN.m"}), UnknownNameError, "Nearest: shaft.tau"),
        (lambda: draw({"shaft.phi_rel": "kN.m"}), UnitError, r"shaft\.phi_rel \(rad\).*'kN\.m'"),
        (lambda: draw({"rad/s": "Hz"}), UnitError, "a speed may be in rpm"),
        (lambda: draw("imperial"), OptionError, "'engineering'"),
        (lambda: run().to_pandas(units={"nobody": "kN"}), UnknownNameError, "'nobody'"),
        (lambda: response().plot(units={"nobody": "kN"}), UnknownNameError, "'nobody'"),
        (lambda: MADE["ensemble"]().plot(units={"most": "rpm"}), UnitError, "most"),
        (lambda: MADE["ensemble"]().plot(["least"]), OptionError, "there is no 'least'"),
        (lambda: MADE["campbell"]().plot(units={"Hz": "rpm"}), UnitError, "Hz.*'rpm'"),
    ],
)
def test_wrong_units_are_refused(use, error, text):
    with pytest.raises(error, match=text):
        use()


def test_a_report_has_the_units_of_engineers_unless_others_are_asked_for(tmp_path):
    found = order_response(
        system(), speeds=[5.0, 8.0], of=["shaft.tau"], excitations={"motor.tau": {1: 2000.0}}
    )

    def page(units=None):
        target = lp.drawing.torsional_report(found, tmp_path / "r.html", units=units)
        return target.read_text(encoding="utf-8")

    peak = found.synthesis("shaft.tau").maximum.max()
    usual, asked = page(), page({"tau": "MN.m", "rad/s": "rad/s"})
    assert f">{1e-3 * peak:.5g}<" in usual
    assert "maximum, kN.m" in usual
    assert "at, 1/min" in usual
    assert f">{1e-6 * peak:.5g}<" in asked
    assert "maximum, MN.m" in asked
    assert "1/min" not in asked


def test_the_command_takes_units(tmp_path, capsys):
    module = tmp_path / "own.py"
    module.write_text(
        "import lumped as lp\n"
        "from lumped.components import Inertia\n"
        "def report(path, parameters):\n"
        "    return lp.drawing.report_html(lp.assemble(Inertia(J=0.02)), path)\n",
        encoding="utf-8",
    )
    target = tmp_path / "page.html"
    assert main(["report", str(module), "-o", str(target), "--units", "kg.m2=kg.cm2"]) == 0
    assert re.search(r">200</td>\s*<td>kg\.cm2<", target.read_text(encoding="utf-8"))
    assert main(["report", str(module), "--units", "kg.m2"]) == 2
    assert "'engineering'" in capsys.readouterr().err
