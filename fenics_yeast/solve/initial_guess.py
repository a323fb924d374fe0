"""A flat membrane has no stiffness across its plane: where Newton's method may start instead."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .. import _dolfinx as dx
from ..mechanics import Shell

# Rise of the middle in radii, times (E h / (p a))^(1/3): Hencky's for ν = 1/2 is 0.60.
_RISE = 0.6


def inflate_flat_membrane(
    shell: Shell, load: Callable[[float, float], float], wanted: float
) -> float:
    """Blow a flat membrane that is at rest up to a paraboloid; leave every other wall alone.

    Parameters
    ----------
    shell
        The wall; its trial state is moved.
    load
        A function of volume in µm³ and pressure in MPa that grows with both.
    wanted
        The value that it shall have.

    Returns
    -------
    float
        The pressure in MPa that goes with it; the shell's own where nothing was moved.
    """
    if wanted == 0 or not is_flat_membrane(shell):
        return float(shell.pressure.value)
    curve = shell.discretisation.curve
    S, dofs = dx.node_dofs(shell.space)
    a = float(curve.radius(np.zeros(1))[0])

    def loaded(rise: float) -> tuple[float, float]:
        """Volume, and pressure of Hencky's solution, at a rise in radii."""
        return np.pi * a**3 * rise / 2, (rise / _RISE) ** 3 * shell.membrane_stiffness / a

    low, high = 0.0, 1.0
    for _ in range(50):
        rise = (low + high) / 2
        below = load(*loaded(rise)) < abs(wanted)
        low, high = (rise, high) if below else (low, rise)
    rise = float(np.copysign(low, wanted))
    shell.w.x.array[dofs[:, 1]] = rise * a * (1 - (curve.radius(S) / a) ** 2)
    shell.w.x.scatter_forward()
    return float(np.copysign(loaded(low)[1], wanted))


def is_flat_membrane(shell: Shell) -> bool:
    """Whether a wall is a membrane without height, and at rest."""
    if shell.bending:
        return False
    ends = np.array([0.0, shell.discretisation.curve.length])
    moved = bool(shell.w.x.array.any()) or bool(np.ptp(shell.discretisation.curve.height(ends)))
    return not shell.comm.allreduce(moved, op=dx.MPI.LOR)
