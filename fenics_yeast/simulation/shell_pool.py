"""Shells that serve one run after another, so that forms are built once for all runs of a kind."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Sequence
from threading import Lock
from typing import Any, Self

from .. import _dolfinx as dx
from ..mechanics import Shell, structure_of
from ..scene import Scene
from .build import approximation_of, build_shell, set_force, wall_of
from .discretise import discretise

_MOST = 8  # idle shells


class ShellPool:
    """Lends shells to runs; a context manager.

    A shell that comes back waits for the next scene of the same structure, in which only numbers
    and places of nodes differ. Its results are the same to the last bit as those of a new one. At
    most eight wait, those that came back last; none outlives the pool. Several threads may borrow
    at once, with communicators of their own.
    """

    def __init__(self) -> None:
        self._idle: OrderedDict[int, tuple[Hashable, Shell]] = OrderedDict()
        self._lent: dict[int, Hashable] = {}
        self._lock = Lock()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._idle.clear()

    def borrow(self, scene: Scene, comm: Any = None, counts: Sequence[int] = ()) -> Shell:
        """Return the unloaded shell of a scene, on all ranks of a communicator; collective.

        `counts` are as in `discretise`.
        """
        comm = dx.MPI.COMM_WORLD if comm is None else comm
        mesh = discretise(scene, counts)
        parts = mesh, wall_of(scene, mesh), approximation_of(scene)
        key = structure_of(*parts, comm)
        shell = self._take(key)
        if shell is None:
            shell = build_shell(scene, comm, counts=counts)
        else:
            shell.reset(*parts)
            set_force(scene, shell)
        with self._lock:
            self._lent[id(shell)] = key
        return shell

    def give_back(self, shell: Shell) -> None:
        """Take a shell back that nothing uses any more."""
        with self._lock:
            key = self._lent.pop(id(shell), None)
            if key is not None:
                self._idle[id(shell)] = (key, shell)
            while len(self._idle) > _MOST:
                self._idle.popitem(last=False)

    def _take(self, key: Hashable) -> Shell | None:
        with self._lock:
            for number, (idle, shell) in self._idle.items():
                if idle == key:
                    del self._idle[number]
                    return shell
        return None
