"""Find where a run can resume from its output directory."""

from dataclasses import dataclass, replace
from pathlib import Path

from ..scene import Run, Scene, SceneError, flatten
from ..simulation import ANSWERS, Checkpoint, CheckpointError, Digest, Result, ResumePoint
from ..solve import same_time
from .errors import OutputError
from .files import CHECKPOINT, HISTORY, PROFILES
from .lock import LOCK
from .reading import read_history, read_profiles, read_result, read_scene
from .summary import read_summary

FROM_START = "omit --resume to run the scene from the start"


@dataclass(frozen=True)
class EarlierRun:
    """An earlier run in an output directory.

    Attributes
    ----------
    start
        State from which it can resume, or None.
    ended
        Its result, if nothing remains to be computed.
    """

    start: ResumePoint | None = None
    ended: Result | None = None


def find_earlier_run(directory: Path, scene: Scene) -> EarlierRun:
    """Return how far a scene was run into a directory before.

    The scene must be the earlier one except for its title and table `run`: a run may resume to
    another end, with other saved times ahead.

    Raises
    ------
    OutputError
        If the directory belongs to another scene, or is damaged.
    """
    checkpoint = _load(directory / CHECKPOINT)
    try:
        if checkpoint is not None:
            earlier = Scene.from_toml(checkpoint.scene)
        elif any(path.name != LOCK for path in directory.glob("*")):
            earlier = read_scene(directory)
        else:
            return EarlierRun()
    except SceneError:
        problem = f"{directory}: its scene cannot be read by this version; {FROM_START}"
        raise OutputError(problem) from None
    if (difference := _difference(earlier, scene)) is not None:
        raise OutputError(
            f"{directory}: contains a run of a different scene ({difference}); "
            "choose another output directory with --out, or omit --resume to replace it"
        )
    summary = read_summary(directory)
    answered = summary is not None and summary.status in ANSWERS
    ended = read_result(directory) if answered else None
    if checkpoint is None:
        return EarlierRun(ended=ended if earlier.run == scene.run else None)
    if summary is not None:  # it includes time after the checkpoint
        checkpoint = replace(checkpoint, timings=summary.timings)
    start = _start(directory, checkpoint)
    run, time = scene.run, checkpoint.stepper.time
    if run is None:
        return EarlierRun(start, ended)
    _agree(directory, start, run)
    if ended is not None:
        reached = time if ended.status == "finished" else ended.end_time
        beyond = run.end > reached and not same_time(run.end, reached)
        stopped = earlier.run is not None and earlier.run.stop_at_bifurcation
        goes_on = stopped and not run.stop_at_bifurcation
        if goes_on or beyond == (ended.status == "finished"):
            ended = None
    return EarlierRun(start, ended)


def _load(path: Path) -> Checkpoint | None:
    try:
        return Checkpoint.from_bytes(path.read_bytes())
    except FileNotFoundError:
        return None
    except CheckpointError as error:
        raise OutputError(f"{path}: {error}; {FROM_START}") from None
    except OSError as error:
        raise OutputError(f"{path}: cannot be read: {error.strerror}; {FROM_START}") from None


def _start(directory: Path, checkpoint: Checkpoint) -> ResumePoint:
    """Complete a checkpoint with the rows and profiles before it."""
    recorder = checkpoint.recorder
    rows = read_history(directory).rows[: recorder.rows]
    profiles = read_profiles(directory).all[: recorder.profiles]
    problem = None
    if len(rows) < recorder.rows:
        problem = f"row {recorder.rows} of {HISTORY} is missing"
    elif Digest(rows).text != recorder.digest:
        problem = f"{HISTORY} was changed"
    elif len(profiles) < recorder.profiles:
        problem = f"profile {recorder.profiles} of {PROFILES} is missing"
    if problem is not None:
        raise OutputError(f"{directory}: cannot resume: {problem}; {FROM_START}")
    return ResumePoint(checkpoint, tuple(rows), tuple(profiles))


def _agree(directory: Path, start: ResumePoint, run: Run) -> None:
    """Refuse an end, or a newly saved time, that the run has passed."""
    time, problem = start.checkpoint.stepper.time, None
    if run.end < time and not same_time(run.end, time):
        problem = f"already at {time:g} min, beyond run.end = {run.end:g} min"
    for saved in run.save:
        passed = saved < time or same_time(saved, time)
        if passed and not any(same_time(profile.time, saved) for profile in start.profiles):
            problem = problem or f"{saved:g} min of run.save has passed without a profile"
    if problem is not None:
        raise OutputError(f"{directory}: cannot resume: {problem}; {FROM_START}")


def _difference(earlier: Scene, scene: Scene) -> str | None:
    """Return the first value in which two scenes differ, except title, `run` and what is found."""
    old, new = flatten(earlier), flatten(scene)
    if (earlier.run is None) != (scene.run is None):
        return f"[run] was {'missing' if earlier.run is None else 'present'}"
    for key in {**old, **new}:
        if key == "title" or key.startswith(("run.", "cell.unloaded")):
            continue
        if old.get(key) != new.get(key):
            was, now = (
                "none" if (value := values.get(key)) is None else value for values in (old, new)
            )
            return f"{key} was {was}, is now {now}"
    return None
