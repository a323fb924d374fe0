"""Initial guess for a flat membrane, whose tangent is singular: it has no transverse stiffness.

This is the only file of the room that knows a meridian.
"""

from collections.abc import Callable

import numpy as np

from .. import _dolfinx as dx
from ..mechanics import Shell

# Rise of the middle in radii over (p a / (E h))^(1/3), from Hencky's series; 0.60 for ν = 1/2.
_RISE = 0.6


def inflate_flat_membrane(
    shell: Shell, load: Callable[[float, float], float], target: float
) -> float:
    """Inflate a flat membrane at rest to a paraboloid; do nothing to any other wall.

    Parameters
    ----------
    shell
        The wall; its trial state is changed.
    load
        An increasing function of volume in µm³ and pressure in MPa.
    target
        The value of this function after inflation; the pressure in MPa there is returned.
    """
    if target == 0 or shell.bending:
        return float(shell.pressure.value)
    curve = shell.discretisation.curve
    height = curve.height(np.array([0.0, curve.length]))
    if shell.comm.allreduce(bool(shell.w.x.array.any() or np.ptp(height)), op=dx.MPI.LOR):
        return float(shell.pressure.value)
    S, dofs = dx.node_dofs(shell.space)
    a = float(curve.radius(np.zeros(1))[0])

    def inflated(rise: float) -> tuple[float, float]:
        """Return volume, and pressure of Hencky's solution, at a rise in radii."""
        return np.pi * a**3 * rise / 2, (rise / _RISE) ** 3 * shell.membrane_stiffness / a

    low, high = 0.0, 1.0
    for _ in range(50):
        rise = (low + high) / 2
        below = load(*inflated(rise)) < abs(target)
        low, high = (rise, high) if below else (low, rise)
    rise = float(np.copysign(low, target))
    shell.w.x.array[dofs[:, 1]] = rise * a * (1 - (curve.radius(S) / a) ** 2)
    shell.w.x.scatter_forward()
    return float(np.copysign(inflated(low)[1], target))
