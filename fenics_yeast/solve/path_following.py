"""Path following: the equilibria of a wall at given growth under a changing load.

Along the path the load, its conjugate (volume of a pressure, displacement of a force) or the arc
length between points is prescribed; the latter two take it over limit points of the load. Where
the conjugate turns back, the path continues by arc length in all displacements: Riks (1979) and
Keller (1977), cited in `continuation`, but without the load, as in M. A. Crisfield, A fast
incremental/iterative solution procedure that handles "snap-through", Comput. Struct. 13 (1981)
55-62.
"""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign
from typing import Any, Literal

import numpy as np

from .. import _dolfinx as dx
from ..geometry import Array
from ..mechanics import Shell
from .continuation import BorderedNewton
from .equilibrium import EquilibriumError
from .predictor import extrapolate

Control = Literal["pressure", "volume", "arc-length", "force", "displacement"]

LEAST_STEP = 2.0**-10  # of the first step
_LEAST_ARC = 2.0**-20
_LENGTHENING = 1.05  # of steps beyond the number asked for
_BEGINNING = 2.0**-6  # of the first step, to see where the path leads
_NEAR = 1e-7  # of a unit: closer to the target is at the target
# Distance from the tangent, in steps, that is another part of the path: in general, and in an arc.
_STRAY, _STRAY_ALONG = 0.15, 0.1
_LEAST_COSINE = 0.6  # between chord and tangent of an arc
_MOST_POINTS = 20  # times the number of steps asked for
_MOST_POINTS_OF_TURNS = 2000  # of a path that turns back


class PathError(RuntimeError):
    """The path has no further point under this control; the shell is at its last point."""


@dataclass(frozen=True)
class PathCoordinates:
    """The plane in which a path runs: the conjugate of a load, and the load.

    Attributes
    ----------
    load
        `shell.pressure` or `shell.force`, whose value is the unknown.
    conjugate_unit, load_unit
        Units of the coordinates: volume in µm³ and pressure in MPa, or displacement in µm and
        force in µN. The arc length is measured in these units.
    """

    load: Any
    conjugate_unit: float
    load_unit: float


@dataclass(frozen=True)
class PathTarget:
    """Where a path ends: coordinate 0, the conjugate, or 1, the load, and its value in its unit."""

    axis: Literal[0, 1]
    value: float


def follow_path(
    shell: Shell,
    coordinates: PathCoordinates,
    control: Control,
    target: PathTarget,
    steps: int,
    tolerance: float,
    closed: bool,
) -> Iterator[int]:
    """Follow the equilibrium path of a wall from its trial state to a target.

    Yields the Newton iterations of each point, whose state and load are then those of the shell.

    Parameters
    ----------
    shell
        The wall in equilibrium, without this load.
    coordinates
        The load, its conjugate and their units.
    control
        What is prescribed from point to point: the load, its conjugate, or the arc length. Where
        the conjugate turns back, the arc length takes its place.
    target
        Where the path ends; the last point meets it exactly.
    steps
        Number of steps to begin with; they are shorter where the path turns.
    tolerance
        Norm of the residual in µN at which it counts as zero.
    closed
        Whether the wall is closed, so that a volume below 0 means that it is inside out.

    Raises
    ------
    PathError
        At a limit point that the control cannot pass, or if no step converges.
    """
    with BorderedNewton(shell, coordinates.load, tolerance) as solver:
        path = _Path(shell, coordinates, solver, target, closed)
        if abs(path.ahead) < _NEAR:
            return
        step = abs(path.ahead) / steps
        if control == "arc-length":
            path.begin(step)
            yield from _by_displacements(path, step, steps)
            return
        try:
            yield from _by_coordinate(path, int(control in ("pressure", "force")), step, steps)
        except PathError:
            if control in ("pressure", "force") or len(path.points) < 2:
                raise
            path.forget_tangent()
            yield from _by_displacements(path, step, steps)


def _by_coordinate(path: "_Path", axis: int, whole: float, steps: int) -> Iterator[int]:
    """Take steps in the conjugate, coordinate 0, or the load, coordinate 1."""
    step, direction = whole, copysign(1.0, path.ahead) * np.eye(2)[axis]
    for count in range(_MOST_POINTS * steps):
        length, position = path.points[-1].length + step, path.points[-1].position
        try:
            expected = path.expect(direction, step)
            path.predict(length)
            iterations = path.solve(direction, float(direction @ position) + step)
            path.refuse_jump(expected, iterations)
            iterations += path.stop_at_target(length)
        except EquilibriumError as error:
            path.reject()
            step /= 2
            if step < LEAST_STEP * whole:
                raise PathError(f"no step from here converged: {error}") from error
            continue
        yield iterations
        if path.finished:
            return
        if count > steps:  # the path is longer than the steps asked for
            whole *= _LENGTHENING
        step = min(whole, 1.5 * step)
    raise PathError(f"the target was not reached in {_MOST_POINTS * steps} points")


def _by_displacements(path: "_Path", whole: float, steps: int) -> Iterator[int]:
    """Take steps of arc length in the displacements, which may pass any turn of the path.

    Their size keeps to a length in the plane of the coordinates, or is less.
    """
    step = whole * path.displacement_by_length()
    least = _LEAST_ARC * step
    for count in range(max(_MOST_POINTS * steps, _MOST_POINTS_OF_TURNS)):
        try:
            iterations = path.solve_along(step) + path.stop_at_target()
        except EquilibriumError as error:
            path.reject()
            step /= 2
            if step < least:
                raise PathError(f"no step from here converged: {error}") from error
            continue
        yield iterations
        if path.finished:
            return
        if count > steps:
            whole *= _LENGTHENING
        step = min(whole * path.displacement_by_length(), 1.5 * step)
    raise PathError("the target was not reached by arc length")


@dataclass(frozen=True)
class _Point:
    """A point of a path: DOFs and load, position in the plane, and length up to it."""

    state: Array
    position: Array
    length: float


class _Path:
    """The last points of a path, and the search for the next one."""

    def __init__(
        self,
        shell: Shell,
        coordinates: PathCoordinates,
        solver: BorderedNewton,
        target: PathTarget,
        closed: bool,
    ) -> None:
        self._shell, self._solver, self._target, self._closed = shell, solver, target, closed
        self._load = coordinates.load
        self._units = np.array([coordinates.conjugate_unit, coordinates.load_unit])
        self._motion = dx.node_dofs(shell.space)[1][:, :2].ravel()  # displacements
        self.points = deque([self._here()], maxlen=3)
        self._sign = copysign(1.0, self.ahead)
        self._tangent: Array | None = None  # at the last point, and at the next one
        self._next: Array | None = None
        self.finished = False

    @property
    def ahead(self) -> float:
        """How far the target is ahead of the last point, along its axis."""
        return float(self._target.value - self.points[-1].position[self._target.axis])

    def begin(self, step: float) -> None:
        """Make a very small step in the conjugate, which shows where the path leads.

        Raises
        ------
        PathError
            If there is no equilibrium.
        """
        start, direction = self.points[-1], np.array([self._sign, 0.0])
        part = _BEGINNING * step
        try:
            self.solve(direction, float(direction @ start.position) + part)
        except EquilibriumError as error:
            self.reject()
            raise PathError(f"no step from here converged: {error}") from error
        self.points.append(self._here(start.length + part))

    def expect(self, direction: Array, step: float) -> Array | None:
        """Return where a step leads to first order; None for a wall at rest that is no shell.

        A flat membrane has no stiffness at rest.
        """
        last = self.points[-1]
        if len(self.points) == 1 and not self._shell.bending:
            return None
        if self._tangent is None:
            self._tangent, change = self._solver.tangent()
            by_load = float(direction @ (np.array([change, 1.0]) / self._units))
            self._tangent /= by_load
        return last.state + step * self._tangent

    def predict(self, length: float) -> None:
        """Move the shell to where the last points lead."""
        self._set(extrapolate([(point.length, point.state) for point in self.points], length))

    def solve(self, direction: Array, projection: float) -> int:
        """Find the equilibrium whose position has a given projection on a direction."""
        unit = self._units[0]  # of the equation: a volume, or a displacement
        weights = direction * unit / self._units
        return self._checked(self._solver.solve(projection * unit, (weights[0], weights[1])))

    def solve_along(self, step: float) -> int:
        """Find the equilibrium in the hyperplane across the path at a distance from the last point.

        The path leads on in the direction in which it came.
        """
        last = self.points[-1].state
        if self._tangent is None:
            self._tangent = self._find_tangent(self._displacement(last, self.points[-2].state))
        normal = np.zeros(len(last) - 1)
        normal[self._motion] = self._tangent[:-1][self._motion]
        predicted = last + step * self._tangent
        self._set(predicted)
        iterations = self._checked(self._solver.solve_in_plane(normal, predicted[:-1], step))
        self.refuse_jump(predicted, iterations, _STRAY_ALONG)
        self._next = self._find_tangent(self._displacement(self._here().state, last), iterations)
        return iterations

    def _find_tangent(self, chord: Array, iterations: int = 0) -> Array:
        """Return the unit tangent of the path here, in the direction of the last chord."""
        tangent, _ = self._solver.tangent()
        motion = tangent[:-1][self._motion]
        sizes = self._norm(motion), self._norm(chord)
        cosine = self._dot(motion, chord) / (sizes[0] * sizes[1])
        if not abs(cosine) > _LEAST_COSINE:
            raise EquilibriumError("the path turns too sharply for the step", iterations)
        return tangent * copysign(1 / sizes[0], cosine)

    def refuse_jump(self, expected: Array | None, iterations: int, stray: float = _STRAY) -> None:
        """Raise EquilibriumError if the shell strays from where the path leads, in steps."""
        if expected is None:
            return
        last = self.points[-1].state
        moved = self._displacement(self._here().state, last)
        along = self._displacement(expected, last)
        part = self._dot(moved, along) / self._dot(along, along)
        missed = self._norm(moved - part * along)
        # A wall that stiffens moves less than expected.
        if not 0 < part < 1 + stray or missed > stray * self._norm(moved):
            raise EquilibriumError("only another part of the path was found", iterations)

    def displacement_by_length(self) -> float:
        """Return displacement, in all nodes, over length in the plane between the last points."""
        last, before = self.points[-1], self.points[-2]
        length = float(np.hypot(*(last.position - before.position)))
        return self._norm(self._displacement(last.state, before.state)) / max(length, _NEAR)

    def stop_at_target(self, length: float = 0.0) -> int:
        """Make the shell's state the next point or, beyond the target, the equilibrium there.

        Returns the further Newton iterations.
        """
        last, here, iterations = self.points[-1], self._here(length), 0
        axis, value = self._target.axis, self._target.value
        if self._sign * (value - here.position[axis]) < _NEAR:
            part = (value - last.position[axis]) / (here.position[axis] - last.position[axis])
            predicted = last.state + part * (here.state - last.state)
            self._set(predicted)
            iterations = self.solve(np.eye(2)[axis], value)
            self.refuse_jump(predicted, iterations)
            self.finished = True
        self.points.append(self._here(length))
        self._tangent, self._next = self._next, None
        return iterations

    def forget_tangent(self) -> None:
        """Forget the tangent, whose length is that of steps in a coordinate."""
        self._tangent = None

    def reject(self) -> None:
        """Return the shell to the last point."""
        self.finished, self._next = False, None
        self._set(self.points[-1].state)

    def _here(self, length: float = 0.0) -> _Point:
        load = float(self._load.value)
        position = np.array([self._solver.conjugate(), load]) / self._units
        return _Point(np.append(self._shell.w.x.array, load), position, length)

    def _set(self, state: Array) -> None:
        self._shell.w.x.array[:], self._load.value = state[:-1], float(state[-1])

    def _checked(self, iterations: int) -> int:
        if self._closed and self._shell.volume() <= 0:
            raise EquilibriumError("only a wall that is inside out was found", iterations)
        return iterations

    def _displacement(self, state: Array, other: Array) -> Array:
        return (state - other)[self._motion]

    def _dot(self, a: Array, b: Array) -> float:
        return float(self._shell.comm.allreduce(float(a @ b)))

    def _norm(self, displacement: Array) -> float:
        return self._dot(displacement, displacement) ** 0.5
