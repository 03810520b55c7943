"""A newcomer's session in a notebook, from a model to its page with sliders, executed headless."""

import inspect

import nbformat
import pytest
from nbclient import NotebookClient

CELLS = {
    "imports": """
        import inspect, pickle, urllib.request
        import numpy as np
        import lumped as lp
        from lumped.components import Inertia, SpringDamper, Torque, TransferFunction
    """,
    "help": "print(inspect.signature(Inertia)); print(inspect.getdoc(Inertia))",
    "model": """
        model = lp.compose(
            motor=Torque(tau=12.0), a=Inertia(J=2.0), shaft=SpringDamper(c=300.0), b=Inertia(J=1.0),
            connections=lambda m: lp.chain(m.motor, m.a, m.shaft, m.b),
        )
        model
    """,
    "system": "system = lp.assemble(model); system",
    "run": "run = lp.simulate(system, until=2.0, grid=200); run",
    "names": """
        print("shaft.tau" in run, "a.phi" in run, run[["a.w", "b.w"]].shape)
        from IPython.core.completer import provisionalcompleter
        for typed in ('run["shaft.t', "run[system.model.shaft.t"):
            with provisionalcompleter():
                found = get_ipython().Completer.completions(typed, len(typed))
                print([completion.text for completion in found])
        print(np.array_equal(run[system.model.shaft.tau], run["shaft.tau"]))
    """,
    "centre of mass": "print(f\"{(2 * run['a.phi'][-1] + run['b.phi'][-1]) / 3:.6f}\")",
    "units": """
        with lp.display_units({"w": "rpm"}):
            print([axis.get_ylabel() for axis in run.plot(["a.w"]).axes])
    """,
    "plot": "run.plot(['a.w'])",
    "plotly": """
        figure = run.plot(["a.w"], backend="plotly")
        print(type(figure).__module__.split(".")[0], np.array_equal(figure.data[0].y, run["a.w"]))
    """,
    "modes": "modes = lp.modes(system); modes",
    "kept": """
        again = pickle.loads(pickle.dumps(run))
        print(np.array_equal(again["b.w"], run["b.w"]))
    """,
    "file": """
        import os, tempfile
        saved = lp.load(run.save(os.path.join(tempfile.mkdtemp(), "run.nc")))
        print("shaft.tau" in saved, saved["b.w"].shape)
        saved
    """,
    "control": """
        import control
        plant = lp.linearise(system, inputs=["motor.tau"], outputs=["b.w"]).to_control()
        print(sorted(abs(control.poles(plant).imag).round(6))[-1])
        block = TransferFunction.of(control.tf([1.0], [0.5, 1.0]))
        block
    """,
    "page": """
        page = lp.explore(system, until=1.0, sliders=["shaft.c"])
        print(urllib.request.urlopen(page.url).status, page.url.startswith("http://127.0.0.1:"))
        page
    """,
    "closed": "page.stop(); print(page)",
}


@pytest.fixture(scope="module")
def shown():
    """Printed text and HTML of each cell, and the picture that is no HTML."""
    cells = [nbformat.v4.new_code_cell(inspect.cleandoc(text)) for text in CELLS.values()]
    book = nbformat.v4.new_notebook(cells=cells)
    NotebookClient(book, timeout=120, kernel_name="python3").execute()
    found = {}
    for name, cell in zip(CELLS, book.cells, strict=True):
        printed = "".join(out.text for out in cell.outputs if out.output_type == "stream")
        data = [out.data for out in cell.outputs if "data" in out]
        html = "".join(each.get("text/html", "") for each in data)
        found[name] = printed, html, [each["image/png"] for each in data if "image/png" in each]
    return found


def test_help_names_parameters_with_units(shown):
    printed = shown["help"][0]
    assert "J:" in printed
    assert "kg.m2" in printed


@pytest.mark.parametrize("cell", ["model", "system", "run", "modes", "file"])
def test_results_are_shown_with_pictures(shown, cell):
    assert "<svg" in shown[cell][1]


def test_names_are_told_and_completed(shown):
    printed = shown["names"][0]
    told, keys, paths, same = printed.splitlines()
    assert told == "True True (201, 2)"
    assert keys == "['shaft.tau']"
    assert paths == "['tau']"
    assert same == "True"


def test_numbers_are_those_of_the_closed_forms(shown):
    """12 N.m move 3 kg.m2 for 2 s; the natural frequency is sqrt(c (1/J_a + 1/J_b))."""
    assert float(shown["centre of mass"][0]) == pytest.approx(12.0 / 3.0 * 2.0**2 / 2)
    assert float(shown["control"][0]) == pytest.approx((300.0 * 1.5) ** 0.5, abs=1e-6)


def test_plots_have_chosen_units_and_another_backend(shown):
    assert len(shown["plot"][2]) == 1
    assert "rpm" in shown["units"][0]
    assert shown["plotly"][0].split() == ["plotly", "True"]


def test_results_can_be_kept(shown):
    assert shown["kept"][0].strip() == "True"
    assert shown["file"][0].strip() == "True (201,)"


def test_the_page_with_sliders_is_served_to_this_computer_alone_until_it_is_closed(shown):
    printed, html, _ = shown["page"]
    assert printed.split() == ["200", "True"]
    assert "<iframe" in html
    assert "closed" in shown["closed"][0]
