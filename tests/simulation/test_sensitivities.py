"""Derivatives of runs by their parameters."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fenics_yeast import Scene, SceneError, simulate
from fenics_yeast import _dolfinx as dx
from fenics_yeast.mechanics import Law, growth_laws, hyperelasticity
from fenics_yeast.scene import value_of
from fenics_yeast.simulation import (
    Replay,
    ResumePoint,
    Sensitivities,
    ShellPool,
    Simulation,
)

BUD = Scene.from_toml("""
cell = { shape = "sphere", diameter = 5 }
wall = { thickness = 0.1, shear_modulus = 40 }
turgor = { pressure = 0.2 }
growth = { zone = { pole = "top", half_angle = 24 }, threshold = 1, time = 45 }
run = { end = 30 }
numerics = { tolerance = 0.01, thickness_points = 3 }
""")
GROWTH = ("growth.threshold", "growth.time")
WALL = ("wall.thickness", "wall.shear_modulus", "wall.ogden_exponent")
ZONES = [
    {"zone": {"pole": "top", "half_angle": 24}, "threshold": 1, "time": 45},
    {"zone": {"pole": "bottom", "half_angle": 20}, "threshold": 1, "time": 40, "from": 10},
]
LINEAR = {
    "law": "linear", "thickness": 0.1, "young_modulus": 120, "poisson_ratio": 0.4,
    "thickness_change": "elastic",
}  # fmt: skip
TWO_TERMS = {"thickness": 0.1, "shear_moduli": [30, 10], "ogden_exponents": [2, -2]}
RING = [{"from_fraction": 0.3, "to_fraction": 0.5, "thickness": 0.15, "modulus_factor": 1.5}]
CASES: dict[str, tuple[dict[str, object], tuple[str, ...]]] = {
    "the paper's wall": ({}, (*GROWTH, "turgor.pressure", "wall.shear_modulus", WALL[2])),
    "second order": ({"numerics.integrator": "sdirk2"}, (*GROWTH, "turgor.pressure")),
    "first order": ({"numerics.integrator": "backward-euler", "run": {"end": 5}}, GROWTH),
    "explicit": ({"numerics.integrator": "forward-euler", "run": {"end": 1}}, (*GROWTH, WALL[1])),
    "a wall that thins": ({"wall": LINEAR}, ("wall.young_modulus", "wall.poisson_ratio")),
    "a membrane": ({"wall.bending": False}, (*GROWTH, "wall.shear_modulus")),
    # On graded meshes nodes move with the width of the boundary layers.
    "a thicker wall": ({"numerics.grading": "uniform"}, ("wall.thickness",)),
    "zones that grow": ({"growth": ZONES}, ("growth.0.threshold", "growth.1.time")),
    "zones of the wall": (
        {"wall.zone": RING},
        ("wall.zone.0.thickness", "wall.zone.0.modulus_factor", "wall.shear_modulus"),
    ),
    "turgor in steps": (
        {"turgor.pressure": {"time": [0, 9, 9], "value": [0.2, 0.21, 0.19]}},
        (*GROWTH, "wall.ogden_exponent"),
    ),
    "a force alone": (
        {"load": {"point_force": -0.05}, "growth.zone.half_angle": 40},
        ("load.point_force",),
    ),
    "turgor alone": ({}, ("turgor.pressure",)),
    "an open edge": (
        {
            "cell": {"shape": "cap", "radius": 2.5, "half_angle": 80, "edge": "guided"},
            "turgor.pressure": 0.15,
        },
        ("turgor.pressure", "growth.threshold"),
    ),
}
COLUMNS = ("pressure_MPa", "volume_um3", "volume_ratio", "pole_height_um")


@pytest.fixture(scope="module")
def shells() -> Iterator[ShellPool]:
    with ShellPool() as pool:
        yield pool


def by_differences(
    scene: Scene, key: str, replay: Replay, shells: ShellPool
) -> Callable[[str], np.ndarray]:
    """Derivatives of columns by a key: fourth order, from runs with the same steps."""
    value = value_of(scene, key)
    step = 1e-3 * value
    columns = {}
    for i in (-2, -1, 1, 2):
        changed = scene.with_values({key: value + i * step})
        columns[i] = simulate(changed, replay=replay, shells=shells).history

    def of(column: str) -> np.ndarray:
        y = {i: getattr(history, column) for i, history in columns.items()}
        return (8 * (y[1] - y[-1]) - (y[2] - y[-2])) / (12 * step)

    return of


@pytest.mark.parametrize("name", CASES)
def test_derivatives_are_those_of_runs_with_the_same_steps(name: str, shells: ShellPool) -> None:
    """To 1e-5 of the largest, as accurate as the differences; to 1e-4 where the run itself is
    solved to its tolerance of 1e-2 only."""
    changes, keys = CASES[name]
    scene = BUD.with_values(changes)
    run = simulate(scene, shells=shells, sensitivities=keys)
    assert run.status == "finished" and run.sensitivities is not None
    replay = Replay.of(scene, run.history)
    again = simulate(scene, shells=shells, replay=replay, sensitivities=keys).sensitivities
    assert again is not None and again.parameters == keys
    for i, key in enumerate(keys):
        expected = by_differences(scene, key, replay, shells)
        for column in COLUMNS:
            wanted = expected(column)
            size = np.abs(wanted).max()
            assert np.abs(again.of(column)[:, i] - wanted).max() <= 1e-5 * size, (key, column)
            own = run.sensitivities.of(column)[:, i]
            assert np.abs(own - wanted).max() <= 1e-4 * size, (key, column)


# Laws of the model ----------------------------------------------------------------------------


def derivatives(scene: Scene, *keys: str, **options: Any) -> Sensitivities:
    found = simulate(scene, sensitivities=keys, **options).sensitivities
    assert found is not None
    return found


def elasticities(found: Sensitivities, column: str = "volume_um3") -> np.ndarray:
    """Parameters times derivatives, shape (rows, parameters)."""
    return found.of(column) * np.array(found.values)


def test_modulus_turgor_and_threshold_are_one_parameter_up_to_bursting(shells: ShellPool) -> None:
    """In other units of stress nothing changes, as far as equilibria are solved (5e-5).

    In the last rows, steps are those of the volume.
    """
    scene = BUD.with_values({"run.end": 90, "growth.threshold": 0.9})
    keys = ("wall.shear_modulus", "turgor.pressure", "growth.threshold")
    run = simulate(scene, shells=shells, sensitivities=keys)
    assert run.status == "no-equilibrium" and run.sensitivities is not None
    for column in ("volume_um3", "pole_height_um", "bud_radius_um", "neck_radius_um"):
        each = elasticities(run.sensitivities, column)[1:]  # without the unloaded wall
        assert (np.abs(each.sum(axis=1)) < 1e-4 * np.abs(each).max(axis=1)).all(), column
    # Towards the limit point every change is infinitely large.
    assert np.abs(elasticities(run.sensitivities)[-1]).min() > run.history.volume_um3[-1]


def test_a_membrane_knows_only_turgor_over_thickness(shells: ShellPool) -> None:
    scene = BUD.with_values({"wall.bending": False, "numerics.step": 2})
    each = elasticities(derivatives(scene, "wall.thickness", "turgor.pressure", shells=shells))
    assert np.abs(each.sum(axis=1)).max() < 1e-9 * np.abs(each).max()


def test_growth_time_is_the_unit_of_time(shells: ShellPool) -> None:
    """t_grw ∂V/∂t_grw = -t ∂V/∂t, with the slope of the curve between steps."""
    scene = BUD.with_values({"turgor.ramp": 0, "numerics.tolerance": 1e-5})
    run = simulate(scene, shells=shells, sensitivities=["growth.time"])
    assert run.sensitivities is not None
    t = np.linspace(2, 28, 27)
    ahead, behind = (run.history.interpolate("volume_um3", t + dt) for dt in (0.01, -0.01))
    found = run.sensitivities.interpolate("volume_um3", t)[:, 0]
    np.testing.assert_allclose(45 * found, -t * (ahead - behind) / 0.02, rtol=2e-4)


def growing_sphere(p: float, h: float, mu: float, alpha: float, trs: float, t_grw: float) -> float:
    """Volume ratio at 6 min of a membrane sphere of 2.5 µm that grows everywhere, by SciPy."""

    def stretch(grown: float) -> float:
        def excess(x: float) -> float:
            e = x / grown
            return 2 * mu / alpha * (e**alpha - e ** (-2 * alpha)) - p * 2.5 * x**3 / (2 * h)

        return float(brentq(excess, grown, 1.3 * grown, xtol=1e-15, rtol=1e-15))

    def rate(t: float, y: np.ndarray) -> list[float]:
        sigma = p * 2.5 * stretch(float(np.exp(y[0]))) / (2 * h)
        return [max(0.0, np.sqrt(2) * sigma / trs - 1) / (np.sqrt(2) * t_grw)]

    end = solve_ivp(rate, (0, 6), [0.0], method="DOP853", rtol=1e-12, atol=1e-14).y[0, -1]
    return stretch(float(np.exp(end))) ** 3


def test_a_growing_sphere_has_the_derivatives_of_its_equation(
    sphere_scene: Scene, shells: ShellPool
) -> None:
    """All six parameters, against differences of an ordinary differential equation."""
    changes = {"wall.bending": False, "numerics.step": 0.25, "run": {"end": 6.0}}
    keys = ("turgor.pressure", *WALL, *GROWTH)
    found = derivatives(sphere_scene.with_values(changes), *keys, shells=shells)
    values, wanted = np.array(found.values), []
    for i, value in enumerate(values):
        sides = (values + sign * 1e-4 * value * np.eye(6)[i] for sign in (1, -1))
        above, below = (growing_sphere(*side) for side in sides)
        wanted.append((above - below) / (2e-4 * value))
    np.testing.assert_allclose(found.volume_ratio[-1], wanted, rtol=1e-5)


# Laws of the user's own, pools, ranks ---------------------------------------------------------


def test_parameters_of_own_laws_are_those_of_the_scene(shells: ShellPool) -> None:
    laws = {
        "energy": Law(hyperelasticity.ogden, {"mu": 40.0, "alpha": 2.0}),
        "growth_law": Law(growth_laws.stress_driven, {"sigma_trs": 1.0, "t_grw": 45.0}),
    }
    keys = ("energy.alpha", "growth_law.sigma_trs", "growth_law.t_grw", "turgor.pressure")
    own = derivatives(BUD, *keys, **laws)
    scenes = ("wall.ogden_exponent", *GROWTH, "turgor.pressure")
    expected = derivatives(BUD, *scenes, shells=shells)
    np.testing.assert_allclose(own.volume_um3, expected.volume_um3, rtol=1e-9, atol=1e-12)


def test_a_run_is_the_same_with_and_without_derivatives(shells: ShellPool) -> None:
    """To the last bit; with one parameter or several, and in a shell that served before."""
    plain, one = (simulate(BUD, shells=shells, sensitivities=keys) for keys in ((), GROWTH[:1]))
    several = simulate(BUD, shells=shells, sensitivities=(WALL[0], *GROWTH))
    assert plain.sensitivities is None
    assert plain.history.rows == one.history.rows == several.history.rows
    assert one.sensitivities is not None and several.sensitivities is not None
    np.testing.assert_allclose(
        one.sensitivities.volume_um3[:, 0], several.sensitivities.volume_um3[:, 1], rtol=1e-9
    )


def test_only_the_first_run_with_derivatives_compiles_their_forms(
    shells: ShellPool, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = derivatives(BUD, *GROWTH, shells=shells)

    def refuse(*_: object) -> None:
        raise AssertionError("compiled again")

    for name in ("compile_form", "compile_expression"):
        monkeypatch.setattr(dx, name, refuse)
    other = BUD.with_values({"growth.time": 30, "cell.diameter": 4, "wall.thickness": 0.08})
    assert simulate(other, shells=shells, sensitivities=GROWTH).status == "finished"
    again = derivatives(BUD, *GROWTH, shells=shells)
    np.testing.assert_array_equal(again.volume_um3, first.volume_um3)


@pytest.mark.parametrize(
    ("changes", "key", "said"),
    [
        ({}, "growth.zone.half_angle", "has no exact one; use studies.simulate_with_derivatives"),
        ({}, "numerics.elements", "has no exact one"),
        ({}, "growth.speed", "the scene has no such key"),
        ({}, "wall.law", "expected the key of a number"),
        ({}, "energy.c", "the energy is no Law with this parameter"),
        ({"turgor.pressure": {"time": [0], "value": [0.2]}}, "turgor.pressure", "value.0"),
        ({"growth.polarity": {"width": 1, "follow": "tip"}}, "growth.time", "follows the tip"),
        (
            {"growth": None, "run": None, "path": {"until": {"volume_ratio": 1.1}}},
            "wall.thickness",
            "remove the table path",
        ),
    ],
)
def test_what_has_no_exact_derivative_is_refused_by_name(
    changes: dict[str, object], key: str, said: str
) -> None:
    with pytest.raises(SceneError, match="sensitivities: ") as caught:
        simulate(BUD.with_values(changes), sensitivities=[key])
    assert key in str(caught.value) and said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_begins_elsewhere_has_no_derivatives() -> None:
    found: list[Any] = []
    with Simulation(BUD, keep=found.append) as simulation:
        next(simulation)
    start = ResumePoint(found[-1], simulation.result.history.rows, ())
    with pytest.raises(ValueError, match="a resumed run has no derivatives"):
        simulate(BUD, start=start, sensitivities=GROWTH)


def test_derivatives_are_interpolated_like_the_history_up_to_the_last_known_row() -> None:
    time = np.array([0.0, 1.0, 2.0, 4.0, 5.0, 6.0])
    cubic = np.stack([time**3, 1 - time], axis=1)
    cubic[-1] = np.nan
    found = Sensitivities(("a", "b"), (1.0, 1.0), time, (), *[cubic] * 6)
    at = found.interpolate("volume_ratio", [3.0, 5.5])
    np.testing.assert_allclose(at[0], [27, -2], atol=1e-12)
    assert np.isnan(at[1]).all()
    with pytest.raises(ValueError, match="7 min lies outside the run"):
        found.interpolate("volume_ratio", [3.0, 7.0])
    with pytest.raises(ValueError, match="no derivatives of step_min; choose one of pressure_MPa"):
        found.interpolate("step_min", [3.0])
