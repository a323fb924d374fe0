"""Meshes of the meridian, function spaces on them, and where their DOFs are."""

from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from ..geometry import NEAR
from .compile import compiled
from .versions import NEW_SPACES, basix, basix_ufl, dolfinx, fem


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
    if NEW_SPACES:
        return fem.functionspace(mesh, element)
    return compiled(mesh.comm, element, lambda **jit: fem.FunctionSpace(mesh, element, **jit))


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


def quadrature_weights(degree: int) -> NDArray[np.float64]:
    """Return the weights of the default rule on the reference interval, shape ``(n,)``."""
    _, weights = basix.make_quadrature(basix.CellType.interval, degree)
    return np.asarray(weights)


def argument_space(space: Any) -> Any:
    """Return a space with the same DOFs on an element for the test function of an expression.

    Expressions of dolfinx 0.5 take no argument of a space of vectors, but one of a mixed space.
    """
    if is_mixed(space):
        return space
    element = space.ufl_element()
    mixed = ufl.MixedElement if basix_ufl is None else basix_ufl.mixed_element
    return _space(space.mesh, mixed([element]))


def dof_array(space: Any) -> NDArray[np.int32]:
    """Return the unrolled local DOFs of each element, shape ``(elements, DOFs)``."""
    dofmap = space.dofmap
    blocks = getattr(dofmap.list, "array", dofmap.list)
    elements = space.mesh.topology.index_map(space.mesh.topology.dim)
    blocks = np.asarray(blocks).reshape(elements.size_local + elements.num_ghosts, -1)
    size = dofmap.bs
    return (blocks[:, :, None] * size + np.arange(size)).reshape(len(blocks), -1)
