"""Quantities whose names files use for something else."""

import DyMat
import numpy as np
import pytest

import lumped as lp
from lumped.errors import DeclarationError


def rising(**declared):
    """A model of states that rise by 2 each second from 3, and what else is declared."""

    def equations(self):
        for name, quantity in declared.items():
            if isinstance(quantity, lp.Var):
                yield lp.der(getattr(self, name)) == 2.0

    space = {"__doc__": "Under test.", "equations": equations, **declared}
    return type("Rising", (lp.Component,), space)()


def state():
    return lp.var("1", "rises", 3.0, state="always")


@pytest.mark.parametrize(
    ("what", "declared"),
    [("quantity", {"time": state()}), ("parameter", {"time": lp.param("s", "delay", 1.0)})],
)
def test_what_is_called_time_in_the_model_is_refused(what, declared):
    with pytest.raises(DeclarationError, match=rf"Rising: a {what} .* 'time'.* Rename it"):
        lp.assemble(rising(x=state(), **declared))


def test_a_quantity_of_a_part_may_be_called_time(tmp_path):
    model = lp.compose(time=rising(x=state()), part=rising(time=state()))
    run = lp.simulate(lp.assemble(model), until=1.0)
    for suffix in ("nc", "npz", "csv"):
        read = lp.load(run.save(tmp_path / f"run.{suffix}"))
        for name in ("part.time", "time.x"):
            assert np.abs(read[name] - (3.0 + 2.0 * read.t)).max() < 1e-9
        assert read["time"][-1] == 1.0


KEYS = [
    *("t", "x", "names", "values", "units", "texts", "about", "states", "events", "index"),
    *("parameters", "parameter_names", "parameter_units", "model", "fingerprint", "checksum"),
    *("name", "description", "dataInfo", "data_1", "data_2", "Aclass", "parameter", "columns"),
]


def test_quantities_called_like_other_keys_of_files_are_read_back(tmp_path):
    made = {}
    for i, key in enumerate(KEYS):
        made[key] = lp.var("1", f"number {i}", float(i), state="always")
    run = lp.simulate(lp.assemble(rising(**made)), until=1.0, grid=4)
    expected = {key: i + 2.0 * run.t for i, key in enumerate(KEYS)}
    tables = [lp.load(run.save(tmp_path / f"run.{suffix}")) for suffix in ("nc", "npz", "csv")]
    for table in (*tables, run.to_pandas(), run.to_xarray()):
        for key, values in expected.items():
            assert np.abs(np.asarray(table[key]) - values).max() < 1e-9
    dymola = DyMat.DyMatFile(str(run.save(tmp_path / "run.mat")))
    for key, values in expected.items():
        assert np.abs(dymola.data(key) - values).max() < 1e-9
