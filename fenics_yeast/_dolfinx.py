"""What differs between versions of dolfinx, told apart by feature; no other module asks.

Known to run: dolfinx 0.5 (Debian 12), 0.9 (Debian 13) and 0.11 (PyPI).
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterator, Sequence
from inspect import signature
from typing import Any, TypeVar

import numpy as np
import ufl
from numpy.typing import NDArray
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.multifunction import MultiFunction
from ufl.variable import Label

with contextlib.suppress(ImportError):  # the wheel from PyPI, whose libraries it has to find first
    import dolfinx_solver  # noqa: F401

try:
    import basix
    import petsc4py

    petsc4py.init(["-no_signal_handler"])  # a closed pipe or Ctrl-C is ours to answer
    import dolfinx.fem.petsc
    import dolfinx.mesh
    from dolfinx import fem, jit, la
    from mpi4py import MPI
    from petsc4py import PETSc
except ImportError as error:
    raise ImportError(
        f"dolfinx cannot be imported ({error}); on Debian: sudo apt install python3-dolfinx, "
        "then use /usr/bin/python3 or a virtual environment of it with --system-site-packages; "
        "elsewhere, with Python 3.12 or later: pip install dolfinx-solver-real"
    ) from error

try:
    import basix.ufl as basix_ufl
except ImportError:  # dolfinx 0.5 describes elements in ufl
    basix_ufl = None

from . import _form_cache
from .geometry import NEAR

__all__ = [
    "MPI",
    "PETSc",
    "accumulate",
    "assemble_matrix",
    "assemble_scalar",
    "compile_expression",
    "compile_form",
    "create_matrix",
    "dof_array",
    "element_tags",
    "element_vertices",
    "end_dofs",
    "end_tag",
    "evaluate",
    "fem",
    "interval_mesh",
    "is_mixed",
    "membrane_space",
    "motion_part",
    "node_dofs",
    "quadrature_points",
    "quadrature_space",
    "shell_space",
    "size_of",
    "size_of_second",
    "unknown_places",
]

_ADD = (la.InsertMode if hasattr(la, "InsertMode") else la.ScatterMode).add
_NEW_SPACES = hasattr(fem, "functionspace")
_NEW_JIT = "jit_options" in signature(fem.form).parameters
_EVAL_ON_MESH = "mesh" in signature(fem.Expression.eval).parameters
_JIT = {"cffi_extra_compile_args": ["-O2", "-fno-math-errno"], "cffi_libraries": ["m"]}
_JIT_KEYWORD = "jit_options" if _NEW_JIT else "jit_params"
# What fem.form adds to the options, which are part of a form's name in the cache.
_SCALAR = {"scalar_type": dolfinx.default_scalar_type} if _NEW_JIT else {}
_COMPILERS = ("cffi", "distutils", "setuptools")  # whose errors are no errors of a form

T = TypeVar("T")


def interval_mesh(comm: Any, nodes: NDArray[np.float64]) -> Any:
    """Interval mesh with the given increasing vertex coordinates, shape ``(n + 1,)``."""
    n = len(nodes) - 1
    mesh = dolfinx.mesh.create_interval(comm, n, [0.0, float(n)])
    mesh.geometry.x[:, 0] = nodes[np.rint(mesh.geometry.x[:, 0]).astype(int)]
    domain = mesh.ufl_domain()
    if hasattr(domain, "_ufl_coordinate_element") and basix_ufl is None:
        # Else the first compilation of a process changes the element, and with it the
        # signatures of later forms: nothing would be found in the cache.
        domain._ufl_coordinate_element = ufl.VectorElement(
            "Lagrange", domain.ufl_cell(), 1, variant="equispaced", dim=1
        )
    return mesh


def _space(mesh: Any, element: Any) -> Any:
    if _NEW_SPACES:
        return fem.functionspace(mesh, element)
    return _compiled(mesh.comm, element, lambda **jit: fem.FunctionSpace(mesh, element, **jit))


def shell_space(mesh: Any, order: int) -> Any:
    """Mixed space of ``(u_r, u_z, β)``, continuous, and of ``Q``, discontinuous."""
    if basix_ufl is not None:
        cell = mesh.basix_cell()
        motion = basix_ufl.element("Lagrange", cell, order, shape=(3,))
        shear = basix_ufl.element("DG", cell, order - 1)
        return _space(mesh, basix_ufl.mixed_element([motion, shear]))
    cell = mesh.ufl_cell()
    motion = ufl.VectorElement("Lagrange", cell, order, dim=3)
    shear = ufl.FiniteElement("DG", cell, order - 1)
    return _space(mesh, ufl.MixedElement([motion, shear]))


def membrane_space(mesh: Any, order: int) -> Any:
    """Space of ``(u_r, u_z)``, continuous."""
    if basix_ufl is not None:
        element = basix_ufl.element("Lagrange", mesh.basix_cell(), order, shape=(2,))
        return _space(mesh, element)
    return _space(mesh, ufl.VectorElement("Lagrange", mesh.ufl_cell(), order, dim=2))


def element_tags(mesh: Any, values: NDArray[np.int32]) -> Any:
    """Tags of all local cells, ghosts among them."""
    cells = np.arange(len(values), dtype=np.int32)
    return dolfinx.mesh.meshtags(mesh, mesh.topology.dim, cells, values)


def end_tag(mesh: Any, S: float) -> Any:
    """Tag 1 at the end of the mesh with arc length `S`."""
    tolerance = NEAR * max(abs(S), 1.0)
    vertices = dolfinx.mesh.locate_entities_boundary(
        mesh, 0, lambda x: np.abs(x[0] - S) < tolerance
    )
    ones = np.ones(len(vertices), dtype=np.int32)
    return dolfinx.mesh.meshtags(mesh, 0, vertices, ones)


def element_vertices(mesh: Any) -> NDArray[np.int32]:
    """Indices of the two ends of each local cell in the geometry, shape ``(cells, 2)``."""
    geometry = mesh.geometry
    dofmap = geometry.dofmaps[0] if hasattr(geometry, "dofmaps") else geometry.dofmap
    return np.asarray(getattr(dofmap, "array", dofmap)).reshape(-1, 2)


def end_dofs(space: Any, component: int, S: float) -> NDArray[np.int32]:
    """Degrees of freedom of a component of the motion at the end of the mesh at `S`."""
    tolerance = NEAR * max(abs(S), 1.0)
    vertices = dolfinx.mesh.locate_entities_boundary(
        space.mesh, 0, lambda x: np.abs(x[0] - S) < tolerance
    )
    return fem.locate_dofs_topological(motion_part(space, component), 0, vertices)


def motion_part(space: Any, component: int) -> Any:
    """Sub-space of a component of the motion."""
    return space.sub(0).sub(component) if is_mixed(space) else space.sub(component)


def node_dofs(space: Any) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Arc length of the owned nodes and the dofs of their motion, shape ``(n, 3)`` or ``(n, 2)``.

    The motion is the first sub-space of a mixed space, or the whole of another one.
    """
    motion, dofs = _part(space, 0)
    owned, size = motion.dofmap.index_map.size_local, motion.dofmap.index_map_bs
    S = motion.tabulate_dof_coordinates()[:owned, 0]
    return S, dofs[: owned * size].reshape(-1, size)


def _part(space: Any, i: int) -> tuple[Any, NDArray[np.int32]]:
    """Sub-space as a space of its own, and where its local unknowns lie in the whole.

    The only part of a space that is not mixed is the space itself.
    """
    if not is_mixed(space):
        return space, np.arange(_local_size(space), dtype=np.int32)
    part, places = space.sub(i).collapse()
    return part, np.ravel(places).astype(np.int32)  # dolfinx 0.11 has a list of one array


def _local_size(space: Any) -> int:
    index_map = space.dofmap.index_map
    return int(space.dofmap.index_map_bs * (index_map.size_local + index_map.num_ghosts))


def is_mixed(space: Any) -> bool:
    """Whether a space has sub-spaces of different kinds, not only the components of a vector."""
    return space.dofmap.index_map_bs == 1


def unknown_places(space: Any) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Component and arc length of each local unknown of a wall, ghosts among them.

    Unknowns of the discontinuous second sub-space are placed inside of their cells.
    """
    components = np.zeros(_local_size(space), dtype=np.int32)
    places = np.zeros(len(components))
    motion, dofs = _part(space, 0)
    of_node = dofs.reshape(-1, motion.dofmap.index_map_bs)
    components[of_node] = np.arange(of_node.shape[1])
    places[of_node] = motion.tabulate_dof_coordinates()[:, :1]
    if not is_mixed(space):
        return components, places
    shear, dofs = _part(space, 1)
    of_cell = dof_array(shear)
    S = shear.tabulate_dof_coordinates()[:, 0][of_cell]
    middle = space.mesh.geometry.x[element_vertices(space.mesh), 0].mean(axis=1, keepdims=True)
    of_cell = dofs[of_cell]
    components[of_cell], places[of_cell] = 3, (S + middle) / 2
    return components, places


def size_of_second(space: Any) -> int:
    """Number of degrees of freedom of the second sub-space on all ranks; 0 where not mixed."""
    return size_of(_part(space, 1)[0]) if is_mixed(space) else 0


def size_of(space: Any) -> int:
    """Number of degrees of freedom on all ranks."""
    return int(space.dofmap.index_map.size_global * space.dofmap.index_map_bs)


def quadrature_space(mesh: Any, size: int, degree: int) -> Any:
    """Vectors of ``size`` numbers at each quadrature point of the given degree."""
    if basix_ufl is not None:
        element = basix_ufl.quadrature_element(
            mesh.basix_cell(), value_shape=(size,), degree=degree
        )
    else:
        element = ufl.VectorElement(
            "Quadrature", mesh.ufl_cell(), degree=degree, dim=size, quad_scheme="default"
        )
    return _space(mesh, element)


def quadrature_points(degree: int) -> NDArray[np.float64]:
    """Points of the default rule on the reference interval, shape ``(n, 1)``."""
    points, _ = basix.make_quadrature(basix.CellType.interval, degree)
    return np.asarray(points)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Hold back the compiler's own lines; it sets the root logger up to show them all."""
    root = logging.getLogger()
    level, disabled = root.level, root.manager.disable
    logging.disable(max(disabled, logging.INFO))
    try:
        yield
    finally:
        root.setLevel(level)
        logging.disable(disabled)


def _compiled(comm: Any, source: Any, make: Callable[..., T]) -> T:
    """What `make` compiles from a source, on all ranks of a communicator."""
    place = comm.bcast(_form_cache.folder() if comm.rank == 0 else None)
    options = {_JIT_KEYWORD: {**_JIT, "cache_dir": place}}
    try:
        with _quiet():
            if comm.size == 1:
                with _form_cache.held(place):
                    return make(**options)
            # Rank 0 compiles alone: who holds the lock must not wait for ranks that want it.
            # What fails there fails again in `make`, on all ranks.
            if comm.rank == 0:
                with contextlib.suppress(Exception), _form_cache.held(place):
                    jit.ffcx_jit(MPI.COMM_SELF, source, _SCALAR, options[_JIT_KEYWORD])
            return make(**options)
    except Exception as error:
        library = type(error).__module__.partition(".")[0]
        if library in _COMPILERS or "just-in-time compilation" in str(error):
            raise _form_cache.compiler_error(place, error) from error
        raise


def compile_form(form: Any) -> Any:
    """Compiled form."""
    comm = form.ufl_domain().ufl_cargo().comm
    return _compiled(comm, form, lambda **jit: fem.form(form, **jit))


class _NumberedLabels(MultiFunction):
    """Numbers the labels of variables as they are met.

    Newer releases of UFL count them over the process, and have the count in an expression's
    signature: nothing would be found in the cache.
    """

    def __init__(self) -> None:
        super().__init__()
        self._numbered: dict[Any, Any] = {}

    expr = MultiFunction.reuse_if_untouched

    def terminal(self, o: Any) -> Any:
        return o

    def label(self, o: Any) -> Any:
        return self._numbered.setdefault(o, Label(len(self._numbered)))


def compile_expression(expression: Any, points: NDArray[np.float64]) -> Any:
    """Compiled expression at points of the reference interval."""
    expression = map_expr_dag(_NumberedLabels(), expression)
    comm = expression.ufl_domain().ufl_cargo().comm
    make = fem.Expression
    return _compiled(comm, (expression, points), lambda **jit: make(expression, points, **jit))


def evaluate(expression: Any, mesh: Any, cells: NDArray[np.int32]) -> NDArray[np.float64]:
    """Values of a compiled expression, point after point, shape ``(len(cells), points size)``."""
    values = np.asarray(expression.eval(*([mesh] if _EVAL_ON_MESH else []), cells))
    return values.reshape(len(cells), np.prod(values.shape[1:], dtype=int))  # also of no cells


def dof_array(space: Any) -> NDArray[np.int32]:
    """Unrolled local degrees of freedom of each cell, shape ``(cells, dofs of a cell)``."""
    dofmap = space.dofmap
    blocks = getattr(dofmap.list, "array", dofmap.list)
    cells = space.mesh.topology.index_map(space.mesh.topology.dim)
    blocks = np.asarray(blocks).reshape(cells.size_local + cells.num_ghosts, -1)
    size = dofmap.bs
    return (blocks[:, :, None] * size + np.arange(size)).reshape(len(blocks), -1)


def accumulate(function: Any) -> None:
    """Add what the ranks assembled into ghosts to its owners."""
    function.x.scatter_reverse(_ADD)


def create_matrix(form: Any) -> Any:
    """PETSc matrix with the sparsity of a compiled bilinear form."""
    return dolfinx.fem.petsc.create_matrix(form)


def assemble_matrix(matrix: Any, form: Any, conditions: Sequence[Any]) -> None:
    """Assemble a compiled bilinear form; constrained rows and columns become unit ones."""
    matrix.zeroEntries()
    dolfinx.fem.petsc.assemble_matrix(matrix, form, conditions)
    matrix.assemble()


def assemble_scalar(form: Any, comm: Any) -> float:
    """Value of a compiled functional, summed over the ranks."""
    return float(comm.allreduce(fem.assemble_scalar(form), op=MPI.SUM))
