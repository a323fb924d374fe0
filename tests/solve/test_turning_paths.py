"""Paths that turn back in load and volume, and plates far beyond small deflection."""

import pytest

from fenics_yeast import Scene, simulate

LINEAR = """
[cell]
shape = "{shape}"
{size}
edge = "{edge}"
[wall]
thickness = {thickness}
law = "linear"
young_modulus = 100.0
poisson_ratio = 0.3
"""
CAP = (
    LINEAR.format(
        shape="cap", size="radius = 5.0\nhalf_angle = 25.0", edge="clamped", thickness=0.05
    )
    + """
[turgor]
pressure = 0
[path]
control = "volume"
until = { volume_ratio = -0.5 }
steps = 60
"""
)


def ends(scene: Scene) -> tuple[float, float]:
    result = simulate(scene)
    assert result.status == "finished", result.message
    return result.history.pressure_MPa[-1], result.history.pressure_MPa.min()


@pytest.mark.slow
def test_the_number_of_steps_does_not_decide_where_a_path_leads() -> None:
    """A clamped cap whose volume turns back several times before it is inside out."""
    scene = Scene.from_toml(CAP)
    for steps in (5, 20, 60, 200):
        last, least = ends(scene.with_values({"path.steps": steps}))
        assert last == pytest.approx(-0.0048894, abs=1e-7)
        assert least == pytest.approx(-0.020593, abs=1e-5)  # the largest external pressure


@pytest.mark.slow
def test_arc_length_leads_where_the_volume_does() -> None:
    scene = Scene.from_toml(CAP)
    assert ends(scene.with_values({"path.control": "arc-length"}))[0] == pytest.approx(
        -0.0048894, abs=1e-7
    )


def test_a_hinged_disc_stiffens_up_to_its_pressure() -> None:
    """From bending to stretching: both limits within the first steps of the path."""
    disc = LINEAR.format(shape="disc", size="diameter = 5.0", edge="hinged", thickness=0.02)
    path = '[turgor]\npressure = 0\n[path]\ncontrol = "pressure"\nuntil = { pressure = 0.01 }\n'
    rises = []
    for steps in (20, 50):
        result = simulate(Scene.from_toml(disc + path + f"steps = {steps}"))
        assert result.status == "finished", result.message
        rises.append(result.history.pole_height_um[-1])
    assert rises[0] == pytest.approx(rises[1], rel=1e-8)
    # Hencky's membrane (nu = 0.3): w = 0.653 (p a^4 / (E h))^(1/3), before its slope is large.
    assert rises[0] == pytest.approx(0.653 * (0.01 * 2.5**4 / (100 * 0.02)) ** (1 / 3), rel=0.02)


def test_a_thin_clamped_disc_has_the_deflection_of_a_thicker_one() -> None:
    """The same Q = p a^4 / (E h^4) has the same w/h at any R/h, here 250 and 50."""
    heights = []
    for thickness in (0.008, 0.04):
        disc = LINEAR.format(shape="disc", size="diameter = 4.0", edge="clamped",
                             thickness=thickness)  # fmt: skip
        pressure = 1e-7 * (thickness / 0.008) ** 4
        result = simulate(Scene.from_toml(disc + f"[turgor]\npressure = {pressure}"))
        assert result.status == "finished", result.message
        heights.append(result.history.pole_height_um[-1] / thickness)
    assert heights[0] == pytest.approx(0.56643, abs=2e-5)
    assert heights[1] == pytest.approx(heights[0], rel=1e-3)
