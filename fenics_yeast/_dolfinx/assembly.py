"""Assemble compiled forms, and evaluate compiled expressions."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .together import Planned
from .versions import ADD, EVAL_ON_MESH, MPI, PETSc, dolfinx, fem

cpp = dolfinx.cpp.fem


def evaluator(
    expression: Any, mesh: Any, elements: NDArray[np.int32]
) -> Callable[[], NDArray[np.float64]]:
    """Return what evaluates a compiled expression, shape ``(elements, points size)``.

    The size of an expression with a test function includes the number of its DOFs.
    """
    if isinstance(expression, Planned):
        return lambda: np.zeros((len(elements), 0))
    if not EVAL_ON_MESH:  # dolfinx 0.5, without the checks of its wrapper
        argument = expression.argument_function_space
        dofs = 1 if argument is None else argument.element.space_dimension
        shape = len(elements), len(expression.X()) * expression.value_size * dofs
        compiled = expression._cpp_object

        def evaluate() -> NDArray[np.float64]:
            values = np.zeros(shape)
            compiled.eval(elements, values)
            return values

        return evaluate

    def evaluate_on_mesh() -> NDArray[np.float64]:
        values = np.asarray(expression.eval(mesh, elements))
        return values.reshape(len(elements), np.prod(values.shape[1:], dtype=int))  # or none

    return evaluate_on_mesh


def _packed(form: Any) -> tuple[Any, Any]:
    """Return constants and coefficients of a compiled form, as the assembly takes them."""
    return cpp.pack_constants(form), cpp.pack_coefficients(form)


def accumulate(function: Any) -> None:
    """Add the contributions assembled into ghosts to their owners."""
    function.x.scatter_reverse(ADD)


def create_matrix(form: Any) -> Any:
    """Return a PETSc matrix with the sparsity of a compiled bilinear form."""
    return dolfinx.fem.petsc.create_matrix(form)


def assemble_matrix(matrix: Any, form: Any, conditions: Sequence[Any]) -> None:
    """Assemble a compiled bilinear form; constrained rows and columns become those of 1."""
    matrix.zeroEntries()
    if EVAL_ON_MESH:
        dolfinx.fem.petsc.assemble_matrix(matrix, form, conditions)
    else:  # dolfinx 0.5, without the dispatch of its wrapper
        cpp.petsc.assemble_matrix(matrix, form, *_packed(form), conditions)
        matrix.assemble(PETSc.Mat.AssemblyType.FLUSH)
        cpp.petsc.insert_diagonal(matrix, form.function_spaces[0], conditions, 1.0)
    matrix.assemble()


def constrain(matrix: Any, conditions: Sequence[Any]) -> None:
    """Turn the rows and columns of homogeneous conditions into those of 1."""
    first, last = matrix.getOwnershipRange()
    dofs = first + np.concatenate([condition.dof_indices()[0] for condition in conditions])
    matrix.zeroRowsColumns(dofs[dofs < last], diag=1.0)


def assemble_vector(values: NDArray[np.float64], form: Any) -> None:
    """Add a compiled linear form to local values, ghosts among them."""
    if EVAL_ON_MESH:
        fem.assemble_vector(values, form)
    else:  # dolfinx 0.5, without the dispatch of its wrapper
        cpp.assemble_vector(values, form, *_packed(form))


def assemble_scalar(form: Any, comm: Any) -> float:
    """Assemble a compiled functional, summed over the ranks."""
    if isinstance(form, Planned):
        return 0.0
    if EVAL_ON_MESH:
        value = float(fem.assemble_scalar(form))
    else:
        value = float(cpp.assemble_scalar(form, *_packed(form)))
    return value if comm.size == 1 else float(comm.allreduce(value, op=MPI.SUM))
