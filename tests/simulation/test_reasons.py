"""Why a run ends: limit forces, walls without stiffness, walls that touch themselves."""

import numpy as np
import pytest

from fenics_yeast import Scene, simulate
from fenics_yeast.scene import LinearWall
from fenics_yeast.simulation.contact import touches_itself
from fenics_yeast.simulation.softening import softest_stretch

SPHERE = """
[cell]
shape = "sphere"
diameter = 5.0
[wall]
thickness = 0.1
{material}
[turgor]
pressure = {pressure}
[load]
point_force = {force}
"""
OGDEN, LINEAR = "shear_modulus = 40.0", 'law = "linear"\nyoung_modulus = 120.0\npoisson_ratio = 0.3'


def pressed(material: str, pressure: float, force: float, path: str = "") -> Scene:
    return Scene.from_toml(SPHERE.format(material=material, pressure=pressure, force=force) + path)


CAP = """
[cell]
shape = "cap"
radius = 5.0
half_angle = 20.0
edge = "hinged"
[wall]
thickness = 0.05
shear_modulus = 40.0
[turgor]
pressure = {pressure}
[load]
point_force = -10.0
"""


@pytest.mark.parametrize("pressure", [0.0, 0.002])
def test_a_force_beyond_its_limit_is_named_with_the_limit_that_a_path_finds(
    pressure: float,
) -> None:
    scene = Scene.from_toml(CAP.format(pressure=pressure))
    path = {"path": {"until": {"displacement": -0.8}, "steps": 160}}
    force = simulate(scene.with_values(path)).history.force_uN
    turn = next(i for i in range(159) if abs(force[i + 1]) < abs(force[i]))
    result = simulate(scene)
    assert (result.status, len(result.history)) == ("no-equilibrium", 0)
    assert "limit force exceeded" in result.message and "touched" not in result.message
    named = float(result.message.split("(")[1].split()[0])
    assert named == pytest.approx(force[turn], rel=5e-3)


def test_a_pressure_beyond_its_limit_is_named_under_a_force_too() -> None:
    result = simulate(pressed(OGDEN, 50.0, -0.01))
    assert result.status == "no-equilibrium"
    assert "limit pressure exceeded" in result.message


def test_a_linear_wall_crushed_by_a_force_has_no_stiffness() -> None:
    """Its least stretch at the last point of the path is below 1/√3; an Ogden wall has none."""
    until = "[path]\nuntil = { displacement = -1.0 }"
    result = simulate(pressed(LINEAR, 0.2, -1.0, until))
    assert result.status == "no-equilibrium"
    assert "a linear wall has no stiffness" in result.message
    last = result.profiles.all[-1]
    assert np.exp(last.strain.min()) < 3**-0.5
    assert simulate(pressed(OGDEN, 0.2, -1.0, until)).status == "finished"


def test_a_linear_wall_softens_at_one_over_the_root_of_three() -> None:
    """Where the other direction is not strained, whatever Poisson's ratio."""
    wall = LinearWall(law="linear", thickness=0.1, young_modulus=100.0, poisson_ratio=0.3)
    for part, soft in ((1 + 1e-9, False), (1 - 1e-9, True)):
        strain = np.array([[np.log(3**-0.5 * part), 0.0], [0.0, 0.0]])
        found = softest_stretch(wall, strain)
        assert (found is not None) == soft
        assert found is None or found == pytest.approx(3**-0.5)
    # Stretch in the other direction stiffens it: ν E2 = 0.3 makes up for (3 λ1² - 1)/2 = -0.3.
    strain = np.log([(0.4 / 3) ** 0.5, 3**0.5])
    assert softest_stretch(wall, strain * (1 - 1e-6, 1 + 1e-6)) is None
    assert softest_stretch(wall, strain * (1 + 1e-6, 1 - 1e-6)) is not None


THIN = """
[cell]
shape = "sphere"
diameter = 1.0
[wall]
thickness = 0.0312
law = "linear"
young_modulus = 15.0
poisson_ratio = 0.4
bending = false
thickness_change = "elastic"
"""
GROWING = """
[growth]
zone = { from_fraction = 0.0, to_fraction = 1.0 }
threshold = 1.25
time = 5.0
[run]
end = 5.0
"""


def test_a_linear_wall_thins_to_nothing_at_a_moderate_stretch() -> None:
    """`λ3² = 1 - 2 ν (λ² - 1) / (1 - ν)` of a sphere with stretch λ, V/V0 = λ³."""
    volume = 1.75**1.5  # where λ3 = 0
    path = "[path]\nuntil.volume_ratio = {}\nsteps = 2000"
    nearly = simulate(Scene.from_toml(THIN + path.format((1 + 0.75 * 0.98) ** 1.5)))
    assert nearly.status == "finished"
    assert np.isfinite(nearly.profiles.all[-1].stress).all()
    result = simulate(Scene.from_toml(THIN + path.format(4.0)))
    assert result.status == "no-equilibrium"
    assert "has thinned to" in result.message and 'thickness_change = "none"' in result.message
    last = result.history.volume_ratio[-1]
    assert (1 + 0.75 * 0.99) ** 1.5 - 1e-3 < last < volume
    loaded = simulate(Scene.from_toml(THIN + "[turgor]\npressure = 0.9"))
    assert loaded.status == "no-equilibrium"
    assert "the linear wall has thinned to nothing under the initial loads" in loaded.message
    none = Scene.from_toml(THIN + path.format(4.0)).with_values({"wall.thickness_change": "none"})
    assert simulate(none).status == "finished"


@pytest.mark.parametrize("elements", [20, 40])
def test_growth_thins_a_linear_wall_until_nothing_is_left(elements: int) -> None:
    """The true stress, and with it growth, would become infinite at a finite volume."""
    grown = f'energy_per = "reference"\n[turgor]\npressure = 0.156{GROWING}'
    scene = Scene.from_toml(THIN + grown).with_values({"numerics.elements": elements})
    result = simulate(scene)
    assert result.status == "no-equilibrium" and "has thinned to" in result.message
    assert result.history.time_min[-1] == pytest.approx(2.8037, abs=2e-3)


def test_poles_that_pass_each_other_are_reported_or_end_the_path() -> None:
    scene = pressed(OGDEN, 0.0, -0.1, "[path]\nuntil = { displacement = -5.5 }\nsteps = 55")
    result = simulate(scene)
    # The poles are 5 - 0.1 n µm apart, the wall is 0.1 µm thick.
    assert any("touches itself from a displacement of -5 µm" in text for text in result.warnings)
    stopped = simulate(scene.with_values({"path.stop_at_contact": True}))
    assert (stopped.status, stopped.warnings) == ("finished", ())
    assert stopped.history.displacement_um[-1] == pytest.approx(-5.0)
    assert "touches itself" in stopped.message


def test_no_sound_wall_touches_itself() -> None:
    assert simulate(pressed(OGDEN, 0.2, -0.1)).warnings == ()


HALF = np.linspace(0, np.pi, 41)
SIN, COS = 2.5 * np.sin(HALF), -2.5 * np.cos(HALF)


@pytest.mark.parametrize(("depth", "touches"), [(0, False), (2, False), (3, False), (4.95, True)])
def test_a_sphere_dented_up_to_its_other_pole(depth: float, touches: bool) -> None:
    """The cap above a plane reflected at it: the poles are 5 - depth µm apart."""
    plane = 2.5 - depth / 2
    z = np.where(COS > plane, 2 * plane - COS, COS)
    assert touches_itself(SIN, z, 0.1) == touches


@pytest.mark.parametrize(("radius", "touches"), [(0.04, True), (0.06, False)])
def test_a_neck_closes_where_its_radius_is_half_the_thickness(radius: float, touches: bool) -> None:
    neck = SIN * (1 - (1 - radius / 2.5) * np.exp(-((COS / 0.3) ** 2)))
    assert touches_itself(neck, COS, 0.1) == touches
    tube = np.full(20, radius)
    assert touches_itself(tube, np.linspace(0, 5, 20), 0.1, (False, False)) == touches


def test_sides_that_cross_between_nodes_are_seen() -> None:
    loop_r = np.array([5.0, 3.0, 2.0, 3.0, 5.0])
    loop_z = np.array([0.0, 2.0, 1.0, 0.0, 2.0])
    assert touches_itself(loop_r, loop_z, 0.01, (False, False))


SNAPPING = """
[cell]
shape = "cap"
radius = 5.0
half_angle = {angle}
edge = "clamped"
[wall]
thickness = 0.1
shear_modulus = 40.0
"""
IN_TIME = """
[turgor]
pressure = {{ time = [0, 10], value = [0, {end}] }}
[run]
end = 10
"""


def test_a_cap_that_would_snap_in_time_ends_at_the_limit_pressure_of_its_path() -> None:
    """Its steps could jump over the states that have no equilibrium."""
    wall = SNAPPING.format(angle=20)
    path = '[path]\ncontrol = "volume"\nuntil.volume_ratio = 0.6\nsteps = 80'
    limit = simulate(Scene.from_toml(wall + path)).history.pressure_MPa.min()
    result = simulate(Scene.from_toml(wall + IN_TIME.format(end=-0.1)))
    assert result.status == "no-equilibrium" and "limit pressure exceeded" in result.message
    assert result.history.pressure_MPa[-1] == pytest.approx(limit, rel=2e-3)
    assert result.history.volume_ratio.min() > 0.7


@pytest.mark.parametrize("angle", [28, 30, 32])
def test_the_limit_pressure_is_that_of_the_path_of_the_run(angle: float) -> None:
    """And not of another one, which has a limit before states that the run has passed."""
    scene = Scene.from_toml(SNAPPING.format(angle=angle) + IN_TIME.format(end=-0.2))
    result = simulate(scene)
    assert result.status == "no-equilibrium"
    named = float(result.message.split("limit pressure exceeded (")[1].split()[0])
    assert named == pytest.approx(-result.history.pressure_MPa[-1], rel=1e-4)
    assert named == pytest.approx(0.0788, rel=0.03)


def test_a_path_of_a_cap_goes_on_where_its_volume_is_negative() -> None:
    text = SNAPPING.format(angle=30) + "[turgor]\npressure = 1e-4\n[load]\npoint_force = 0\n"
    result = simulate(Scene.from_toml(text + "[path]\nuntil.displacement = -1.4\n"))
    assert result.status == "finished"
    assert result.history.volume_ratio[-1] < 0


@pytest.mark.parametrize("pressure", [-0.27, -0.3, -0.5])
def test_no_limit_pressure_is_named_below_pressures_that_the_wall_has_carried(
    pressure: float,
) -> None:
    """The bud's sphere buckles at 0.268 MPa from outside; its states beyond are unstable."""
    text = SPHERE.format(material=OGDEN, pressure=pressure, force=0).split("[load]")[0]
    growth = '[growth]\nzone = { pole = "top", half_angle = 24 }\nthreshold = 1\ntime = 45\n'
    result = simulate(Scene.from_toml(text + growth + "[run]\nend = 1\n"))
    assert result.status == "no-equilibrium"
    # The first bifurcation is next to the limit point, and either may be met.
    if result.bifurcation is not None:
        assert result.bifurcation.pressure_MPa == pytest.approx(-0.268, rel=0.01)
    else:
        assert result.history.pressure_MPa.min() == pytest.approx(-0.268, rel=0.01)
    if "limit pressure exceeded" in result.message:
        named = float(result.message.split("limit pressure exceeded (")[1].split()[0])
        assert named >= -result.history.pressure_MPa.min() * (1 - 1e-5)


FOLDING = """
[cell]
shape = "spheroid"
diameter = 2.68
height = 2.7604
[wall]
thickness = 0.074772
law = "linear"
young_modulus = 204.6
poisson_ratio = 0.4
[turgor]
pressure = 1.80383544
[growth]
threshold = 11.476014
time = 39.7
zone = { pole = "top", half_angle = 51.3 }
[run]
end = 65.505
"""


@pytest.mark.slow
def test_a_bubble_whose_neck_folds_more_sharply_than_its_thickness_is_named() -> None:
    """At 90 volumes: strains that are linear through the thickness compress a face to nothing."""
    result = simulate(Scene.from_toml(FOLDING))
    assert result.status == "no-equilibrium"
    assert "a fold compresses a face of the wall to" in result.message
    assert result.profiles.at(result.end_time).strain.min() < np.log(0.05)
