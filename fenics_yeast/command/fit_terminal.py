"""Screens of a fit: what was tried, and a table of the numbers found."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from .terminal import print_line

if TYPE_CHECKING:
    from ..scene import FitProblem
    from ..studies import Evaluation, FitResult


class FitLines:
    """A plain line whenever a fit finds better values."""

    def __init__(self, problem: FitProblem) -> None:
        self._problem, self._count, self._least = problem, 0, float("inf")

    def tried(self, evaluation: Evaluation) -> None:
        """Show what was tried."""
        self._count += 1
        better = evaluation.complete and evaluation.chi2 < 0.999 * self._least
        if better:
            self._least = evaluation.chi2
        self._show(self._line(evaluation), better)

    def end(self) -> None:
        """End the output."""

    def _line(self, evaluation: Evaluation) -> str:
        from ..studies import Unknowns

        unknowns = Unknowns(self._problem)
        values = unknowns.values(evaluation.x).tolist()
        pairs = list(zip(unknowns.names, values, strict=True))[: len(self._problem.varied)]
        shown = " ".join(f"{name}={value:.5g}" for name, value in pairs)
        chi2 = f"chi2 = {evaluation.chi2:.6g}" if evaluation.complete else "a run ended early"
        return f"{self._count:4}  {shown}: {chi2}"

    def _show(self, line: str, better: bool) -> None:
        if better:
            print_line(line)


class FitLine(FitLines):
    """One line that is redrawn on a terminal."""

    def _show(self, line: str, better: bool) -> None:
        from shutil import get_terminal_size

        width = get_terminal_size().columns - 1
        typer.echo("\r" + line[:width].ljust(width), nl=False)

    def end(self) -> None:
        """Leave the line."""
        if self._count:
            typer.echo("")


def print_estimates(result: FitResult, judged: bool = True) -> None:
    """Print the numbers with their intervals, chi2 and the warnings."""
    width = max(len(one.key) for one in result.parameters)
    for one in result.parameters:
        limit = "  at a limit" if one.at_limit and judged else ""
        interval = f"{one.low:.4g} to {one.high:.4g} {one.unit}".rstrip()
        print_line(f"{one.key:{width}}  {one.value:.5g} ({interval}){limit}")
    if judged:
        print_line(f"chi2 = {result.chi2:.4g} for {result.degrees_of_freedom} degrees of freedom")
    for warning in result.warnings:
        print_line(f"warning: {warning}")
