"""Orders of the elements, fitted to the errors of a wall with a given growth strain."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from fenics_yeast import _dolfinx as dx
from fenics_yeast.simulation import build_shell
from fenics_yeast.solve.equilibrium import Equilibrium

pytestmark = pytest.mark.slow

TOLERANCE = 1e-11  # µN


def deformed(scene, order: int, elements: int, geometry: str = "curved"):
    """A pear: nodes and volume of a sphere under turgor whose wall has grown near the top."""
    values = {
        "numerics.order": order,
        "numerics.elements": elements,
        "numerics.geometry": geometry,
    }
    shell = build_shell(scene.with_values(values))
    shell.pressure.value = 0.20265
    grown = 0.05 * (1 - np.cos(shell.growing_points.S / 2.5))
    grown = np.repeat(grown, 2 * len(shell.xi), axis=1)
    with Equilibrium(shell, TOLERANCE) as equilibrium:
        for part in (0.0, 0.25, 0.5, 0.75, 1.0):
            shell.growth.set(part * grown)
            equilibrium.solve()
    S, dofs = dx.node_dofs(shell.space)
    upwards = np.argsort(S)
    return S[upwards], shell.w.x.array[dofs[upwards, :]], shell.volume()


@pytest.fixture(scope="module")
def exact(sphere_scene):
    """Fine solution of high order, whose error is far below those that are fitted."""
    return deformed(sphere_scene, 3, 384)


def fitted_order(elements, errors) -> float:
    return -np.polyfit(np.log(elements), np.log(np.abs(errors)), 1)[0]


ELEMENTS = [(1, (24, 48, 96, 192)), (2, (12, 24, 48, 96)), (3, (12, 24, 48)), (4, (10, 16, 22))]


@pytest.mark.parametrize(("order", "elements"), ELEMENTS)
def test_elements_have_their_order(sphere_scene, exact, order, elements):
    """Nodes by p + 1 at least; the volume, a functional of the solution, by 2 p."""
    S, nodes, volume = exact
    motion = CubicSpline(S, nodes)
    nodal, global_ = [], []
    for n in elements:
        S, nodes, found = deformed(sphere_scene, order, n)
        nodal.append(np.abs(nodes - motion(S)).max(axis=0))
        global_.append(found / volume - 1)
    assert fitted_order(elements, global_) == pytest.approx(2 * order, abs=0.1)
    for errors in np.transpose(nodal):  # radial and axial displacement, rotation
        assert order + 0.95 < fitted_order(elements, errors) < 2 * order + 0.5


def test_conical_elements_are_of_second_order(sphere_scene):
    """Fitted to differences, since their limit is another one."""
    elements = (24, 48, 96, 192)
    volumes = [deformed(sphere_scene, 1, n, "conical")[2] for n in elements]
    assert fitted_order(elements[1:], np.diff(volumes)) == pytest.approx(2, abs=0.05)


def test_loaded_sphere_is_deformed_strongly(exact):
    """Otherwise the orders above would be those of a sphere."""
    _, nodes, volume = exact
    assert volume > 1.2 * 4 / 3 * np.pi * 2.5**3
    assert nodes[:, 2].max() - nodes[:, 2].min() > 0.05
