"""Pictures are made of what was computed: figures, their kinds of file, and films."""

import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support.command import call

from fenics_yeast import Scene, simulate
from fenics_yeast.figures import film
from fenics_yeast.figures.film import FilmError, write_gif, write_mp4
from fenics_yeast.figures.run_figures import draw_all
from fenics_yeast.figures.wall_fields import area_strain, mean, outline, zone_numbers
from fenics_yeast.output.job import run_into


@pytest.fixture(scope="module")
def growing(cell_scene: Scene) -> Scene:
    """A bud that is over soon, with the forms of the paper's preset."""
    numerics = {"preset": "paper", "elements": 60, "step": 2.0}
    return cell_scene.with_values({"numerics": numerics, "run.end": 20.0, "run.save": [0, 10, 20]})


@pytest.fixture(scope="module")
def folder(growing: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run")
    run_into(path, growing)
    return path


def test_plot_gives_every_figure_as_png_and_pdf(folder: Path) -> None:
    result = call("plot", str(folder), "--pdf")
    assert result.exit_code == 0
    for name in ("shapes", "volume", "meridian"):
        assert (folder / f"figures/{name}.png").read_bytes().startswith(b"\x89PNG")
        assert (folder / f"figures/{name}.pdf").read_bytes().startswith(b"%PDF")
        assert str(folder / f"figures/{name}.pdf") in result.stdout.splitlines()
    assert str(folder / "surface.pvd") in result.stdout.splitlines()


def test_the_outline_lies_on_the_circle_of_an_unloaded_sphere(fine_scene: Scene) -> None:
    scene = fine_scene.with_values({"turgor": {"pressure": 0.0}, "growth": None, "run": None})
    profile = simulate(scene.with_values({"numerics.elements": 16})).profiles.all[0]
    _, r, z = outline(profile, 8)
    assert np.hypot(r, z) == pytest.approx(2.5, rel=1e-4)
    assert len(r) == 8 * (len(profile.S) - 1) + 1


def test_fields_are_means_through_the_wall(growing: Scene) -> None:
    profile = simulate(growing).profiles.at(20)
    # A field linear through the wall has its middle as mean, a square one h²/12.
    h = growing.wall.thickness
    assert mean(profile, 3 + profile.xi[None, :]) == pytest.approx(3)
    assert mean(profile, profile.xi[None, :] ** 2) == pytest.approx(h**2 / 12)
    grows = zone_numbers(growing, profile.S_points) > 0
    strain = area_strain(profile)
    assert strain[~grows].max() == 0 and strain[grows].min() > 0
    assert strain.max() <= 2 * profile.growth_strain.max()


def test_a_film_shows_the_cell_at_every_frame(
    folder: Path, growing: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(film.shutil, "which", lambda name: None)
    made = film.animate(folder, growing, end=20.0, frames=6)
    assert made == [folder / "figures" / "film.gif"]
    with Image.open(made[0]) as moving:
        assert moving.n_frames == 6 and moving.info["loop"] == 0
        pictures = []
        for i in range(6):
            moving.seek(i)
            pictures.append(np.asarray(moving.convert("RGB")).astype(int))
    assert (pictures[0][0, 0] == 255).all()
    height, width, _ = pictures[0].shape
    # The cell is where the model has it, in the left half; the dot runs in the right one.
    for earlier, later in pairwise(pictures):
        changed = np.abs(later - earlier).max(axis=2) > 30
        assert changed[:, : width // 3].any() and changed[:, width // 2 :].any()
        assert not changed[int(0.75 * height) :, : width // 5].any()  # the mother's lower half


def test_what_does_not_move_is_not_filmed(tmp_path: Path, elastic_scene: Scene) -> None:
    with pytest.raises(FilmError, match="a film needs a run in time"):
        film.animate(tmp_path, elastic_scene, end=0.0)
    run_into(tmp_path / "static", elastic_scene)
    result = call("plot", str(tmp_path / "static"), "--film")
    assert result.exit_code == 2 and result.stderr.count("\n") == 1
    (tmp_path / "sweep.csv").write_text("case,growth.time,status\n")
    result = call("plot", str(tmp_path), "--film")
    assert result.exit_code == 2 and "directory of a case" in result.stderr


def test_mp4_is_written_by_ffmpeg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What ffmpeg is given: its pictures, one after the other, and the last one for a while."""
    given = {}

    def run(command: list[str], **options: object) -> subprocess.CompletedProcess[bytes]:
        given.update(command=command, **options)
        Path(command[-1]).write_bytes(b"film")
        return subprocess.CompletedProcess(command, 0, b"", b"")

    monkeypatch.setattr(film.subprocess, "run", run)
    pictures = [np.full((4, 6, 3), value, dtype=np.uint8) for value in (1, 2, 3)]
    write_mp4(pictures, tmp_path / "film.mp4")
    assert (tmp_path / "film.mp4").read_bytes() == b"film"
    assert "6x4" in given["command"] and "yuv420p" in given["command"]
    frames = np.frombuffer(given["input"], np.uint8).reshape(-1, 4 * 6 * 3)
    assert [int(frame[0]) for frame in frames[:4]] == [1, 2, 3, 3] and len(frames) == 3 + 30

    def fail(command: list[str], **_: object) -> subprocess.CompletedProcess[bytes]:
        return subprocess.CompletedProcess(command, 1, b"", b"first\nno such encoder\n")

    monkeypatch.setattr(film.subprocess, "run", fail)
    with pytest.raises(FilmError, match="ffmpeg failed: no such encoder"):
        write_mp4(pictures, tmp_path / "other.mp4")


def test_a_gif_keeps_its_colours(tmp_path: Path) -> None:
    first = np.full((20, 20, 3), 255, dtype=np.uint8)
    last = first.copy()
    last[5:10, 5:10] = (213, 94, 0)
    write_gif([first, last], tmp_path / "two.gif")
    with Image.open(tmp_path / "two.gif") as moving:
        moving.seek(1)
        shown = np.asarray(moving.convert("RGB"))
    assert np.abs(shown[7, 7].astype(int) - (213, 94, 0)).max() <= 4
    assert (shown[0, 0] == 255).all()


@pytest.mark.parametrize("changes", [{"turgor.pressure": -0.01}, {"growth": None}])
def test_figures_of_other_runs_are_drawn_too(
    tmp_path: Path, growing: Scene, changes: dict[str, object]
) -> None:
    scene = growing.with_values({"run.end": 2.0, "run.save": [2.0], **changes})
    result = simulate(scene)
    for path in draw_all(tmp_path, scene, result.history, result.profiles):
        assert path.stat().st_size > 5000
