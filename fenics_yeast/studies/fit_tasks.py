"""Searches of a fit, side by side in processes of this machine or one after another."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass

from ..geometry import Array
from ..scene import FitProblem
from .execution import processes, shells_of_process, stopping, submit
from .fit_model import Evaluation, FitModel
from .fit_search import Solution, search


@dataclass(frozen=True)
class Task:
    """A search from a start, with an unknown held or none."""

    problem: FitProblem
    start: Array
    held: int | None = None


class Team:
    """Runs searches: in this process with the shells of a model, or in several processes."""

    def __init__(self, model: FitModel, jobs: int) -> None:
        self._model, self._jobs, self.runs = model, jobs, 0

    def run(self, tasks: Sequence[Task]) -> list[Solution]:
        """Return the solutions of tasks, in their order.

        Raises
        ------
        KeyboardInterrupt
            If a run is interrupted.
        """
        if self._jobs == 1 or len(tasks) == 1:
            return [self._alone(task) for task in tasks]
        found: dict[int, Solution] = {}
        with processes(min(self._jobs, len(tasks))) as pool:
            futures = {submit(pool, _work, task): i for i, task in enumerate(tasks)}
            for future in as_completed(futures):
                i = futures[future]
                found[i], tried = future.result()
                self.runs += found[i].runs
                if tasks[i].problem is self._model.problem:  # not of made data
                    for evaluation in tried:
                        self._model.report(evaluation)
        return [found[i] for i in range(len(tasks))]

    def _alone(self, task: Task) -> Solution:
        model = self._model.for_problem(task.problem)
        solution = search(model, task.start, task.held)
        if model is not self._model:
            self.runs += solution.runs
        return solution


def _work(task: Task) -> tuple[Solution, list[Evaluation]]:
    """Search in a process of its own; return what was tried, too."""
    tried: list[Evaluation] = []

    def keep(evaluation: Evaluation) -> None:
        tried.append(evaluation)
        if stopping():
            raise KeyboardInterrupt

    model = FitModel(task.problem, shells_of_process(), keep)
    return search(model, task.start, task.held), tried
