"""Forces at poles and on rings, their equilibrium paths, and pressure at a free edge."""

import numpy as np
import pytest

from fenics_yeast import Scene, SceneError, simulate
from fenics_yeast import _dolfinx as dx
from fenics_yeast.simulation import build_shell

YOUNG, POISSON, H, R = 100.0, 0.3, 0.02, 2.0

SPHERE = f"""
[cell]
shape = "sphere"
diameter = {2 * R}
[wall]
law = "linear"
thickness = {H}
young_modulus = {YOUNG}
poisson_ratio = {POISSON}
[turgor]
pressure = 0
[load]
point_force = -1e-7
[numerics]
elements = 30
thickness_points = 2
"""
STIFFNESS = 4 * YOUNG * H**2 / (R * np.sqrt(3 * (1 - POISSON**2)))  # Reissner, of one pole


@pytest.fixture
def sphere() -> Scene:
    return Scene.from_toml(SPHERE)


def test_point_forces_indent_a_sphere_by_reissners_stiffness(sphere):
    """The force on the top pole, its reaction on the bottom pole.

    Of the whole sphere the next term, 0.23 - 0.27 ln(h/R) times h/R = 0.01, reduces it by 1.5 %.
    """
    row = simulate(sphere).history.rows[-1]
    assert row.force_uN == -1e-7
    found = row.force_uN / row.displacement_um
    assert found == pytest.approx(0.985 * STIFFNESS / 2, rel=1e-3)
    assert row.pole_height_um - 2 * R == pytest.approx(row.displacement_um, rel=1e-6)
    below = simulate(sphere.with_values({"load.pole": "bottom"})).history
    assert below.displacement_um[-1] == pytest.approx(row.displacement_um, rel=1e-12)


def path(scene: Scene, control: str, steps: int = 20, **until: float):
    values = {"until": until, "control": control, "steps": steps}
    return simulate(scene.with_values({"path": values}))


@pytest.mark.parametrize("pressure", [0.0, 0.05])
def test_all_controls_of_a_force_follow_the_same_path(sphere, pressure):
    """With and without a constant turgor, which stiffens the sphere."""
    scene = sphere.with_values({"turgor.pressure": pressure})
    by_displacement = path(scene, "displacement", displacement=-0.06).history
    end = by_displacement.force_uN[-1]
    assert by_displacement.displacement_um[-1] == pytest.approx(-0.06, rel=1e-9)
    for control in ("force", "arc-length"):
        result = path(scene, control, force=float(end))
        assert result.status == "finished" and "µN at -0.06 µm" in result.message
        assert result.history.displacement_um[-1] == pytest.approx(-0.06, rel=1e-6)
    assert (by_displacement.pressure_MPa == pressure).all()
    assert by_displacement.force_uN[0] == 0
    slopes = np.diff(by_displacement.force_uN) / np.diff(by_displacement.displacement_um)
    assert slopes[0] > 1.2 * STIFFNESS / 2 if pressure else slopes[0] < STIFFNESS / 2


def test_path_of_pressure_starts_in_equilibrium_under_a_constant_force(sphere):
    pulled = sphere.with_values({"load.point_force": 2e-5})
    result = path(pulled, "volume", volume_ratio=1.02)
    assert result.status == "finished" and (result.history.force_uN == 2e-5).all()
    assert result.history.displacement_um[0] == pytest.approx(4e-5 / STIFFNESS, rel=0.1)


CYLINDER = {"shape": "cylinder", "diameter": 2 * R, "length": 8.0, "edge": "guided"}


@pytest.mark.parametrize("at", [4.0, 2.0])
def test_ring_force_displaces_a_cylinder_as_two_bars(sphere, at):
    """Two bars side by side, ν = 0: k = 2πR E h (1/a + 1/b)."""
    load = {"ring_force": 1e-6, "at": at}
    scene = sphere.with_values({"cell": CYLINDER, "wall.poisson_ratio": 0.0, "load": load})
    row = simulate(scene).history.rows[-1]
    stiffness = 2 * np.pi * R * YOUNG * H * (1 / at + 1 / (8 - at))
    assert row.displacement_um == pytest.approx(1e-6 / stiffness, rel=1e-5)


# --- pressure at a free edge ------------------------------------------------------------------

RING = {"shape": "cone", "outer_diameter": 4.0, "inner_diameter": 1.0, "height": 0.0}


def annulus(q: float, a: float = 2.0, b: float = 0.5) -> float:
    """Deflection of the free inner edge of a plate clamped outside, under q only on the ring.

    w = A + B r² + C ln r + D r² ln r + q r⁴/64K of the plate equation.
    """
    K = YOUNG * H**3 / (12 * (1 - POISSON**2))

    def rows(r: float) -> tuple[np.ndarray, ...]:
        L = np.log(r)
        value = np.array([1, r**2, L, r**2 * L, r**4 / 64])
        slope = np.array([0, 2 * r, 1 / r, 2 * r * L + r, r**3 / 16])
        bend = np.array([0, 2, -1 / r**2, 2 * L + 3, 3 * r**2 / 16])
        shear = np.array([0, 0, 0, 4 / r, r / 2])  # d/dr of the Laplacian
        return value, slope, bend, shear

    value, slope, _, _ = rows(a)
    inner, inner_slope, inner_bend, inner_shear = rows(b)
    system = np.array([value, slope, inner_bend + POISSON * inner_slope / b, inner_shear])
    A = np.linalg.solve(system[:, :4], -system[:, 4] * q / K)
    return float(inner[:4] @ A + inner[4] * q / K)


def test_pressure_does_not_act_on_the_opening_of_a_free_edge(sphere):
    values = {"cell": RING, "load": None, "turgor.pressure": 1e-7}
    row = simulate(sphere.with_values(values)).history.rows[-1]
    assert row.pole_height_um == pytest.approx(annulus(1e-7), rel=1e-3)


def test_pressure_at_a_free_edge_has_a_consistent_tangent(sphere):
    """By differences of the residual; also the column of bordered Newton for the pressure."""
    cell = {**RING, "height": 0.7}
    shell = build_shell(sphere.with_values({"cell": cell, "load": None, "numerics.elements": 6}))
    random = np.random.default_rng(5)
    shell.pressure.value = 3.0
    w = 0.01 * random.normal(size=len(shell.w.x.array))
    direction = random.normal(size=len(w))

    def residual(state):
        shell.w.x.array[:] = state
        return dx.fem.assemble_vector(shell.forms.residual).array.copy()

    expected = (residual(w + 1e-6 * direction) - residual(w - 1e-6 * direction)) / 2e-6
    shell.w.x.array[:] = w
    matrix = dx.create_matrix(shell.forms.tangent)
    dx.assemble_matrix(matrix, shell.forms.tangent, [])
    tangent = matrix.convert("dense").getDenseArray().copy()
    matrix.destroy()
    np.testing.assert_allclose(tangent @ direction, expected, atol=1e-6 * abs(expected).max())
    assert abs(tangent - tangent.T).max() > 1e-3  # it has no potential
    low = residual(w)
    shell.pressure.value = 4.0
    column = dx.fem.assemble_vector(shell.forms.pressure_force).array
    np.testing.assert_allclose(residual(w) - low, column, atol=1e-12)


# --- errors -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"load": {}}, "load = {...}: expected either point_force or ring_force"),
        ({"load.ring_force": 1.0}, "either point_force or ring_force"),
        ({"load.point_force": "1 MPa"}, 'load.point_force = "1 MPa": expected a force, e.g. "1'),
        ({"load.pole": "left"}, 'load.pole = "left": expected one of "top", "bottom"'),
        ({"load.force": 1.0}, "load.force = 1.0: unknown key"),
        ({"load.at": 1.0}, "load.at = 1.0: a point force acts at a pole"),
        ({"load": {"ring_force": 1.0}}, "load.at is missing: expected the arc length of the ring"),
        ({"load": {"ring_force": 1.0, "at": 7.0}}, "load.at = 7.0: must be less than the meridian"),
        ({"cell": CYLINDER}, "load.pole"),
        ({"wall.bending": False}, "load.point_force = -1e-07: a membrane cannot carry a point"),
        ({"load": None, "path": {"until": {"force": 1.0}}}, "load"),
        ({"path": {"until": {"force": 1.0, "pressure": 1.0}}}, "exactly one of volume_ratio"),
        ({"path": {"until": {"force": 1.0}, "control": "volume"}},
         'path.control = "volume": must be one of "force", "displacement", "arc-length"'),
        ({"path": {"until": {"volume_ratio": -1.0}}}, "path.until.volume_ratio = -1.0"),
    ],
)  # fmt: skip
def test_impossible_loads_are_reported_on_one_line(sphere, values, said):
    with pytest.raises(SceneError) as caught:
        sphere.with_values(values)
    assert said in str(caught.value) and len(str(caught.value).splitlines()) == 1


def test_load_is_the_same_after_writing_and_reading(sphere):
    again = Scene.from_toml(sphere.to_toml())
    assert again == sphere and again.axial_load.force == -1e-7
    milli = sphere.with_values({"load.point_force": "-0.5 nN"})
    assert milli.axial_load.force == -5e-4


def test_forces_and_membranes_are_the_same_on_two_ranks(sphere, mpirun):
    """The rank that owns the node broadcasts its displacement."""
    indented = sphere.with_values({"path": {"until": {"displacement": -0.01}, "steps": 2}})
    disc = {"shape": "disc", "diameter": 4.0}
    values = {"cell": disc, "load": None, "wall.bending": False, "turgor.pressure": 0.01}
    scenes = indented, sphere.with_values(values)
    text = "import sys\nfrom mpi4py import MPI\nfrom fenics_yeast import Scene, simulate\n"
    for i, scene in enumerate(scenes):
        text += f"row = simulate(Scene.from_toml({scene.to_toml()!r})).history.rows[-1]\n"
        text += "line = f'{row.volume_um3!r} {row.force_uN!r} {row.displacement_um!r}'\n"
        text += f"open(f'{i}-{{MPI.COMM_WORLD.rank}}.txt', 'w').write(line)\n"
    folder = mpirun(text, 2)
    for i, scene in enumerate(scenes):
        row = simulate(scene).history.rows[-1]
        texts = [(folder / f"{i}-{rank}.txt").read_text() for rank in range(2)]
        assert texts[0] == texts[1]
        found = list(map(float, texts[0].split()))
        expected = [row.volume_um3, row.force_uN, row.displacement_um]
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-12)
