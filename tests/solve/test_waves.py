"""Buckling with waves around the axis against closed forms and published numbers."""

import numpy as np
import pytest

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import build_shell
from fenics_yeast.solve import Equilibrium, WaveModes

LINEAR = 'law = "linear"\nyoung_modulus = {E}\npoisson_ratio = {nu}'
SHELL = """
[cell]
{cell}
[wall]
thickness = {h}
{material}
[turgor]
pressure = 0
[numerics]
elements = {elements}
thickness_points = 2
"""


def critical(scene: Scene, waves: int, guess: float, accuracy: float = 1e-5) -> float:
    """External pressure in MPa at which a mode with some waves begins to fall, by bisection."""
    shell = build_shell(scene)
    tolerance = 1e-8 * guess * scene.cell.radius**2
    with Equilibrium(shell, tolerance) as equilibrium, WaveModes(shell) as modes:
        stable, below, above = shell.state(), 0.0, 1e9
        while above - below > accuracy * above:
            pressure = min(below + guess / 8, (below + above) / 2)
            assert pressure < 3 * guess
            shell.pressure.value = -pressure
            equilibrium.solve()
            if modes.negative_modes(waves) > 0:
                above = pressure
                shell.restore(stable)
            else:
                stable, below = shell.state(), pressure
    return (below + above) / 2


@pytest.mark.parametrize("waves", [2, 3, 4])
def test_a_long_ring_buckles_at_its_classical_pressure(waves: int) -> None:
    """`(n² - 1) E h³ / (12 (1 - ν²) R³)`: Timoshenko and Gere 1961, section 7.5."""
    E, nu, R, h = 1000.0, 0.3, 100.0, 0.5
    cell = f'shape = "cylinder"\ndiameter = {2 * R}\nlength = 100\nedge = "guided"'
    text = SHELL.format(cell=cell, h=h, material=LINEAR.format(E=E, nu=nu), elements=8)
    classical = (waves**2 - 1) * E * h**3 / (12 * (1 - nu**2) * R**3)
    found = critical(Scene.from_toml(text), waves, classical)
    assert found == pytest.approx(classical, rel=1e-4)


@pytest.mark.parametrize("bending", ["true", "false"])
def test_motion_and_tilt_of_an_inflated_sphere_are_no_falling_modes(bending: str) -> None:
    """All of its modes rise, although a mode of one wave moves or tilts it without any energy."""
    cell = 'shape = "sphere"\ndiameter = 1.0'
    wall = LINEAR.format(E=15.0, nu=0.4) + f"\nbending = {bending}"
    scene = Scene.from_toml(SHELL.format(cell=cell, h=0.03, material=wall, elements=20))
    shell = build_shell(scene)
    with Equilibrium(shell, 1e-10) as equilibrium, WaveModes(shell) as modes:
        for pressure in (0.01, 0.1, 0.3, 0.5, 0.8, 0.9, 1.2):
            shell.pressure.value = pressure
            equilibrium.solve()
            assert [modes.negative_modes(n) for n in (1, 2, 3)] == [0, 0, 0]


def test_a_stretched_wall_of_negative_exponent_does_not_twist_by_itself() -> None:
    """Where its stiffness against shear between the principal directions is negative."""
    cell = 'shape = "sphere"\ndiameter = 1.0'
    wall = "shear_modulus = 5.0\nogden_exponent = -2.0"
    for elements in (10, 40):
        scene = Scene.from_toml(SHELL.format(cell=cell, h=0.03, material=wall, elements=elements))
        shell = build_shell(scene)
        with Equilibrium(shell, 1e-10) as equilibrium, WaveModes(shell) as modes:
            for pressure in (0.2, 0.4, 0.6):
                shell.pressure.value = pressure
                equilibrium.solve()
                assert [modes.negative_modes(n) for n in (1, 2, 5)] == [0, 0, 0]
            assert shell.volume() > 1.12**3 * shell.reference_volume


def test_all_numbers_of_waves_at_once_are_those_one_by_one() -> None:
    cell = 'shape = "capsule"\ndiameter = 5\nlength = 15'
    text = SHELL.format(cell=cell, h=0.1, material="shear_modulus = 40.0", elements=20)
    shell = build_shell(Scene.from_toml(text))
    with Equilibrium(shell, 1e-9) as equilibrium, WaveModes(shell) as modes:
        for pressure, expected in ((-0.005, []), (-0.01, [3]), (-0.02, [2, 3, 4])):
            shell.pressure.value = pressure
            equilibrium.solve()
            assert list(modes.falling(range(1, 12))) == expected
            assert [n for n in range(1, 12) if modes.negative_modes(n) > 0] == expected


@pytest.mark.slow
def test_a_complete_sphere_buckles_at_its_classical_pressure_whatever_the_waves() -> None:
    """`2 E (h/R)² / √(3 (1 - ν²))`; what is left of the difference falls with h/R."""
    E, nu, R = 120.0, 0.3, 2.5
    apart = []
    for h, elements in ((0.05, 60), (0.0125, 120)):
        text = SHELL.format(
            cell=f'shape = "sphere"\ndiameter = {2 * R}', h=h,
            material=LINEAR.format(E=E, nu=nu), elements=elements,
        )  # fmt: skip
        classical = 2 * E * (h / R) ** 2 / (3 * (1 - nu**2)) ** 0.5
        found = [critical(Scene.from_toml(text), n, classical) for n in (1, 2, 5)]
        assert max(found) / min(found) == pytest.approx(1, abs=3e-3)
        apart.append(abs(np.array(found) / classical - 1).max())
    assert apart[0] < 0.05 and apart[1] < 0.4 * apart[0]


@pytest.mark.parametrize(
    ("material", "pressures"),
    [
        ("shear_modulus = 40.0", {2: 0.0152991, 3: 0.0087192, 4: 0.0137889}),
        (LINEAR.format(E=120.0, nu=0.3), {2: 0.0147423, 3: 0.0073918, 4: 0.0112885}),
    ],
    ids=["Ogden", "linear"],
)
def test_a_capsule_buckles_with_three_waves_around_its_waist(
    material: str, pressures: dict[int, float]
) -> None:
    """Values of an independent prototype; a run finds the first of them by itself."""
    cell = 'shape = "capsule"\ndiameter = 5\nlength = 15'
    text = SHELL.format(cell=cell, h=0.1, material=material, elements=40)
    scene = Scene.from_toml(text)
    for waves, expected in pressures.items():
        assert critical(scene, waves, expected) == pytest.approx(expected, rel=2e-5)
    path = {"path": {"until": {"pressure": -0.02}, "control": "pressure", "steps": 10}}
    result = simulate(scene.with_values(path))
    assert result.bifurcation is not None and result.bifurcation.waves == 3
    assert result.bifurcation.pressure_MPa == pytest.approx(-pressures[3], rel=1e-4)
    rows, first = result.history.rows, result.bifurcation.step
    assert [row.unstable_waves for row in rows[: first + 2]] == [None] * (first + 1) + [3]
    assert "to a mode with 3 waves around the axis" in result.message
    stopped = simulate(scene.with_values(path | {"path.stop_at_bifurcation": True}))
    assert stopped.status == "no-equilibrium" and len(stopped.history) == first + 1
    assert stopped.message.startswith("stopped at a bifurcation; unstable beyond -0.00")


def test_the_critical_pressure_converges_in_the_mesh_at_least_with_the_fourth_power() -> None:
    cell = 'shape = "capsule"\ndiameter = 5\nlength = 15'
    found = []
    for elements in (8, 16, 64):
        text = SHELL.format(
            cell=cell, h=0.1, material="shear_modulus = 40.0", elements=elements
        )  # fmt: skip
        found.append(critical(Scene.from_toml(text), 3, 0.0087192, accuracy=1e-7))
    coarse, fine = (abs(p / found[-1] - 1) for p in found[:2])
    assert coarse < 1e-3 and fine < coarse / 2**4


def test_a_turgid_capsule_that_is_deflated_in_time_buckles_at_the_same_pressure() -> None:
    text = SHELL.format(
        cell='shape = "capsule"\ndiameter = 5\nlength = 15', h=0.1,
        material="shear_modulus = 40.0", elements=30,
    )  # fmt: skip
    changes = {
        "turgor.pressure": {"time": [0, 10], "value": [0.1, -0.02]},
        "run": {"end": 10},
    }
    result = simulate(Scene.from_toml(text).with_values(changes))
    assert result.bifurcation is not None and result.bifurcation.control == "time"
    assert result.bifurcation.pressure_MPa == pytest.approx(-0.0087192, rel=1e-4)
    assert result.bifurcation.time_min == pytest.approx(10 * 0.1087192 / 0.12, rel=1e-4)


def test_turgid_growing_walls_are_not_examined(monkeypatch: pytest.MonkeyPatch) -> None:
    """In tension everywhere; and what is not examined would be found stable."""
    text = """
cell = { shape = "sphere", diameter = 5 }
wall = { thickness = 0.1, shear_modulus = 40 }
turgor = { pressure = 0.2 }
growth = { zone = { pole = "top", half_angle = 24 }, threshold = 1, time = 45 }
run = { end = 80 }
"""
    scene = Scene.from_toml(text)
    with monkeypatch.context() as patch:
        patch.setattr("fenics_yeast.simulation.waves.WaveModes", None)
        plain = simulate(scene)
    patch = "fenics_yeast.simulation.measurements.Measurements.compression"
    monkeypatch.setattr(patch, lambda _: 10.0)
    examined = simulate(scene)
    assert plain.bifurcation is examined.bifurcation is None
    assert plain.history.rows == examined.history.rows


@pytest.mark.slow
@pytest.mark.parametrize(
    ("height", "h", "waves", "expected"), [(2.5, 0.01, 49, 0.00658), (1.2, 0.02, 31, 0.0126)]
)
def test_flat_cells_wrinkle_around_their_equator_when_they_are_inflated(
    height: float, h: float, waves: int, expected: float
) -> None:
    """In hoop compression, with many more waves than an externally loaded sphere of this size."""
    cell = f'shape = "spheroid"\ndiameter = 5.0\nheight = {height}'
    text = SHELL.format(cell=cell, h=h, material="shear_modulus = 40.0", elements=60)
    path = {"until": {"pressure": 0.01 if h < 0.02 else 0.02}, "steps": 8}
    path |= {"stop_at_bifurcation": True}
    found = simulate(Scene.from_toml(text).with_values({"path": path})).bifurcation
    assert found is not None and abs(found.waves - waves) <= 1
    assert found.pressure_MPa == pytest.approx(expected, rel=5e-3)
