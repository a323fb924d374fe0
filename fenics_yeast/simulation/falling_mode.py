"""The mode of a wall that falls, or is the next to fall, in the present state."""

from typing import Any

import numpy as np

from .. import _dolfinx as dx
from ..geometry import Array
from ..mechanics import Order, SecondVariation, Shell
from .buckling_mode import BucklingMode


def falling_mode(
    shell: Shell, variation: SecondVariation | None, waves: int
) -> BucklingMode | None:
    """Return the mode with the least stiffness of either sign in the trial state; collective.

    Parameters
    ----------
    shell
        The wall.
    variation
        Its second variation for waves around the axis; not needed without.
    waves
        Number of waves; 0 is the axisymmetric mode.

    Returns
    -------
    BucklingMode or None
        The mode; None if the stiffness is too near to singular.
    """
    from scipy.sparse import csr_array, vstack  # late: few walls buckle

    space, form, conditions = variation_of(shell, variation, waves)
    matrix = dx.create_matrix(form)
    dx.assemble_matrix(matrix, form, conditions)
    size, (first, last) = matrix.getSize()[1], matrix.getOwnershipRange()
    moving = dx.is_motion(space)
    for condition in conditions:
        moving[condition.dof_indices()[0]] = False
    rows, columns, values = matrix.getValuesCSR()
    part = csr_array((values, columns, rows), shape=(last - first, size))
    matrix.destroy()
    parts = shell.comm.gather((part, moving[: last - first]))
    softest = None
    if parts is not None:
        softest = _softest(vstack([p for p, _ in parts]), np.concatenate([m for _, m in parts]))
    softest = shell.comm.bcast(softest)
    if softest is None:
        return None
    vector = dx.fem.Function(space)
    vector.x.array[: last - first] = softest[first:last]
    vector.x.scatter_forward()
    S, dofs = dx.node_dofs(space)
    order, motion = Order(shell.comm, S), motion_of(vector.x.array[dofs], waves)
    curve, (of_wall, at) = shell.discretisation.curve, dx.node_dofs(shell.space)
    moved = Order(shell.comm, of_wall).allgather(shell.w.x.array[at][:, :2])
    S = order.allgather(S)
    place = S, curve.radius(S) + moved[:, 0], curve.height(S) + moved[:, 1]
    pressure = float(shell.pressure.value)
    return BucklingMode.of_motion(waves, pressure, place, order.allgather(motion))


def variation_of(
    shell: Shell, variation: SecondVariation | None, waves: int
) -> tuple[Any, Any, list[Any]]:
    """Return space, compiled form and conditions of the second variation for some waves."""
    if waves == 0 or variation is None:
        return shell.space, shell.forms.tangent, shell.conditions
    variation.waves.value = waves
    return variation.space, variation.form, variation.conditions(waves)


def motion_of(values: Array, waves: int) -> Array:
    """Return radial, circumferential and axial parts of the unknowns at nodes, ``(nodes, 3)``."""
    if waves == 0:
        return np.column_stack([values[:, 0], np.zeros(len(values)), values[:, 1]])
    return np.column_stack([values[:, 0], values[:, 1] - values[:, 0], values[:, 2]])


def _softest(matrix: Any, moving: Array) -> Array | None:
    """Return the motion that a force along it moves most, by Lanczos' method.

    Shear forces, and what is held, take no part: they only follow.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh, splu

    start = moving * np.linspace(1.0, 2.0, len(moving))  # not symmetric
    try:
        solve = splu(matrix.tocsc()).solve
        operator = LinearOperator(
            matrix.shape, matvec=lambda x: moving * solve(moving * x), dtype=float
        )
        _, vectors = eigsh(operator, k=1, which="LM", v0=start)
    except RuntimeError:  # a zero pivot, or no convergence
        return None
    found: Array = vectors[:, 0]
    return found
