"""Derivatives by any number of a scene, exact or by runs that repeat the steps."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from fenics_yeast import Scene, SceneError, simulate
from fenics_yeast.simulation import Replay, ShellPool
from fenics_yeast.studies import differences, simulate_with_derivatives

BUD = Scene.from_toml("""
cell = { shape = "sphere", diameter = 5 }
wall = { thickness = 0.1, shear_modulus = 40 }
turgor = { pressure = 0.2 }
growth = { zone = { pole = "top", half_angle = 24 }, threshold = 1, time = 45 }
run = { end = 40 }
numerics = { tolerance = 0.01, thickness_points = 3 }
""")


@pytest.fixture(scope="module")
def shells() -> Iterator[ShellPool]:
    with ShellPool() as pool:
        yield pool


def test_steps_and_mesh_of_a_run_are_repeated(shells: ShellPool) -> None:
    """As many rows at the same times, and as many elements in the zone, whatever its angle."""
    run = simulate(BUD, shells=shells)
    replay = Replay.of(BUD, run.history)
    again = simulate(BUD, replay=replay, shells=shells)
    np.testing.assert_array_equal(again.history.time_min, run.history.time_min)
    np.testing.assert_allclose(again.history.volume_ratio, run.history.volume_ratio, atol=2e-5)
    wide = BUD.with_values({"growth.zone.half_angle": 50, "wall.thickness": 0.2})
    repeated = simulate(wide, replay=replay, shells=shells)
    assert repeated.dofs == run.dofs and repeated.status == "finished"
    np.testing.assert_array_equal(repeated.history.time_min, run.history.time_min)
    assert simulate(wide, shells=shells).history.time_min.tolist() != replay.times


def test_repeated_runs_are_smooth_in_a_shape(shells: ShellPool) -> None:
    """V/V0 against the angle is a polynomial of degree 6 to 1e-9; with own steps, to 1e-6 only."""
    replay = Replay.of(BUD, simulate(BUD, shells=shells).history)
    places = np.linspace(-1, 1, 13)
    scenes = [BUD.with_values({"growth.zone.half_angle": 24 + 0.5 * x}) for x in places.tolist()]
    away = []
    for kept in (replay, None):
        runs = [simulate(scene, replay=kept, shells=shells).history for scene in scenes]
        volumes = np.array([history.volume_ratio[-1] for history in runs])
        curve = np.polynomial.Polynomial.fit(places, volumes, 6)
        away.append(np.abs(curve(places) - volumes).max())
    repeated, own = away
    assert repeated < 1e-9 and own > 100 * repeated


def test_exact_derivatives_and_differences_agree(shells: ShellPool) -> None:
    keys = ("growth.threshold", "growth.time", "turgor.pressure", "wall.shear_modulus")
    run = simulate_with_derivatives(BUD, keys, shells=shells)
    assert run.sensitivities is not None
    for i, key in enumerate(keys):
        by_differences = differences(BUD, key, run.history, shells=shells)
        assert by_differences.parameters == (key,)
        for column in ("volume_um3", "volume_ratio", "pole_height_um"):
            exact = run.sensitivities.of(column)[:, i]
            error = np.abs(by_differences.of(column)[:, 0] - exact).max()
            assert error < 1e-4 * np.abs(exact).max(), (key, column)


def test_a_cell_of_another_size_is_the_same_cell(shells: ShellPool) -> None:
    """All lengths together are a unit: R ∂V/∂R + h ∂V/∂h = 3 V; one exact, one by differences."""
    keys = ("cell.diameter", "wall.thickness")
    scene = BUD.with_values({"numerics.tolerance": 1e-3})
    run = simulate_with_derivatives(scene, keys, shells=shells)
    found = run.sensitivities
    assert found is not None and found.parameters == keys and found.values == (5.0, 0.1)
    by_size = found.of("volume_um3") @ np.array(found.values)
    np.testing.assert_allclose(by_size, 3 * run.history.volume_um3, rtol=1e-4)
    heights = found.of("pole_height_um") @ np.array(found.values)
    np.testing.assert_allclose(heights, run.history.pole_height_um, rtol=1e-4)


def test_the_order_is_that_of_the_keys_and_times_are_free(shells: ShellPool) -> None:
    keys = ("growth.zone.half_angle", "growth.time", "cell.diameter", "growth.threshold")
    run = simulate_with_derivatives(BUD, keys, shells=shells)
    found = run.sensitivities
    assert found is not None and found.parameters == keys
    assert found.values == (24.0, 45.0, 5.0, 1.0)
    between = found.interpolate("volume_ratio", [13.3, 27.7])
    assert between.shape == (2, 4)
    # A larger zone or cell grows more; a longer time and a higher threshold mean less growth.
    assert (np.sign(between) == [1, -1, 1, -1]).all()
    backwards = simulate_with_derivatives(BUD, keys[::-1], shells=shells).sensitivities
    assert backwards is not None
    np.testing.assert_array_equal(backwards.volume_um3, found.volume_um3[:, ::-1])


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("turgor.ramp", "turgor.ramp moves times at which growth or pressure change"),
        ("numerics.elements", "expected the key of a number that can vary continuously"),
        ("growth.speed", "growth.speed: the scene has no such key"),
        ("cell.shape", "expected the key of a number"),
    ],
)
def test_what_cannot_vary_is_refused_by_name(key: str, said: str) -> None:
    with pytest.raises(SceneError) as caught:
        simulate_with_derivatives(BUD, [key])
    assert key in str(caught.value) and said in str(caught.value)


SCRIPT = """
import numpy as np
from mpi4py import MPI

from fenics_yeast import Scene
from fenics_yeast.studies import simulate_with_derivatives

keys = {keys!r}
found = simulate_with_derivatives(Scene.from_toml('''{scene}'''), keys).sensitivities
for other in MPI.COMM_WORLD.allgather(found):
    np.testing.assert_array_equal(other.volume_um3, found.volume_um3)
if MPI.COMM_WORLD.rank == 0:
    names = ("volume_um3", "pole_height_um", "bud_radius_um", "neck_radius_um")
    np.save("found.npy", [found.of(name) for name in names])
"""


@pytest.mark.slow
def test_derivatives_do_not_depend_on_the_number_of_ranks(
    mpirun: Callable[[str, int], Path],
) -> None:
    """The zone lies on one rank or on two; the last key is done by differences."""
    keys = "growth.threshold", "turgor.pressure", "wall.thickness", "growth.zone.half_angle"
    text = SCRIPT.format(keys=keys, scene=BUD.to_toml())
    one, two, three = (np.load(mpirun(text, ranks) / "found.npy") for ranks in (1, 2, 3))
    for other in (two, three):
        np.testing.assert_allclose(other, one, rtol=1e-7, atol=1e-9)
