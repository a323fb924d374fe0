"""The default preset: its tolerance, orders, nodes and rejected steps."""

from pathlib import Path

import numpy as np
import pytest

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import build_shell
from fenics_yeast.simulation.discretise import discretise
from fenics_yeast.solve.equilibrium import Equilibrium
from fenics_yeast.solve.runge_kutta import TABLEAUX
from fenics_yeast.solve.time_stepper import TimeStepper

pytestmark = pytest.mark.slow

BUDS = {
    "bud": {"run.save": (40.0, 70.0, 80.0, 90.0)},
    "low threshold": {
        "growth.threshold": 0.9,
        "run.end": 65.0,
        "run.save": (20.0, 40.0, 60.0, 65.0),
    },
    "soft wall": {
        "wall.shear_modulus": 20.0,
        "run.end": 60.0,
        "run.save": (20.0, 40.0, 50.0, 60.0),
    },
    "wide zone, fast growth": {
        "growth.zone.half_angle": 120.0,
        "run.end": 12.5,
        "run.save": (5.0, 10.0, 12.5),
    },
    "thin wall": {
        "wall.thickness": 0.0025,
        "turgor.pressure": 0.20265 / 40,
        "run.end": 80.0,
        "run.save": (40.0, 80.0),
    },
}


def ratios(scene):
    result = simulate(scene)
    assert result.status == "finished"
    return np.array([result.history.at(time).volume_ratio for time in scene.run.save])


@pytest.mark.parametrize("name", BUDS)
def test_volume_error_is_within_three_times_the_tolerance(cell_scene, name):
    """Within a factor 3, against a much finer run with twice the elements."""
    scene = cell_scene.with_values({"numerics.thickness_points": 3, **BUDS[name]})
    truth = ratios(scene.with_values({"numerics.tolerance": 1e-7, "numerics.elements": 64}))
    for tolerance in (1e-3, 1e-4, 1e-5, 1e-6):
        found = ratios(scene.with_values({"numerics.tolerance": tolerance}))
        assert np.abs(found / truth - 1).max() < 3 * tolerance


@pytest.mark.parametrize(("name", "order"), [("backward-euler", 1), ("sdirk2", 2), ("sdirk3", 3)])
def test_integrator_has_its_order_on_a_bud(cell_scene, name, order):
    """Fitted to differences of V/V0 at 40 min, long after the fast start of growth."""
    scene = cell_scene.with_values(
        {"numerics.thickness_points": 3, "numerics.integrator": name, "run.end": 40.0}
    )
    steps = 2.5 * 0.5 ** np.arange(4)
    volumes = [
        simulate(scene.with_values({"numerics.step": step})).history.volume_ratio[-1]
        for step in steps
    ]
    differences = np.abs(np.diff(volumes))
    fitted = np.polyfit(np.log(steps[1:]), np.log(differences), 1)[0]
    assert fitted == pytest.approx(order, abs=0.3)


@pytest.mark.parametrize("geometry", ["curved", "conical"])
@pytest.mark.parametrize("grading", ["uniform", "graded"])
@pytest.mark.parametrize("pole", ["top", "bottom"])
@pytest.mark.parametrize("angle", [0.01, 1.0, 24.37, 89.99, 137.77, 179.99, 180.0])
def test_edge_of_the_zone_is_a_node(cell_scene, angle, pole, grading, geometry):
    zone = {"pole": pole, "half_angle": angle}
    scene = cell_scene.with_values(
        {"growth.zone": zone, "numerics": {"grading": grading, "geometry": geometry}}
    )
    cut = discretise(scene)
    assert np.all(np.diff(cut.nodes) > 0)
    assert len(cut.nodes) == scene.numerics.elements + 1
    (zone,) = cut.growing
    for end in (zone.start, zone.end):
        assert np.abs(cut.nodes - end).min() < 1e-12 * cut.curve.length
    edge = zone.start if pole == "top" else zone.end
    radius = np.abs(cut.curve.radius(np.array([edge]))[0])
    assert radius == pytest.approx(2.5 * np.sin(np.radians(angle)), abs=1e-9)


@pytest.mark.parametrize("name", ["backward-euler", "sdirk2", "sdirk3"])
def test_rejected_step_leaves_no_trace(cell_scene, name):
    scene = cell_scene.with_values({"numerics.thickness_points": 3})
    volumes = []
    for rejected in (True, False):
        shell = build_shell(scene)
        with Equilibrium(shell, 1e-9) as equilibrium:
            stepper = TimeStepper(shell, equilibrium, TABLEAUX[name], lambda time: 0.20265)
            stepper.load()
            stepper.step(0.5)
            before, state = shell.state(), stepper.accepted
            if rejected:
                stepper.attempt(4.0)
                assert not np.array_equal(shell.w.x.array, before.w)
                stepper.reject()
            assert np.array_equal(shell.w.x.array, before.w)
            assert np.array_equal(shell.growth.get(), before.eps_g)
            assert stepper.accepted is state
            stepper.step(1.0)
            volumes.append(shell.volume())
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-10)


@pytest.mark.parametrize(
    ("numerics", "most"), [({"preset": "default"}, 260), ({"preset": "paper"}, 680)]
)
def test_newton_needs_few_iterations(numerics: dict[str, object], most: int) -> None:
    """Adaptive steps are predicted from three solutions, the paper's short equal ones from five.

    With five and three, it would be 294 and 1156.
    """
    bud = Scene.load(Path(__file__).parents[2] / "demos" / "scenes" / "bud.toml")
    result = simulate(bud.with_values({"numerics": numerics}))
    assert result.status == "finished"
    assert result.newton_iterations <= most
