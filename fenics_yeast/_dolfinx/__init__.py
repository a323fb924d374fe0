"""dolfinx in all its versions: meshes, spaces, compiled forms and their assembly.

Only this room knows the differences between versions.
"""

from .assembly import (
    accumulate,
    assemble_matrix,
    assemble_scalar,
    assemble_vector,
    constrain,
    create_matrix,
    evaluator,
)
from .compile import (
    compile_expression,
    compile_form,
)
from .spaces import (
    argument_space,
    circumferential_space,
    dof_array,
    dof_places,
    element_tags,
    element_vertices,
    end_dofs,
    end_tag,
    interval_mesh,
    is_mixed,
    is_motion,
    membrane_space,
    motion_part,
    node_dofs,
    quadrature_points,
    quadrature_space,
    quadrature_weights,
    shell_space,
    size_of,
    size_of_second,
)
from .versions import MPI, PETSc, basix_ufl, dolfinx, fem

__all__ = [
    "MPI",
    "PETSc",
    "accumulate",
    "argument_space",
    "assemble_matrix",
    "assemble_scalar",
    "assemble_vector",
    "basix_ufl",
    "circumferential_space",
    "compile_expression",
    "compile_form",
    "constrain",
    "create_matrix",
    "dof_array",
    "dof_places",
    "dolfinx",
    "element_tags",
    "element_vertices",
    "end_dofs",
    "end_tag",
    "evaluator",
    "fem",
    "interval_mesh",
    "is_mixed",
    "is_motion",
    "membrane_space",
    "motion_part",
    "node_dofs",
    "quadrature_points",
    "quadrature_space",
    "quadrature_weights",
    "shell_space",
    "size_of",
    "size_of_second",
]
