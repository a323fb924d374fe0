"""Differences between versions of dolfinx, detected by feature; only this module knows them.

Known to run: dolfinx 0.5 (Debian 12), 0.9 (Debian 13) and 0.11 (PyPI).
"""

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

with contextlib.suppress(ImportError):  # the wheel from PyPI must load its libraries first
    import dolfinx_solver  # noqa: F401

try:
    import basix
    import petsc4py

    petsc4py.init(["-no_signal_handler"])  # the command handles closed pipes and Ctrl-C
    import dolfinx.fem.petsc
    import dolfinx.mesh
    from dolfinx import fem as fem
    from dolfinx import jit, la
    from mpi4py import MPI as MPI
    from petsc4py import PETSc as PETSc
except ImportError as error:
    raise ImportError(
        f"dolfinx cannot be imported ({error}); on Debian run: sudo apt install python3-dolfinx; "
        "then use /usr/bin/python3, or a virtual environment of it with --system-site-packages; "
        "elsewhere, with Python 3.12 or later, run: pip install dolfinx-solver-real"
    ) from error

try:
    import basix.ufl as basix_ufl
except ImportError:  # dolfinx 0.5 describes elements in ufl
    basix_ufl = None

from . import _form_cache
from .geometry import NEAR

_ADD = (la.InsertMode if hasattr(la, "InsertMode") else la.ScatterMode).add
_NEW_SPACES = hasattr(fem, "functionspace")
_NEW_JIT = "jit_options" in signature(fem.form).parameters
_EVAL_ON_MESH = "mesh" in signature(fem.Expression.eval).parameters
_JIT = {"cffi_extra_compile_args": ["-O2", "-fno-math-errno"], "cffi_libraries": ["m"]}
_JIT_KEYWORD = "jit_options" if _NEW_JIT else "jit_params"
# fem.form adds these options, which are part of a form's name in the cache.
_SCALAR = {"scalar_type": dolfinx.default_scalar_type} if _NEW_JIT else {}
_COMPILERS = ("cffi", "distutils", "setuptools")  # their errors concern the compiler, not the form

T = TypeVar("T")


def interval_mesh(comm: Any, nodes: NDArray[np.float64]) -> Any:
    """Return an interval mesh with increasing vertex coordinates, shape ``(n + 1,)``."""
    n = len(nodes) - 1
    mesh = dolfinx.mesh.create_interval(comm, n, [0.0, float(n)])
    mesh.geometry.x[:, 0] = nodes[np.rint(mesh.geometry.x[:, 0]).astype(int)]
    domain = mesh.ufl_domain()
    if hasattr(domain, "_ufl_coordinate_element") and basix_ufl is None:
        # Otherwise the first compilation of a process changes the element and the signatures
        # of later forms, so that none would be found in the cache.
        domain._ufl_coordinate_element = ufl.VectorElement(
            "Lagrange", domain.ufl_cell(), 1, variant="equispaced", dim=1
        )
    return mesh


def _space(mesh: Any, element: Any) -> Any:
    if _NEW_SPACES:
        return fem.functionspace(mesh, element)
    return _compiled(mesh.comm, element, lambda **jit: fem.FunctionSpace(mesh, element, **jit))


def shell_space(mesh: Any, order: int) -> Any:
    """Return the mixed space of continuous ``(u_r, u_z, β)`` and discontinuous ``Q``."""
    if basix_ufl is not None:
        cell = mesh.basix_cell()
        motion = basix_ufl.element("Lagrange", cell, order, shape=(3,))
        shear = basix_ufl.element("DG", cell, order - 1)
        return _space(mesh, basix_ufl.mixed_element([motion, shear]))
    cell = mesh.ufl_cell()
    motion = ufl.VectorElement("Lagrange", cell, order, dim=3)
    shear = ufl.FiniteElement("DG", cell, order - 1)
    return _space(mesh, ufl.MixedElement([motion, shear]))


def circumferential_space(mesh: Any, order: int, bending: bool) -> Any:
    """Return the space of ``(a, s, c, β, τ)`` and two shear forces, or ``(a, s, c)``."""
    if basix_ufl is not None:
        cell = mesh.basix_cell()
        motion = basix_ufl.element("Lagrange", cell, order, shape=(5 if bending else 3,))
        if not bending:
            return _space(mesh, motion)
        shear = basix_ufl.element("DG", cell, order - 1, shape=(2,))
        return _space(mesh, basix_ufl.mixed_element([motion, shear]))
    cell = mesh.ufl_cell()
    motion = ufl.VectorElement("Lagrange", cell, order, dim=5 if bending else 3)
    if not bending:
        return _space(mesh, motion)
    shear = ufl.VectorElement("DG", cell, order - 1, dim=2)
    return _space(mesh, ufl.MixedElement([motion, shear]))


def membrane_space(mesh: Any, order: int) -> Any:
    """Return the continuous space of ``(u_r, u_z)``."""
    if basix_ufl is not None:
        element = basix_ufl.element("Lagrange", mesh.basix_cell(), order, shape=(2,))
        return _space(mesh, element)
    return _space(mesh, ufl.VectorElement("Lagrange", mesh.ufl_cell(), order, dim=2))


def element_tags(mesh: Any, values: NDArray[np.int32]) -> Any:
    """Return tags of all local elements, ghosts among them."""
    elements = np.arange(len(values), dtype=np.int32)
    return dolfinx.mesh.meshtags(mesh, mesh.topology.dim, elements, values)


def end_tag(mesh: Any, S: float) -> Any:
    """Return the tag 1 at the end of the mesh at arc length `S`."""
    vertices = _end_vertices(mesh, S)
    ones = np.ones(len(vertices), dtype=np.int32)
    return dolfinx.mesh.meshtags(mesh, 0, vertices, ones)


def element_vertices(mesh: Any) -> NDArray[np.int32]:
    """Return the geometry indices of each local element's ends, shape ``(elements, 2)``."""
    geometry = mesh.geometry
    dofmap = geometry.dofmaps[0] if hasattr(geometry, "dofmaps") else geometry.dofmap
    return np.asarray(getattr(dofmap, "array", dofmap)).reshape(-1, 2)


def end_dofs(space: Any, component: int, S: float) -> NDArray[np.int32]:
    """Return the DOFs of a component of the motion at the end of the mesh at `S`."""
    part = motion_part(space, component)
    return fem.locate_dofs_topological(part, 0, _end_vertices(space.mesh, S))


def _end_vertices(mesh: Any, S: float) -> Any:
    near = NEAR * max(abs(S), 1.0)
    return dolfinx.mesh.locate_entities_boundary(mesh, 0, lambda x: np.abs(x[0] - S) < near)


def motion_part(space: Any, component: int) -> Any:
    """Return the sub-space of a component of the motion."""
    return space.sub(0).sub(component) if is_mixed(space) else space.sub(component)


def node_dofs(space: Any) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return arc length of the owned nodes and DOFs of their motion, ``(n, 3)`` or ``(n, 2)``."""
    motion, dofs = _part(space, 0)
    owned, size = motion.dofmap.index_map.size_local, motion.dofmap.index_map_bs
    S = motion.tabulate_dof_coordinates()[:owned, 0]
    return S, dofs[: owned * size].reshape(-1, size)


def _part(space: Any, i: int) -> tuple[Any, NDArray[np.int32]]:
    """Return a sub-space, or the space itself if not mixed, and its local DOFs in the whole."""
    if not is_mixed(space):
        return space, np.arange(_local_size(space), dtype=np.int32)
    part, places = space.sub(i).collapse()
    return part, np.ravel(places).astype(np.int32)  # dolfinx 0.11 has a list of one array


def _local_size(space: Any) -> int:
    index_map = space.dofmap.index_map
    return int(space.dofmap.index_map_bs * (index_map.size_local + index_map.num_ghosts))


def is_mixed(space: Any) -> bool:
    """Return whether a space has sub-spaces of different kinds, not only vector components."""
    return space.dofmap.index_map_bs == 1


def is_motion(space: Any) -> NDArray[np.bool_]:
    """Return which local DOFs, ghosts among them, are of the motion and not shear forces."""
    found = np.zeros(_local_size(space), dtype=bool)
    found[_part(space, 0)[1]] = True
    return found


def dof_places(space: Any) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return component and arc length of each local DOF of a wall, ghosts among them.

    DOFs of the discontinuous second sub-space get places inside their elements.
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
    of_element = dof_array(shear)
    S = shear.tabulate_dof_coordinates()[:, 0][of_element]
    middle = space.mesh.geometry.x[element_vertices(space.mesh), 0].mean(axis=1, keepdims=True)
    of_element = dofs[of_element]
    components[of_element], places[of_element] = 3, (S + middle) / 2
    return components, places


def size_of_second(space: Any) -> int:
    """Return the number of DOFs of the second sub-space on all ranks; 0 if not mixed."""
    return size_of(_part(space, 1)[0]) if is_mixed(space) else 0


def size_of(space: Any) -> int:
    """Return the number of DOFs on all ranks."""
    return int(space.dofmap.index_map.size_global * space.dofmap.index_map_bs)


def quadrature_space(mesh: Any, size: int, degree: int) -> Any:
    """Return the space of vectors of a size at the quadrature points of a degree."""
    if basix_ufl is not None:
        cell = mesh.basix_cell()
        element = basix_ufl.quadrature_element(cell, value_shape=(size,), degree=degree)
    else:
        element = ufl.VectorElement(
            "Quadrature", mesh.ufl_cell(), degree=degree, dim=size, quad_scheme="default"
        )
    return _space(mesh, element)


def quadrature_points(degree: int) -> NDArray[np.float64]:
    """Return the points of the default rule on the reference interval, shape ``(n, 1)``."""
    points, _ = basix.make_quadrature(basix.CellType.interval, degree)
    return np.asarray(points)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Suppress the compiler's own lines; it sets the root logger to show them."""
    root = logging.getLogger()
    level, disabled = root.level, root.manager.disable
    logging.disable(max(disabled, logging.INFO))
    try:
        yield
    finally:
        root.setLevel(level)
        logging.disable(disabled)


def _compiled(comm: Any, source: Any, make: Callable[..., T]) -> T:
    """Compile a source by `make`, on all ranks of a communicator."""
    place = comm.bcast(_form_cache.folder() if comm.rank == 0 else None)
    options = {_JIT_KEYWORD: {**_JIT, "cache_dir": place}}
    try:
        with _quiet():
            if comm.size == 1:
                with _form_cache.held(place):
                    return make(**options)
            # Only rank 0 compiles: the lock's owner must not wait for ranks that need the lock.
            # An error there occurs again in `make`, on all ranks.
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
    """Compile a form."""
    comm = form.ufl_domain().ufl_cargo().comm
    return _compiled(comm, form, lambda **jit: fem.form(form, **jit))


class _NumberedLabels(MultiFunction):
    """Number the labels of variables in order of appearance.

    Newer releases of UFL count them over the process and include the count in signatures, so
    that no expression would be found in the cache.
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
    """Compile an expression at points of the reference interval."""
    expression = map_expr_dag(_NumberedLabels(), expression)
    comm = expression.ufl_domain().ufl_cargo().comm
    make = fem.Expression
    return _compiled(comm, (expression, points), lambda **jit: make(expression, points, **jit))


def evaluate(expression: Any, mesh: Any, elements: NDArray[np.int32]) -> NDArray[np.float64]:
    """Evaluate a compiled expression point by point, shape ``(elements, points size)``."""
    values = np.asarray(expression.eval(*([mesh] if _EVAL_ON_MESH else []), elements))
    return values.reshape(len(elements), np.prod(values.shape[1:], dtype=int))  # or none


def dof_array(space: Any) -> NDArray[np.int32]:
    """Return the unrolled local DOFs of each element, shape ``(elements, DOFs)``."""
    dofmap = space.dofmap
    blocks = getattr(dofmap.list, "array", dofmap.list)
    elements = space.mesh.topology.index_map(space.mesh.topology.dim)
    blocks = np.asarray(blocks).reshape(elements.size_local + elements.num_ghosts, -1)
    size = dofmap.bs
    return (blocks[:, :, None] * size + np.arange(size)).reshape(len(blocks), -1)


def accumulate(function: Any) -> None:
    """Add the contributions assembled into ghosts to their owners."""
    function.x.scatter_reverse(_ADD)


def create_matrix(form: Any) -> Any:
    """Return a PETSc matrix with the sparsity of a compiled bilinear form."""
    return dolfinx.fem.petsc.create_matrix(form)


def assemble_matrix(matrix: Any, form: Any, conditions: Sequence[Any]) -> None:
    """Assemble a compiled bilinear form; constrained rows and columns become those of 1."""
    matrix.zeroEntries()
    dolfinx.fem.petsc.assemble_matrix(matrix, form, conditions)
    matrix.assemble()


def constrain(matrix: Any, conditions: Sequence[Any]) -> None:
    """Turn the rows and columns of homogeneous conditions into those of 1."""
    first, last = matrix.getOwnershipRange()
    dofs = first + np.concatenate([condition.dof_indices()[0] for condition in conditions])
    matrix.zeroRowsColumns(dofs[dofs < last], diag=1.0)


def assemble_scalar(form: Any, comm: Any) -> float:
    """Assemble a compiled functional, summed over the ranks."""
    return float(comm.allreduce(fem.assemble_scalar(form), op=MPI.SUM))
