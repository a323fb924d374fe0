"""Linear buckling of the unloaded wall under external pressure, for each number of waves."""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.sparse import block_diag, bmat, csc_array, csr_array
from scipy.sparse.linalg import LinearOperator, eigs, splu

from .. import _dolfinx as dx
from ..mechanics import SecondVariation, Shell
from ..scene import Scene
from ..solve import Equilibrium
from .buckling_mode import BucklingMode
from .build import build_shell
from .falling_mode import motion_of, variation_of
from .scales import pressure_scale, residual_tolerance
from .unloaded_shape import find_unloaded

_SMALL = 1e-3  # pressure over that of a buckled sphere, to differentiate the second variation
_SOUGHT = 6  # eigenvalues, of which the first real one counts
_REAL = 1e-6  # imaginary part of an eigenvalue that counts as real


def buckling_modes(scene: Scene, waves: Sequence[int]) -> Iterator[BucklingMode]:
    """Yield the first mode of linear buckling for each number of waves, on one rank.

    The second variation is taken at the unloaded wall and under a very small external pressure,
    without growth and other loads; it is extrapolated to the pressure at which it is singular.

    Parameters
    ----------
    scene
        The cell and its wall.
    waves
        Numbers of waves; 0 is the axisymmetric mode.
    """
    changes: dict[str, object] = dict.fromkeys(("growth", "run", "load", "septum"))
    pressure = -_SMALL * scene.wall.thickness / scene.cell.radius * pressure_scale(scene)
    changes |= {
        "path": {"until": {"pressure": pressure}},
        "turgor": {"pressure": scene.turgor.initial},
    }
    wall = find_unloaded(scene, dx.MPI.COMM_SELF).with_values(changes)
    shell = build_shell(wall, dx.MPI.COMM_SELF)
    tolerance = residual_tolerance(wall, len(shell.discretisation.nodes))
    variation = shell.second_variation if any(n > 0 for n in waves) else None
    with Equilibrium(shell, tolerance) as equilibrium:
        stiffness = {n: _matrix(shell, variation, n) for n in waves}
        shell.pressure.value = pressure
        equilibrium.solve()
        for n in waves:
            change = (_matrix(shell, variation, n) - stiffness[n]) / pressure
            yield _first(shell, variation, n, stiffness[n], change)


def _matrix(shell: Shell, variation: SecondVariation | None, waves: int) -> csc_array:
    """Return the second variation in the trial state.

    A closed cell with one wave is free to move across its axis and to tilt: a condition at a pole
    would hardly hold it, as the wall deforms around a point.
    """
    _, form, conditions = variation_of(shell, variation, waves)
    if _is_free(shell, waves) and variation is not None:
        conditions = variation.supports(one_wave=True)
    matrix = dx.create_matrix(form)
    dx.assemble_matrix(matrix, form, conditions)
    rows, columns, values = matrix.getValuesCSR()
    found = csr_array((values, columns, rows), shape=matrix.getSize())
    matrix.destroy()
    return csc_array((found + found.T) / 2)


def _is_free(shell: Shell, waves: int) -> bool:
    return waves == 1 and shell.discretisation.ends == ("pole", "pole")


def _first(
    shell: Shell,
    variation: SecondVariation | None,
    waves: int,
    stiffness: csc_array,
    change: csc_array,
) -> BucklingMode:
    """Return the mode of the external pressure of least size at which the matrix is singular."""
    if variation is not None and _is_free(shell, waves):
        # No part of the mode may be a rigid motion.
        rigid = csc_array(np.column_stack(variation.rigid_motions()))
        stiffness = csc_array(bmat([[stiffness, rigid], [rigid.T, None]]))
        change = csc_array(block_diag([change, csc_array((2, 2))]))
    solve = splu(stiffness).solve
    size = stiffness.shape[0]
    operator = LinearOperator((size, size), matvec=lambda x: solve(change @ x), dtype=float)
    # Eigenvalues of -1/p; the start must not be symmetric.
    values, vectors = eigs(operator, k=_SOUGHT, which="LR", v0=np.linspace(1.0, 2.0, size))
    real = abs(values.imag) <= _REAL * abs(values)
    external = np.flatnonzero(real & (values.real > 0))
    S, dofs = dx.node_dofs(variation_of(shell, variation, waves)[0])
    order = np.argsort(S)
    curve, S = shell.discretisation.curve, S[order]
    place = S, curve.radius(S), curve.height(S)
    if not len(external):
        return BucklingMode.of_motion(waves, None, place, np.zeros((len(S), 3)))
    first = external[np.argmax(values.real[external])]
    motion = motion_of(vectors[:, first].real[dofs[order]], waves)
    return BucklingMode.of_motion(waves, -1.0 / float(values.real[first]), place, motion)
