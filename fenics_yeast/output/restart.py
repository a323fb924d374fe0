"""What an output folder holds for a run of a scene to go on from."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from ..scene import Run, Scene, SceneError, flatten
from ..simulation import Checkpoint, CheckpointError, Result, ResumePoint
from ..solve import same_time
from .folder import CHECKPOINT, OutputError
from .reading import read_history, read_profiles, read_result, read_scene, read_status

_ANEW = "leave out --resume to run the scene anew"


@dataclass(frozen=True)
class EarlierRun:
    """What an earlier run has left.

    Attributes
    ----------
    start
        Where it can be taken up; None if nowhere.
    ended
        What it found, if there is nothing to be added.
    """

    start: ResumePoint | None = None
    ended: Result | None = None


def find_earlier_run(directory: Path, scene: Scene) -> EarlierRun:
    """Find out how a scene goes on that was run into a folder before.

    The scene must be the earlier one, but for its title and its `run`: a run goes on to another
    end, with other saved times ahead.

    Raises
    ------
    OutputError
        If the folder is that of another scene, or damaged.
    """
    checkpoint = _load(directory / CHECKPOINT)
    try:
        if checkpoint is not None:
            earlier = Scene.from_toml(checkpoint.scene)
        elif any(directory.glob("*")):
            earlier = read_scene(directory)
        else:
            return EarlierRun()
    except SceneError:
        problem = f"{directory}: holds a scene that this version cannot read; {_ANEW}"
        raise OutputError(problem) from None
    if (difference := _difference(earlier, scene)) is not None:
        raise OutputError(
            f"{directory}: holds a run of another scene, with {difference}; choose another folder"
        )
    ended = None
    if read_status(directory) in ("finished", "no-equilibrium"):
        ended = read_result(directory)
    if checkpoint is None:
        return EarlierRun(ended=ended if ended is not None and earlier.run == scene.run else None)
    start = _start(directory, checkpoint)
    run, time = scene.run, checkpoint.stepper.time
    if run is None:
        return EarlierRun(start, ended)
    _agree(directory, start, run)
    if ended is not None:
        reached = time if ended.status == "finished" else ended.end_time
        beyond = run.end > reached and not same_time(run.end, reached)
        if beyond == (ended.status == "finished"):
            ended = None
    return EarlierRun(start, ended)


def _load(path: Path) -> Checkpoint | None:
    try:
        return Checkpoint.from_bytes(path.read_bytes())
    except FileNotFoundError:
        return None
    except CheckpointError as error:
        raise OutputError(f"{path}: {error}; {_ANEW}") from None
    except OSError as error:
        raise OutputError(f"{path}: cannot be read: {error.strerror}; {_ANEW}") from None


def _start(directory: Path, checkpoint: Checkpoint) -> ResumePoint:
    """Complete a checkpoint by the rows and profiles that it counts."""
    recorder = checkpoint.recorder
    rows = read_history(directory).rows[: recorder.rows]
    profiles = read_profiles(directory).all[: recorder.profiles]
    lacking = None
    if len(rows) < recorder.rows or rows[-1].time_min != checkpoint.stepper.time:
        lacking = f"row {recorder.rows} of the history"
    elif len(profiles) < recorder.profiles:
        lacking = f"profile {recorder.profiles}"
    if lacking is not None:
        raise OutputError(f"{directory}: has lost {lacking}, which its checkpoint needs; {_ANEW}")
    if read_status(directory) is not None:  # what came after the checkpoint took its time too
        checkpoint = replace(checkpoint, timings=read_result(directory).timings)
    return ResumePoint(checkpoint, tuple(rows), tuple(profiles))


def _agree(directory: Path, start: ResumePoint, run: Run) -> None:
    """Refuse a span of time that is behind the run, or should have been saved."""
    time = start.checkpoint.stepper.time
    if run.end < time and not same_time(run.end, time):
        problem = f"has come to {time:g} min already, beyond run.end ({run.end:g} min)"
        raise OutputError(f"{directory}: {problem}; {_ANEW}")
    for wanted in run.save:
        passed = wanted < time or same_time(wanted, time)
        if passed and not any(same_time(profile.time, wanted) for profile in start.profiles):
            problem = f"has passed {wanted:g} min, which was not to be saved then"
            raise OutputError(f"{directory}: {problem}; {_ANEW}")


def _difference(earlier: Scene, scene: Scene) -> str | None:
    """First value in which two scenes differ, but for title and span of time."""
    old, new = flatten(earlier), flatten(scene)
    if (earlier.run is None) != (scene.run is None):
        return "a [run] table" if scene.run is None else "no [run] table"
    for key in {**old, **new}:
        if key == "title" or key.startswith("run."):
            continue
        if old.get(key) != new.get(key):
            was, now = (_text(values.get(key)) for values in (old, new))
            return f"{key} = {was} in place of {now}"
    return None


def _text(value: object) -> str:
    return "none" if value is None else str(value)
