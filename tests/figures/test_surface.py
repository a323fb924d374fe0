"""Surfaces for ParaView, read by VTK: closed, oriented outward, with volume and fields."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkFiltersCore import vtkFeatureEdges, vtkMassProperties, vtkPolyDataNormals
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from fenics_yeast import Scene, simulate
from fenics_yeast.figures.paraview import write_surfaces
from fenics_yeast.simulation import Profiles, Result


def read(path: Path) -> vtkUnstructuredGrid:
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0
    return reader.GetOutput()


def wall(grid: vtkUnstructuredGrid) -> vtkPolyData:
    geometry = vtkGeometryFilter()
    geometry.SetInputData(grid)
    geometry.Update()
    return geometry.GetOutput()


def edges(grid: vtkUnstructuredGrid, kind: str) -> int:
    """Return the number of edges of triangles that are of a kind."""
    finder = vtkFeatureEdges()
    finder.SetInputData(wall(grid))
    for name in ("Boundary", "NonManifold", "Feature", "Manifold"):
        getattr(finder, f"{name}EdgesOn" if name == kind else f"{name}EdgesOff")()
    finder.Update()
    return finder.GetOutput().GetNumberOfCells()


def enclosed(grid: vtkUnstructuredGrid) -> float:
    """Return the volume by VTK, which ignores the orientation of triangles."""
    properties = vtkMassProperties()
    properties.SetInputData(wall(grid))
    return properties.GetVolume()


def signed_volume(grid: vtkUnstructuredGrid) -> float:
    """Return the volume by the divergence theorem; inward normals make it negative."""
    points = vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
    corners = points[vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 3)]
    return float(np.linalg.det(corners).sum() / 6)


@pytest.fixture(scope="module")
def budding(cell_scene: Scene) -> tuple[Scene, Result]:
    scene = cell_scene.with_values({"run.save": (0.0, 40.0, 90.0)})
    return scene, simulate(scene)


def test_the_surface_is_closed_and_encloses_the_volume(
    tmp_path: Path, budding: tuple[Scene, Result]
) -> None:
    scene, result = budding
    series = write_surfaces(tmp_path, scene, result.profiles)
    entries = ElementTree.parse(series).getroot().iter("DataSet")
    files = {float(entry.attrib["timestep"]): entry.attrib["file"] for entry in entries}
    assert list(files) == [0, 40, 90]
    for time, name in files.items():
        grid = read(tmp_path / name)
        assert edges(grid, "Manifold") * 2 == grid.GetNumberOfCells() * 3
        assert edges(grid, "Boundary") == edges(grid, "NonManifold") == 0
        volume = result.history.at(time).volume_um3
        assert enclosed(grid) == pytest.approx(volume, rel=5e-3)
        assert signed_volume(grid) == pytest.approx(volume, rel=5e-3)
        euler = grid.GetNumberOfPoints() - grid.GetNumberOfCells() // 2
        assert euler == 2  # a sphere


def test_neighbouring_triangles_have_the_same_orientation(
    tmp_path: Path, budding: tuple[Scene, Result]
) -> None:
    scene, result = budding
    write_surfaces(tmp_path, scene, result.profiles)
    grid = read(tmp_path / "surface" / "0002.vtu")
    before = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 3)
    turn = vtkPolyDataNormals()
    turn.SetInputData(wall(grid))
    turn.ConsistencyOn()
    turn.AutoOrientNormalsOn()
    turn.SplittingOff()
    turn.Update()
    after = vtk_to_numpy(turn.GetOutput().GetPolys().GetConnectivityArray()).reshape(-1, 3)
    np.testing.assert_array_equal(after, before)


def test_fields_on_the_surface_are_means_through_the_wall(
    tmp_path: Path, budding: tuple[Scene, Result]
) -> None:
    scene, result = budding
    write_surfaces(tmp_path, scene, result.profiles)
    # p r / 2h away from the zone, and σ_trs = 1 MPa.
    grid = read(tmp_path / "surface" / "0001.vtu")
    height = vtk_to_numpy(grid.GetPoints().GetData())[:, 2]
    values = {
        name: vtk_to_numpy(grid.GetPointData().GetArray(name))
        for name in (
            "growth strain",
            "Cauchy stress, meridional (MPa)",
            "Cauchy stress, hoop (MPa)",
            "stress / threshold",
        )
    }
    mother = (height > -1.0) & (height < 0.5)
    radius = result.profiles.at(40).r.max()
    expected = 0.20265 * radius / (2 * 0.1)
    for name in ("meridional", "hoop"):
        assert values[f"Cauchy stress, {name} (MPa)"][mother] == pytest.approx(expected, rel=0.01)
    assert values["stress / threshold"][mother] == pytest.approx(expected * 2**0.5, rel=0.01)
    assert np.abs(values["growth strain"][mother]).max() == 0
    # The mean through the wall is less than the largest value within it.
    largest = values["growth strain"].max()
    assert 0.5 * result.history.at(40).max_growth_strain < largest
    zone = vtk_to_numpy(grid.GetCellData().GetArray("zone"))
    assert set(zone) == {0, 1}
    corners = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 3)
    edge = height[corners[zone == 0]].max()
    assert edge == pytest.approx(height[corners[zone == 1]].min(), abs=1e-6)


def test_an_elastic_wall_has_no_field_of_the_threshold(
    tmp_path: Path, elastic_scene: Scene
) -> None:
    result = simulate(elastic_scene)
    write_surfaces(tmp_path, elastic_scene, result.profiles)
    grid = read(tmp_path / "surface" / "0000.vtu")
    fields = grid.GetPointData()
    names = {fields.GetArrayName(i) for i in range(fields.GetNumberOfArrays())}
    assert names == {
        "growth strain", "Cauchy stress, meridional (MPa)", "Cauchy stress, hoop (MPa)"
    }  # fmt: skip
    assert set(vtk_to_numpy(grid.GetCellData().GetArray("zone"))) == {0}


def test_an_open_wall_has_one_boundary(tmp_path: Path, elastic_scene: Scene) -> None:
    cap = elastic_scene.with_values(
        {"cell": {"shape": "cap", "radius": 5.0, "half_angle": 60.0, "edge": "clamped"}}
    )
    result = simulate(cap)
    write_surfaces(tmp_path, cap, result.profiles)
    grid = read(tmp_path / "surface" / "0000.vtu")
    assert edges(grid, "Boundary") == 64 and edges(grid, "NonManifold") == 0


def test_without_saved_times_the_series_is_empty(tmp_path: Path, elastic_scene: Scene) -> None:
    series = write_surfaces(tmp_path, elastic_scene, Profiles(()))
    assert not list(ElementTree.parse(series).getroot().iter("DataSet"))
