"""Films show linkages where they are."""

import itertools
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from rows import in_a_row

import lumped as lp
from lumped.components import CrankSlider, Eccentric, GuidedRod, Inertia, Position, SwingingMass
from lumped.components.translation import Fixed, Mass
from lumped.drawing.film import moving_lines
from lumped.models.eccentric_shear.scenes import SPEED, FreeShear, free_run, seat_support
from lumped.models.eccentric_shear.stand import ECCENTRICITY, ROD_UPPER, GuidedShear
from lumped.models.rotary_arm.control import run_controlled

R, L, E, AXIS = 0.3, 1.1, 0.1, 0.4


SLIDER = in_a_row(
    drive=Position(phi=3.0 * lp.time), crank=CrankSlider(r=R, L=L, e=E, m=2.0, axis=AXIS)
)
"""Crank-slider on an inclined slide, turned at 3 rad/s."""


class Composed(lp.Component):
    """A mechanism of an eccentric and a rod in a guide."""

    drive: Position = Position(phi=2.0 * lp.time)
    crank: Eccentric = Eccentric(radius=R, phase=np.pi / 2)
    rod: GuidedRod = GuidedRod(length=L)
    foot: Mass = Mass(m=1.0)
    hub_x: Fixed = Fixed()
    hub_y: Fixed = Fixed(s0=0.5)

    def connections(self):
        yield lp.connect(self.drive.flange, self.crank.flange)
        yield lp.connect(self.crank.hub_x, self.hub_x.flange)
        yield lp.connect(self.crank.hub_y, self.hub_y.flange)
        yield lp.connect(self.crank.pin_x, self.rod.pin_x)
        yield lp.connect(self.crank.pin_y, self.rod.pin_y)
        yield lp.connect(self.rod.foot_y, self.foot.flange_a)


def drawn(run: lp.Trajectory, frames: int = 40) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    times = np.linspace(run.t[0], run.t[-1], frames)
    return times, moving_lines(run, times)


def lengths(line: np.ndarray) -> np.ndarray:
    return np.linalg.norm(np.diff(line, axis=1)[:, 0], axis=1)


@pytest.fixture(scope="module")
def slider() -> lp.Trajectory:
    return lp.simulate(lp.assemble(SLIDER), until=2.5, grid=2001)


def test_crank_slider_keeps_its_lengths_and_its_slide(slider: lp.Trajectory):
    times, lines = drawn(slider)
    crank, rod, mass = (lines[f"crank.{name}"] for name in ("crank", "rod", "slider"))
    assert np.allclose(lengths(crank), R, rtol=1e-12)
    assert np.allclose(lengths(rod), L, rtol=1e-5)
    assert np.array_equal(crank[:, 1], rod[:, 0])
    assert np.array_equal(rod[:, 1], mass[:, 0])
    left = np.array([-np.sin(AXIS), np.cos(AXIS)])
    assert np.allclose(mass[:, 0] @ left, E, rtol=1e-12)
    assert np.allclose(crank[:, 1], R * np.column_stack([np.cos(3 * times), np.sin(3 * times)]))


def test_composed_mechanism_hangs_together():
    run = lp.simulate(lp.assemble(Composed()), until=3.0, grid=3001)
    times, lines = drawn(run)
    arm, rod = lines["crank.arm"], lines["rod.rod"]
    pin = np.column_stack([-R * np.sin(2 * times), 0.5 + R * np.cos(2 * times)])
    assert np.allclose(arm[:, 0], [0.0, 0.5], atol=1e-12)
    assert np.allclose(arm[:, 1], pin, atol=1e-6)
    assert np.array_equal(arm[:, 1], rod[:, 0])
    assert np.allclose(lengths(rod), L, rtol=1e-5)
    assert np.allclose(rod[:, 1, 0], 0.0, atol=1e-12)


def test_arm_points_where_its_angle_says():
    model = in_a_row(drive=Position(phi=0.5 * lp.time), arm=SwingingMass(m=1.0, R=-0.7, phi0=0.2))
    times, lines = drawn(lp.simulate(lp.assemble(model), until=2.0, grid=201))
    angle = 0.5 * times + 0.2
    expected = -0.7 * np.column_stack([np.cos(angle), np.sin(angle)])
    assert np.allclose(lines["arm.body"][:, 0], expected, atol=1e-12)


def test_supports_of_the_shear_hang_on_the_shaft_in_their_guides():
    hub = [f"loaded.shear.shaft.arm.hub_{axis}.s" for axis in "xy"]
    system = lp.assemble(FreeShear().with_({"loaded.shear": GuidedShear()}), keep=hub)
    start = {"motor.w": SPEED, "motor.phi": 0.0, "motor.i": 0.0, **dict.fromkeys(hub, 0.0)}
    run = lp.simulate(system, start=start | seat_support(GuidedShear), until=3.0, grid=600)
    _, lines = drawn(run)
    arm, rod = lines["loaded.shear.shaft.arm.arm"], lines["loaded.shear.upper.rod.rod"]
    assert np.allclose(lengths(arm), ECCENTRICITY, rtol=1e-4)
    assert np.allclose(lengths(rod), ROD_UPPER, rtol=1e-5)
    assert np.allclose(arm[:, 1], rod[:, 0], atol=1e-9)
    assert np.allclose(rod[:, 1, 0], 0.0, atol=1e-12)
    assert np.ptp(arm[:, 0, 1]) > 0.01  # the shaft is lifted


def test_positions_left_out_are_named_all_at_once(tmp_path: Path):
    system = lp.assemble(free_run(until=0.1).system.model, of=["motor.w"])
    run = replace(lp.simulate(system, until=0.1), again=None)
    with pytest.raises(lp.errors.UnknownNameError, match=r"keep=.*hub_x.*hub_y.*foot_y"):
        lp.drawing.animate(run, tmp_path / "a.gif")


def test_arm_carries_the_mandrel_between_table_and_rollers():
    run = run_controlled(grid=600)
    times, lines = drawn(run, 200)
    trays, mandrel = lines["arm.trays.body"][:, 0], lines["arm.weight.body"][:, 0]
    taken, put = sorted(e.time for e in run.events if e.component == "arm.carried")[-2:]
    together = (times > taken + 0.1) & (times < put - 0.1)
    assert np.allclose(trays[together], mandrel[together], atol=1e-3)
    resting = times < taken - 0.1
    assert np.ptp(mandrel[resting], axis=0).max() < 1e-9
    assert np.linalg.norm(trays - mandrel, axis=1)[resting].max() > 0.05


def test_gif_has_the_frames_and_is_small(slider: lp.Trajectory, tmp_path: Path):
    file = lp.drawing.animate(slider, tmp_path / "slider.gif", frames=12, seconds=1.2)
    with Image.open(file) as film:
        assert film.n_frames == 12
        assert film.info["duration"] == pytest.approx(100)
        pictures = []
        for k in range(12):
            film.seek(k)
            pictures.append(np.asarray(film.convert("L")))
    assert all((a != b).any() for a, b in itertools.pairwise(pictures))
    assert file.stat().st_size < 12 * 8000


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="no ffmpeg on the PATH")
def test_mp4_is_written_by_ffmpeg(slider: lp.Trajectory, tmp_path: Path):
    file = lp.drawing.animate(slider, tmp_path / "slider.mp4", frames=12)
    assert file.read_bytes()[4:8] == b"ftyp"


def test_mp4_without_ffmpeg_is_answered_with_what_is_missing(
    slider: lp.Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(lp.errors.OptionError, match="ffmpeg"):
        lp.drawing.animate(slider, tmp_path / "slider.mp4")


@pytest.mark.parametrize(
    ("name", "options", "text"),
    [
        ("a.avi", {}, r"\.gif"),
        ("a.gif", {"frames": 1000}, "2 to 300"),
        ("a.gif", {"frames": 1}, "2 to 300"),
        ("a.gif", {"seconds": 0.0}, "positive"),
    ],
)
def test_options_out_of_range_are_refused(
    slider: lp.Trajectory, tmp_path: Path, name: str, options: dict, text: str
):
    with pytest.raises(lp.errors.OptionError, match=text):
        lp.drawing.animate(slider, tmp_path / name, **options)


def test_model_that_moves_in_no_plane_is_refused(tmp_path: Path):
    run = lp.simulate(lp.assemble(lp.compose(body=Inertia(J=1.0, w=1.0))), until=1.0)
    with pytest.raises(lp.errors.OptionError, match="outline"):
        lp.drawing.animate(run, tmp_path / "a.gif")
