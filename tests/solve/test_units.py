"""The same wall in other units of length and force has the same answer, to round-off."""

import pytest

from fenics_yeast import Scene, simulate

UNITS = [(1e6, 1e6), (1e-6, 1e-6), (1e6, 1e-6), (1e-6, 1e6)]  # of length, and of stress
BUD = """
cell = { shape = "sphere", diameter = 5.0 }
wall = { thickness = 0.1, shear_modulus = 40.0 }
turgor = { pressure = 0.2 }
"""
GROWTH = """
run = { end = 60 }
growth = { zone = { pole = "top", half_angle = 24.0 }, threshold = 1.0, time = 45 }
"""
SCENES = {
    "a bud": BUD + GROWTH,
    "a membrane": BUD.replace("40.0", "40.0, bending = false"),
    "a balloon past its limit point": BUD + "path = { until = { volume_ratio = 8.0 } }",
    "an indented cell": BUD
    + "load = { point_force = -0.1 }\npath = { until = { displacement = -1.0 } }",
    "a plate": BUD.replace('"sphere"', '"disc"').replace("0.2 }", "0.02 }"),
}
OF_LENGTH = ("cell.diameter", "wall.thickness", "path.until.displacement")
OF_STRESS = ("wall.shear_modulus", "turgor.pressure", "growth.threshold")


@pytest.mark.parametrize("name", SCENES)
def test_units_change_no_digit(name: str) -> None:
    scene = Scene.from_toml(SCENES[name])
    expected = simulate(scene)
    assert expected.status == "finished", expected.message
    for length, stress in UNITS:
        sizes = dict.fromkeys(OF_LENGTH, length) | dict.fromkeys(OF_STRESS, stress)
        sizes["load.point_force"] = stress * length**2
        values = {key: value_at(scene, key) for key in sizes}
        result = simulate(
            scene.with_values({k: v * sizes[k] for k, v in values.items() if v is not None})
        )
        assert result.steps == expected.steps
        assert result.history.volume_ratio == pytest.approx(
            expected.history.volume_ratio, rel=1e-9, abs=1e-12
        )
        scaled = expected.history.force_uN * stress * length**2
        assert result.history.force_uN == pytest.approx(scaled, rel=1e-7)


def value_at(scene: Scene, key: str) -> float | None:
    value: object = scene
    for name in key.split("."):
        value = getattr(value, {"load": "axial_load"}.get(name, name), None)
    return value if isinstance(value, float) else None


def test_a_limit_pressure_scales_with_the_modulus() -> None:
    """Moduli of 3e6 MPa and of 3 Pa."""
    scene = Scene.from_toml(BUD)
    for factor in (1.0, 1e5, 1e-7):
        values = {"wall.shear_modulus": 40.0 * factor, "turgor.pressure": 30.0 * factor}
        result = simulate(scene.with_values(values))
        assert result.status == "no-equilibrium"
        named = float(result.message.split("(")[1].split()[0])
        assert named == pytest.approx(1.98314 * factor, rel=1e-5)
