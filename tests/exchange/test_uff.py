"""Universal files: what is written is read, here and by pyuff, and agrees with closed forms."""

import numpy as np
import pytest
import pyuff
from rows import assemble_row

import lumped as lp
from lumped.components import Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptionError
from lumped.vibration import compare_response, frac, mac

NODES = {"motor.tau": 1, "a.phi": 1, "b.phi": 2, "b.w": 2}
J, STIFFNESS = 2.0, 900.0


def drive(damping):
    return assemble_row(
        motor=Torque(tau=0.0),
        a=Inertia(J=J),
        s=SpringDamper(c=STIFFNESS, d=damping),
        b=Inertia(J=J),
        g=SpringDamper(c=STIFFNESS, d=damping),
        wall=Fixed(),
    )


def exact(damping, hertz):
    """Angles of both for a unit torque on the first."""
    w = 2 * np.pi * hertz
    z = STIFFNESS + 1j * damping * w
    matrix = np.array([[z - J * w**2, -z], [-z, 2 * z - J * w**2]])
    return np.linalg.solve(matrix, [1.0, 0.0])


def test_a_frequency_response_comes_back_to_the_last_bit_and_for_pyuff(tmp_path):
    hertz = np.array([0.3, 1.1, 2.0, 7.77])
    outputs = ["a.phi", "b.w"]
    response = lp.frequency_response(drive(3.0), inputs=["motor.tau"], outputs=outputs, hertz=hertz)
    lp.exchange.write_uff(tmp_path / "f.uff", response, nodes=NODES)
    found = lp.exchange.read_uff(tmp_path / "f.uff")
    assert [(c.name, c.reference) for c in found.curves] == [(o, "motor.tau") for o in outputs]
    assert [(c.node, c.direction, c.reference_node, c.unit) for c in found.curves] == [
        (1, 4, 1, "rad"),
        (2, 4, 1, "rad/s"),
    ]
    for curve in found.curves:
        assert curve.kind == "frequency response"
        assert (curve.x == hertz).all()
        assert (curve.y == response[curve.name, "motor.tau"]).all()
    angles = np.array([exact(3.0, f) for f in hertz])
    expected = np.array([angles[:, 0], 2j * np.pi * hertz * angles[:, 1]])
    for curve, values in zip(pyuff.UFF(str(tmp_path / "f.uff")).read_sets(), expected, strict=True):
        error = np.abs(curve["data"] / values - 1).max()
        print(f"error {error:.1e}")
        assert error < 1e-10
        assert curve["func_type"] == 4
        assert curve["abscissa_spec_data_type"] == 18


def test_a_run_comes_back_to_the_last_bit(tmp_path):
    run = lp.simulate(drive(3.0), until=0.5, start={"a.phi": 0.1}, grid=np.linspace(0, 0.5, 37))
    lp.exchange.write_uff(tmp_path / "r.uff", run, nodes={"a.phi": 1, "b.w": 7})
    first, second = lp.exchange.read_uff(tmp_path / "r.uff").curves
    assert (first.kind, first.node, second.node, second.unit) == ("time", 1, 7, "rad/s")
    assert (first.x == run.t).all()
    assert (first.y == run["a.phi"]).all()
    assert (second.y == run["b.w"]).all()


@pytest.mark.parametrize("damping", [0.0, 3.0])
@pytest.mark.parametrize("kind", [55, 2414])
def test_mode_shapes_come_back_with_frequency_and_damping(tmp_path, damping, kind):
    modes = lp.modes(drive(damping))
    lp.exchange.write_uff(tmp_path / "m.uff", modes, nodes={"a.phi": 1, "b.phi": 2}, shapes=kind)
    assert {int(k) for k in pyuff.UFF(str(tmp_path / "m.uff")).get_set_types()} == {kind}
    shapes = lp.exchange.read_uff(tmp_path / "m.uff").shapes
    # stiffness and damping are in one proportion, so the shapes are those of [[1, -1], [-1, 2]]
    squares, vectors = np.linalg.eigh(STIFFNESS / J * np.array([[1.0, -1], [-1, 2]]))
    w = np.sqrt(squares)
    assert [s.hertz for s in shapes] == pytest.approx(w / (2 * np.pi), rel=1e-5)
    assert [s.damping for s in shapes] == pytest.approx(damping * w / (2 * STIFFNESS), rel=1e-4)
    assert all(s.nodes == (1, 2) for s in shapes)
    read = np.column_stack([s.values[:, 0] for s in shapes])
    error = np.abs(mac(read, vectors) - np.eye(2)).max()
    print(f"error {error:.1e}")
    assert error < 1e-9


def test_both_data_sets_hold_the_same_shapes(tmp_path):
    """A damper at one end only, so the amplitudes are complex."""
    model = lp.compose(
        a=Inertia(J=2.0),
        shaft=SpringDamper(c=300.0, d=4.0),
        b=Inertia(J=1.0),
        wheel=SpringDamper(c=90.0),
        wall=Fixed(),
        connections=lambda m: lp.chain(m.a, m.shaft, m.b, m.wheel, m.wall),
    )
    modes, nodes = lp.modes(lp.assemble(model)), {"a.phi": 3, "b.phi": 40}
    read = []
    for kind in (55, 2414):
        lp.exchange.write_uff(tmp_path / "m.uff", modes, nodes=nodes, shapes=kind)
        read.append(lp.exchange.read_uff(tmp_path / "m.uff").shapes)
    assert len(read[1]) == len(modes.hertz) == 2
    for i, (old, new) in enumerate(zip(*read, strict=True)):
        expected = [modes.shape(name)[i] for name in nodes]
        assert np.abs(np.imag(expected)).max() > 1e-3
        assert new.values[:, 0] == pytest.approx(np.array(expected), rel=1e-5)
        assert new.values == pytest.approx(old.values, rel=1e-5)
        assert (new.nodes, new.hertz) == (old.nodes, pytest.approx(old.hertz, rel=1e-5))
        assert new.damping == pytest.approx(old.damping, rel=1e-4)
    with pytest.raises(OptionError, match="shapes = 58: one of 55, 2414"):
        lp.exchange.write_uff(tmp_path / "m.uff", modes, nodes=nodes, shapes=58)


def test_a_file_of_another_program_is_read(tmp_path):
    """Even steps as text, a coherence that is left out, and six columns of a shape."""
    x, y = np.arange(5) * 0.25, np.array([1.0, 2, -3, 4, 0.5])
    common = {"type": 58, "rsp_node": 3, "rsp_dir": 2, "ref_node": 9, "ref_dir": -1, "x": x}
    common |= {"data": y, "id1": "channel 3", "abscissa_spacing": 1}
    common |= {"orddenom_spec_data_type": 0}
    zero = np.zeros(2)
    shape = {"type": 55, "analysis_type": 2, "data_ch": 3, "spec_data_type": 8, "load_case": 0}
    shape |= {"mode_n": 1, "freq": 12.5, "modal_damp_vis": 0.02, "node_nums": [4, 8]}
    shape |= {f"r{i}": zero for i in range(1, 7)} | {"r4": np.array([1.0, -0.25])}
    sets = [common | {"func_type": 1}, common | {"func_type": 6}, shape]
    pyuff.UFF(str(tmp_path / "o.uff")).write_sets(sets, mode="overwrite")
    found = lp.exchange.read_uff(tmp_path / "o.uff")
    (curve,), (mode,) = found.curves, found.shapes
    assert (curve.node, curve.direction, curve.reference_node) == (3, 2, 9)
    assert curve.reference_direction == -1
    assert curve.x == pytest.approx(x)
    assert curve.y == pytest.approx(y)
    assert found.left_out == (58,)
    assert (mode.hertz, mode.damping, mode.nodes) == (12.5, 0.02, (4, 8))
    assert mode.values[:, 3] == pytest.approx([1.0, -0.25])
    assert "channel 3" in repr(found)


def analysis_data(kind, data_type, size, real, nodes):
    """Data set 2414 by the columns of its description; real are its records 12 and 13."""
    lines = ["    -1", "  2414", f"{1:10d}", "mode", f"{1:10d}", *["NONE"] * 5]
    lines += ["".join(f"{n:10d}" for n in row)
              for row in ((1, kind, size, 8, data_type, size), [0] * 8, [0] * 2)]  # fmt: skip
    lines += ["".join(f"{x:13.5E}" for x in real[i : i + 6]) for i in (0, 6)]
    for node, values in nodes.items():
        lines += [f"{node:10d}", "".join(f"{x:13.5E}" for x in values)]
    return "\n".join([*lines, "    -1", ""])


def test_modes_of_analysis_data_are_read(tmp_path):
    normal = [0.0, 12.5, 0.0, 1.0, 0.03, *[0.0] * 7]
    rooted = [*[0.0] * 6, -3.0, 40.0, *[0.0] * 4]
    text = analysis_data(2, 2, 6, normal, {7: [0, 0, 0, 1.0, 0, 0], 9: [0, 0, 0, -0.5, 0, 0]})
    text += analysis_data(3, 5, 3, rooted, {7: [1.0, 2.0, 0, 0, 0, 0], 8: [3.0, -4.0, 0, 0, 0, 0]})
    text += analysis_data(4, 2, 3, normal, {7: [1.0, 0, 0]})  # of a course over time
    file = tmp_path / "modes.unv"
    file.write_text(text)
    found = lp.exchange.read_uff(file)
    first, second = found.shapes
    assert (first.hertz, first.damping, first.nodes) == (12.5, 0.03, (7, 9))
    assert first.values[:, 3].tolist() == [1.0, -0.5]
    assert second.hertz == pytest.approx(np.hypot(3, 40) / (2 * np.pi))
    assert second.damping == pytest.approx(3 / np.hypot(3, 40))
    assert second.values[:, 0].tolist() == [1 + 2j, 3 - 4j]
    assert found.left_out == (2414,)


def test_measured_and_computed_responses_are_compared_at_the_measured_frequencies():
    hertz = np.linspace(0.5, 6.0, 23)
    truth = np.array([exact(5.0, f)[0] for f in hertz])
    given = {"inputs": ["motor.tau"], "outputs": ["a.phi"], "hertz": [1.0, 2.0]}
    for damping, same in ((5.0, True), (1.0, False)):
        response = lp.frequency_response(drive(damping), **given)
        compared = compare_response(
            response, output="a.phi", input="motor.tau", hertz=hertz, measured=3j * truth
        )
        other = np.array([exact(damping, f)[0] for f in hertz])
        expected = abs(np.sum(truth * other.conj())) ** 2
        expected /= np.sum(np.abs(truth) ** 2) * np.sum(np.abs(other) ** 2)
        print(f"FRAC {compared.frac:.6f}")
        assert compared.frac == pytest.approx(expected, abs=1e-10)
        assert (abs(compared.frac - 1) < 1e-10) == same
    axes = compared.plot(units={"a.phi": "deg"}).axes
    measured, computed = axes[0].lines[:2]
    assert measured.get_ydata() == pytest.approx(np.degrees(np.abs(3 * truth)))
    assert computed.get_ydata() == pytest.approx(np.degrees(np.abs(other)))


def test_criteria_of_orthogonal_and_of_scaled_vectors():
    shapes = np.array([[1.0, 1], [1, -1]])
    assert mac(shapes, 2j * shapes) == pytest.approx(np.eye(2), abs=1e-15)
    assert mac([1.0, 0], [1.0, 1]) == pytest.approx(np.array([[0.5]]))
    assert frac([1, 1j], [1j, -1]) == pytest.approx(1.0)
    assert frac([1, 0], [1, 1j]) == pytest.approx(0.5)


def test_what_makes_no_sense_is_refused(tmp_path):
    modes = lp.modes(drive(0.0))
    write, read = lp.exchange.write_uff, lp.exchange.read_uff
    text = tmp_path / "text.uff"
    text.write_text("nothing of this kind\n")
    calls = {
        "no universal file": lambda: read(text),
        "no file": lambda: read(tmp_path / "none.uff"),
        "node 0": lambda: write(tmp_path / "x.uff", modes, nodes={"a.phi": 0}),
        "nothing to write": lambda: write(tmp_path / "x.uff", modes, nodes={}),
        "same places": lambda: mac([1.0, 2], [1.0, 2, 3]),
        "zero or not finite": lambda: mac([0.0, 0], [1.0, 2]),
        "not all zero": lambda: frac([0.0, 0], [1.0, 2]),
    }
    for hint, call in calls.items():
        with pytest.raises(OptionError, match=hint):
            call()
