"""Buckling modes: how a wall moves where it is no longer stable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry import Array


@dataclass(frozen=True)
class BucklingMode:
    """A mode of a wall of revolution, with a largest displacement of 1.

    Attributes
    ----------
    waves
        Number of waves n around the axis.
    pressure
        Pressure in MPa at which it falls, negative if external; None if the wall does not buckle.
    S, r, z
        Arc length in the unloaded wall, radius and height in µm of the nodes, shape ``(nodes,)``.
    radial, around, axial
        Displacements at the nodes along the radius, around the axis and along the axis: times
        cos nθ, sin nθ and cos nθ.
    """

    waves: int
    pressure: float | None
    S: Array
    r: Array
    z: Array
    radial: Array
    around: Array
    axial: Array

    @classmethod
    def of_motion(
        cls, waves: int, pressure: float | None, place: tuple[Array, Array, Array], motion: Array
    ) -> BucklingMode:
        """Return the mode of nodes at `S, r, z` with a motion of any length.

        `motion` has the components along the radius, around the axis and along the axis, shape
        ``(nodes, 3)``; it is zero where there is no mode.
        """
        largest = np.argmax(np.linalg.norm(motion, axis=1))
        sign = -1.0 if motion[largest].sum() < 0 else 1.0
        length = np.linalg.norm(motion[largest]) or 1.0
        return cls(waves, pressure, *place, *(sign / length * motion).T)
