"""One run writes to an output directory at a time, and leaves nothing of another scene."""

import errno
import fcntl
import shutil
import signal
from pathlib import Path

import pytest
from support.command import TWO_SAVED, call, finish, lines, start, tree, wait_for
from support.scenes import SMALL

from fenics_yeast import Scene
from fenics_yeast.output import FolderLock, OutputError, read_summary
from fenics_yeast.output.folder import OutputFolder


@pytest.fixture
def small() -> Scene:
    return Scene.from_toml(SMALL)


LONG = ("--set", "numerics.step=0.002", "--quiet")


@pytest.mark.process
def test_a_second_run_into_a_directory_is_refused_until_the_first_is_dead(here: Path) -> None:
    """However it died, as by SIGKILL; with --resume too."""
    folder = here / "out" / "small"
    first = start("run", "small.toml", *LONG)
    try:
        wait_for(lambda: lines(folder) > 5, first)
        for options in ((), ("--resume",)):
            second = finish("run", "small.toml", *LONG, *options)
            assert (second.returncode, second.stdout) == (2, "")
            assert second.stderr.startswith("error: out/small: another run is writing to it")
            assert second.stderr.count("\n") == 1
        assert first.poll() is None
    finally:
        first.send_signal(signal.SIGKILL)
        first.communicate()
    assert call("run", "small.toml", "--quiet").exit_code == 0
    assert read_summary(folder).status == "finished"
    assert tree(folder) == TWO_SAVED


@pytest.mark.process
def test_a_second_sweep_into_a_directory_is_refused(here: Path) -> None:
    vary = ("sweep", "small.toml", "--vary", "growth.time=30,45", "--jobs", "1")
    first = start(*vary, *LONG)
    try:
        wait_for(lambda: any((here / "out").rglob("history.csv")), first)
        second = finish(*vary, "--quiet")
        assert second.returncode == 2
        assert second.stderr.startswith("error: out/small-sweep: another run is writing to it")
    finally:
        first.send_signal(signal.SIGINT)
        assert first.wait(60) == 130
        first.communicate()


def test_the_lock_is_a_file_open_for_writing_that_is_never_replaced(
    tmp_path: Path, small: Scene
) -> None:
    """As network file systems need; two writers of one directory exclude each other."""
    with OutputFolder(tmp_path / "run", small):
        assert (tmp_path / "run" / ".lock").exists()
        for _ in range(2):
            with pytest.raises(OutputError, match="another run is writing to it"):
                OutputFolder(tmp_path / "run", small)
    assert not (tmp_path / "run" / ".lock").exists()
    (tmp_path / "run" / ".lock").touch()  # as a killed process leaves it
    with OutputFolder(tmp_path / "run", small):
        pass
    assert not (tmp_path / "run" / ".lock").exists()


def test_a_file_system_without_locks_gives_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def flock(opened: int, how: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", flock)
    with FolderLock(tmp_path):
        FolderLock(tmp_path).release()


def test_figures_of_another_scene_are_removed(here: Path) -> None:
    assert call("run", "small.toml", "--quiet").exit_code == 0
    folder = here / "out" / "small"
    assert call("plot", "out/small", "--pdf").exit_code == 0
    (folder / "figures" / "film.gif").touch()
    (folder / "notes.txt").write_text("mine")
    static = ("--set", "run={ end = 1 }", "--set", "wall.thickness=0.2")
    assert call("run", "small.toml", "--quiet", *static).exit_code == 0
    assert tree(folder) == TWO_SAVED - {"surface/0001.vtu"} | {"notes.txt"}
    shutil.rmtree(folder)
