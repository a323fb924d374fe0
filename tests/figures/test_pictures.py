"""Figures show the results; file formats and animations."""

from itertools import pairwise
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from PIL import Image
from support.command import call

from fenics_yeast import Scene, simulate
from fenics_yeast.figures import AnimationError, Curve, animation, draw, volumes
from fenics_yeast.figures.wall_fields import area_strain, mean, outline, zone_numbers
from fenics_yeast.output import FIGURES, Job


@pytest.fixture(scope="module")
def growing(cell_scene: Scene) -> Scene:
    """A short run of a bud, with the forms of the paper's preset."""
    numerics = {"preset": "paper", "elements": 60, "step": 2.0}
    return cell_scene.with_values({"numerics": numerics, "run.end": 20.0, "run.save": [0, 10, 20]})


@pytest.fixture(scope="module")
def folder(growing: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run")
    with Job(path, growing) as job:
        job.complete(job.run())
    return path


def test_plot_writes_every_figure_as_png_and_pdf(folder: Path) -> None:
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
    profiles = simulate(growing).profiles
    profile = profiles.at(20)
    # The mean of ξ is 0, that of ξ² is h²/12.
    h = growing.wall.thickness
    assert mean(profile, 3 + profile.xi[None, :]) == pytest.approx(3)
    assert mean(profile, profile.xi[None, :] ** 2) == pytest.approx(h**2 / 12)
    grows = zone_numbers(profiles.zones, profile.S_points) > 0
    strain = area_strain(profile)
    assert strain[~grows].max() == 0 and strain[grows].min() > 0
    assert strain.max() <= 2 * profile.growth_strain.max()


def test_an_animation_shows_the_cell_at_every_frame(
    folder: Path, growing: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(matplotlib.rcParams, "animation.ffmpeg_path", "no-such-ffmpeg")
    made = animation.animate(folder, growing, end=20.0, frames=6)
    assert made == [folder / "figures" / "film.gif"]
    with Image.open(made[0]) as moving:
        assert moving.n_frames == 6 and moving.info["loop"] == 0
        pictures = []
        for i in range(6):
            moving.seek(i)
            pictures.append(np.asarray(moving.convert("RGB")).astype(int))
    assert (pictures[0][0, 0] == 255).all()
    height, width, _ = pictures[0].shape
    # The cell grows in the left half, the dot moves in the right one.
    for earlier, later in pairwise(pictures):
        changed = np.abs(later - earlier).max(axis=2) > 30
        assert changed[:, : width // 3].any() and changed[:, width // 2 :].any()
        assert not changed[int(0.75 * height) :, : width // 5].any()  # the mother's lower half


def test_only_a_run_in_time_is_animated(tmp_path: Path, elastic_scene: Scene) -> None:
    with pytest.raises(AnimationError, match="requires a run in time"):
        animation.animate(tmp_path, elastic_scene, end=0.0)
    with Job(tmp_path / "static", elastic_scene) as job:
        job.complete(job.run())
    result = call("plot", str(tmp_path / "static"), "--film")
    assert result.exit_code == 2 and result.stderr.count("\n") == 1
    (tmp_path / "sweep.csv").write_text("case,growth.time,status\n")
    result = call("plot", str(tmp_path), "--film")
    assert result.exit_code == 2 and "to animate a case" in result.stderr


@pytest.mark.slow
def test_mp4_is_written_where_ffmpeg_is_and_its_failure_is_reported(
    folder: Path, growing: Scene, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A script in place of ffmpeg keeps its input: all frames, the last one 31 times."""
    ffmpeg = tmp_path / "ffmpeg"
    ffmpeg.write_text(
        f"#!/bin/sh\nfor last; do :; done\ncat > {tmp_path}/raw\ncp {tmp_path}/raw $last"
    )
    ffmpeg.chmod(0o755)
    monkeypatch.setitem(matplotlib.rcParams, "animation.ffmpeg_path", str(ffmpeg))
    made = animation.animate(folder, growing, end=20.0, frames=3)
    assert [path.name for path in made] == ["film.gif", "film.mp4"]
    with Image.open(made[0]) as moving:
        width, height = moving.size
    frame = 4 * width * height
    content = (tmp_path / "raw").read_bytes()
    assert len(content) == (3 + 30) * frame and width % 2 == height % 2 == 0
    assert content[-frame:] == content[2 * frame : 3 * frame] != content[:frame]
    for read in ("cat > /dev/null;", ""):  # before or after all frames
        ffmpeg.write_text(f"#!/bin/sh\n{read} echo no such encoder >&2; exit 1")
        with pytest.raises(AnimationError, match="cannot be written: ffmpeg failed"):
            animation.animate(folder, growing, end=20.0, frames=3)
        assert not (folder / "figures" / "part-film.mp4").exists()


@pytest.mark.parametrize("changes", [{"turgor.pressure": -0.01}, {"growth": None}])
def test_runs_without_growth_or_under_external_pressure_have_figures(
    tmp_path: Path, growing: Scene, changes: dict[str, object]
) -> None:
    scene = growing.with_values({"run.end": 2.0, "run.save": [2.0], **changes})
    result = simulate(scene)
    for path in draw(tmp_path, scene, result.history, result.profiles, names=FIGURES):
        assert path.stat().st_size > 5000


def test_a_loss_of_equilibrium_is_marked_with_its_time(tmp_path: Path, growing: Scene) -> None:
    history = simulate(growing.with_values({"run.end": 0.9916, "run.save": [0.9916]})).history
    with matplotlib.rc_context({"svg.fonttype": "none"}):
        volumes([Curve("a cell", history, "no-equilibrium")], tmp_path / "lost.svg")
    text = (tmp_path / "lost.svg").read_text()
    assert "equilibrium lost" in text and "at 0.992 min" in text
