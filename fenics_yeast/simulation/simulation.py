"""Run a scene from start to end: by `simulate`, or step by step by `Simulation`."""

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from time import perf_counter
from typing import Any, Self

from .. import _dolfinx as dx
from ..mechanics import OwnLaw
from ..scene import Scene
from .build import build_shell
from .checkpoint import Checkpoint, ResumePoint
from .checkpointer import Checkpointer, local
from .directions import Model
from .findings import first_bifurcation, warnings
from .history import History, Row
from .initial_state import set_initial_state
from .kinks import kinks
from .observers import Observers, Publisher, RowCallback
from .outcome import Outcome, stability_note
from .profiles import Profile, Profiles
from .ranks import OtherRanks, RootError
from .recorder import Recorder
from .replay import Replay
from .result import Observer, Result, Timings
from .scales import residual_tolerance
from .sensitivity_recorder import SensitivityRecorder
from .shell_pool import ShellPool
from .static import Static
from .transient import Transient
from .unloaded_shape import find_unloaded, fit_of

_LOG = logging.getLogger(__name__)


class Simulation:
    """Iterator over the accepted steps of a simulation.

        with Simulation(scene) as simulation:
            for row in simulation:
                if row.bud_radius_um > 1.5:
                    break
        print(simulation.result.message)

    After a `break`, another loop in the block may continue. On several ranks, all must iterate;
    they get the same rows.

    Parameters
    ----------
    scene, energy, growth_law, observer, callback, comm, state, sensitivities, replay
        As in `simulate`.
    start
        State from which to resume an earlier run of the scene; the same on all ranks, except for
        profiles, which only rank 0 needs.
    keep
        Called with a checkpoint of the last step every few seconds and at the end, on rank 0
        only; must be given on all ranks.
    shells
        Lends the shell; without it, and for laws of your own, a new one is built.

    Raises
    ------
    CheckpointError
        If the start belongs to another wall.
    SceneError
        If the run cannot be differentiated by one of the `sensitivities`.
    """

    def __init__(
        self,
        scene: Scene | str | Path,
        *,
        energy: OwnLaw | None = None,
        growth_law: OwnLaw | None = None,
        observer: Observer | None = None,
        callback: Callable[[Row], None] | None = None,
        comm: Any = None,
        state: Profile | None = None,
        start: ResumePoint | None = None,
        keep: Callable[[Checkpoint], None] | None = None,
        shells: ShellPool | None = None,
        sensitivities: Sequence[str] = (),
        replay: Replay | None = None,
    ) -> None:
        self._began = perf_counter()
        scene = scene if isinstance(scene, Scene) else Scene.load(scene)
        counts, steps = ((), ()) if replay is None else (replay.counts, replay.times)
        scene = scene if replay is None else replay.applied_to(scene)
        self._scene = scene = find_unloaded(scene, comm, energy=energy)
        self._resources = resources = ExitStack()
        own = energy is not None or growth_law is not None
        if shells is None or own:
            laws = {"energy": energy, "growth_law": growth_law}
            shell = build_shell(scene, comm, **laws, counts=counts)
        else:
            shell = shells.borrow(scene, comm, counts)
            resources.callback(shells.give_back, shell)
        self._shell, self._zones = shell, shell.discretisation.zones
        self._dofs = dx.size_of(shell.space)
        self._recorder = recorder = Recorder(shell)
        observers = [] if observer is None else [observer]
        observers += [] if callback is None else [RowCallback(callback)]
        self._publisher = Publisher(shell.comm, Observers(observers))
        if shell.comm.bcast(state is not None):
            set_initial_state(shell, state)
        if sensitivities and start is not None:
            raise ValueError("a resumed run has no derivatives; run the scene from its start")
        if sensitivities:
            recorder.sensitivities = resources.enter_context(
                SensitivityRecorder(
                    Model(scene, energy, growth_law), shell, sensitivities, recorder.measurements
                )
            )
        compiled = perf_counter()
        tolerance = residual_tolerance(scene, len(shell.discretisation.nodes), bool(steps))
        self._others = resources.enter_context(OtherRanks(shell.comm))
        self._driver: Transient | Static
        if scene.path is not None:
            self._driver = Static(scene, scene.path, shell, recorder, tolerance, energy is None)
        else:
            self._driver = Transient(scene, shell, recorder, tolerance, energy is None, steps)
        resources.enter_context(self._driver)
        self._before = Timings()
        if start is not None and isinstance(self._driver, Transient):
            self._driver.restore(local(start.checkpoint, shell))
            recorder.restore(start.checkpoint.recorder, start.rows, start.profiles)
            self._before = start.checkpoint.timings
        self._steps = self._driver.run()
        self._checkpointer = None if keep is None else Checkpointer(shell, scene, keep)
        self._outcome: Outcome | None = None
        self._compile_s = compiled - self._began
        self._setup_s = perf_counter() - compiled
        self._run_s = self._output_s = self._total_s = 0.0
        self._lap: float | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Row:
        """Take the next step; publish its row and keep a checkpoint, if due.

        Raises
        ------
        KeyboardInterrupt
            If it is interrupted; the run has then ended and has its result.
        """
        if self._outcome is not None:
            raise StopIteration
        self._lap = perf_counter()
        try:
            row = next(self._steps)
            with self._output():
                self._publisher.publish(self._recorder.news)
                if self._checkpointer is not None:
                    self._checkpointer.offer(self._driver.checkpoint, self._timings())
            return row
        except StopIteration as end:
            self._end(end.value)
        except RootError as error:
            self._others.wait(error)
            self._free(Outcome("failed", f"the run failed: {error}"))
            raise error.__cause__ or error from None
        except KeyboardInterrupt as interrupt:
            self._interrupted(interrupt)
            raise
        except Exception as error:
            _LOG.debug("the run failed", exc_info=True)
            self._others.wait(error)
            self._end(Outcome("failed", f"the run failed: {type(error).__name__}: {error}"))
        finally:
            self._run_s, self._lap = self._in_steps(), None
        raise StopIteration

    def close(self) -> None:
        """End the run in its last state, unless it has ended."""
        if self._outcome is None:
            self._end(Outcome("interrupted", f"stopped at {self._time:g} min"))

    @property
    def result(self) -> Result:
        """Result so far; its status is interrupted until the run has ended."""
        rows, recorder = self._recorder.rows, self._recorder
        derivatives = recorder.sensitivities
        outcome = self._outcome or Outcome("interrupted", f"at {self._time:g} min so far")
        status, message = outcome.status, outcome.message
        note = stability_note(rows, recorder.bifurcation)
        estimate = self._driver.estimate_error()
        history = History(rows, kinks(self._scene))
        return Result(
            history=history,
            profiles=Profiles(tuple(recorder.profiles), self._zones),
            status=status,
            message=message + ("" if status == "failed" else note),
            end_time=self._time if outcome.time is None else outcome.time,
            dofs=self._dofs,
            steps=max(0, len(rows) - 1),
            rejected_steps=recorder.rejected,
            newton_iterations=recorder.iterations,
            timings=self._timings(),
            error_estimate=estimate,
            warnings=tuple(warnings(self._scene, recorder, self._outcome, estimate)),
            bifurcation=first_bifurcation(self._scene, recorder),
            mode=recorder.mode,
            sensitivities=None if derivatives is None else derivatives.result(history),
            unloaded=fit_of(self._scene),
        )

    @property
    def _time(self) -> float:
        """Time of the last accepted state in min."""
        rows = self._recorder.rows
        return rows[-1].time_min if rows else 0.0

    def _interrupted(self, interrupt: KeyboardInterrupt) -> None:
        """End a run in its last state, unless it has ended."""
        if self._outcome is None:
            self._others.wait(interrupt)
            self._end(Outcome("interrupted", f"interrupted at {self._time:g} min"))

    def _end(self, outcome: Outcome) -> None:
        """Save the last profile, publish it and keep a checkpoint; free the solvers."""
        self._outcome = outcome
        self._steps.close()
        try:
            if outcome.status != "finished":
                self._recorder.save()
            with self._output():
                self._publisher.publish(self._recorder.news)
                if self._checkpointer is not None:
                    self._checkpointer.finish(self._driver.checkpoint, self._timings())
        except RootError:  # it was raised before, or will be where the result is written
            pass
        finally:
            self._free(outcome)

    def _free(self, outcome: Outcome) -> None:
        self._outcome = outcome
        self._steps.close()
        self._resources.close()
        self._total_s = perf_counter() - self._began

    # --- timings --------------------------------------------------------------------------

    @contextmanager
    def _output(self) -> Iterator[None]:
        """Count the time spent here as output."""
        began = perf_counter()
        try:
            yield
        finally:
            self._output_s += perf_counter() - began

    def _in_steps(self) -> float:
        """Seconds in the steps so far, without what the caller does between them."""
        return self._run_s + (0.0 if self._lap is None else perf_counter() - self._lap)

    def _timings(self) -> Timings:
        """Where the time went so far, earlier parts of the run included."""
        output_s = self._recorder.output_s + self._output_s
        return self._before + Timings(
            compile_s=self._compile_s,
            setup_s=self._setup_s,
            loop_s=self._in_steps() - output_s,
            output_s=output_s,
            total_s=self._total_s or perf_counter() - self._began,
        )


def simulate(
    scene: Scene | str | Path,
    *,
    energy: OwnLaw | None = None,
    growth_law: OwnLaw | None = None,
    observer: Observer | None = None,
    callback: Callable[[Row], None] | None = None,
    comm: Any = None,
    state: Profile | None = None,
    start: ResumePoint | None = None,
    keep: Callable[[Checkpoint], None] | None = None,
    shells: ShellPool | None = None,
    sensitivities: Sequence[str] = (),
    replay: Replay | None = None,
) -> Result:
    """Run a scene from start to end.

    If the run stops early, the result says why and keeps what was computed.

    Parameters
    ----------
    scene
        What to simulate, or the file of a scene.
    energy, growth_law
        Laws of your own in place of the scene's: strain energy of the wall, growth rate in the
        zone. Each is a function in UFL, or a `mechanics.Law` that gives it parameters.
    observer
        Notified of every accepted step and every saved profile, on rank 0 only. An error that it
        raises ends the run and is raised here; other ranks raise a RuntimeError instead.
    callback
        Called with the row of each accepted step, on rank 0 only.
    comm
        MPI communicator whose ranks share the wall; by default all ranks of the world. Every
        rank gets the history; the profiles are on rank 0.
    state
        The wall at time 0, in place of the unloaded one: a profile of a run on the same nodes,
        or of a whole cell of which the scene is a piece (see `simulation.pieces`).
    start, keep, shells
        State from which to resume an earlier run, a function called with checkpoints, and what
        lends shells to many runs, as in `Simulation`.
    sensitivities
        Keys of numbers of the scene by which the history is differentiated: thickness, moduli and
        exponents of the wall, turgor, thresholds and growth times; or ``"energy.NAME"`` and
        ``"growth_law.NAME"``, parameters of your own laws.
    replay
        Steps, mesh and numerics of an earlier run of a similar scene, to be repeated.

    Returns
    -------
    Result
        History, profiles, and how the run ended.
    """
    with Simulation(
        scene,
        energy=energy,
        growth_law=growth_law,
        observer=observer,
        callback=callback,
        comm=comm,
        state=state,
        start=start,
        keep=keep,
        shells=shells,
        sensitivities=sensitivities,
        replay=replay,
    ) as simulation:
        try:
            for _ in simulation:
                pass
        except KeyboardInterrupt as interrupt:  # the result says so
            simulation._interrupted(interrupt)  # if that was between two steps
        return simulation.result
