"""Results do not depend on the number of ranks."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from fenics_yeast import Scene

SCRIPT = """
import numpy as np
from mpi4py import MPI

from fenics_yeast import Scene, simulate
from fenics_yeast.studies.error_bars import estimate_error_bars
from fenics_yeast.simulation import COLUMNS

TEXT = '''{scenes}'''

world = MPI.COMM_WORLD
for number, text in enumerate(TEXT.split("=====")):
    scene = Scene.from_toml(text)
    result = simulate(scene)
    history = np.array([getattr(result.history, name) for name in COLUMNS])
    found = {{"history": history, "status": result.status, "message": result.message}}
    if scene.title == "error bars":
        bars = estimate_error_bars(scene, result).columns()
        found |= {{f"error by {{name}}": values for name, values in bars.items()}}
    for other in world.allgather(found):  # the same on every rank
        assert other.keys() == found.keys()
        for name in found:
            np.testing.assert_array_equal(other[name], found[name])
    if world.rank == 0:
        np.savez(f"{{number}}.npz", **found, **result.profiles.arrays())
    else:
        assert len(result.profiles) == 0

# each rank runs the whole wall
alone = simulate(scene, comm=MPI.COMM_SELF)
assert len(alone.profiles) == 2
np.testing.assert_allclose(
    alone.history.volume_ratio, result.history.volume_ratio, rtol=0, atol=1e-9
)
"""

Results = dict[str, dict[str, np.ndarray]]


@pytest.fixture(scope="module")
def scenes(
    cell_scene: Scene, paper_scene: Scene, fine_scene: Scene, sphere_scene: Scene
) -> dict[str, Scene]:
    """Short runs by name; the zone lies on one rank or is split between two."""
    run = {"run": {"end": 1.0, "save": [0.5, 1.0]}, "turgor.ramp": 0.01}
    fixed = {**run, "numerics.step": 0.5}
    bottom = {"growth.zone.pole": "bottom", "numerics.elements": 40}
    adaptive = {**run, "run": {"end": 0.5, "save": [0.5]}, "numerics.tolerance": 1e-2}
    burst = {"turgor.pressure": 1.9, "numerics.step": None, "numerics.tolerance": 1e-2}
    one_step = {"run": {"end": 0.5, "save": [0.5]}, "numerics.integrator": "backward-euler"}
    return {
        "the paper's scheme": paper_scene.with_values({**fixed, "numerics.elements": 120}),
        "adaptive steps": cell_scene.with_values(adaptive),
        "burst": sphere_scene.with_values(burst),
        "error bars": sphere_scene.with_values({**one_step, "title": "error bars"}),
        "of higher order": fine_scene.with_values({**fixed, **bottom}),
    }


@pytest.fixture
def runs(scenes: dict[str, Scene], mpirun: Callable[[str, int], Path]) -> Callable[[int], Results]:
    """Results of all scenes on a number of ranks."""
    text = SCRIPT.format(scenes="=====".join(scene.to_toml() for scene in scenes.values()))

    @cache
    def run(ranks: int) -> Results:
        folder = mpirun(text, ranks)
        return {name: dict(np.load(folder / f"{i}.npz")) for i, name in enumerate(scenes)}

    return run


@pytest.mark.slow
def test_one_two_and_three_ranks_give_the_same_results(runs: Callable[[int], Results]) -> None:
    """History, profiles, stability, error bars, and how a run ends."""
    one = runs(1)
    for ranks in (2, 3):
        for case, alone in one.items():
            shared = runs(ranks)[case]
            assert alone.keys() == shared.keys()
            for name, values in alone.items():
                what = f"{case}, {ranks} ranks: {name}"
                assert values.shape == shared[name].shape, what
                if values.dtype.kind == "U":
                    assert values == shared[name], what
                else:
                    np.testing.assert_allclose(
                        shared[name], values, rtol=1e-9, atol=1e-9, err_msg=what
                    )
    statuses = {name: str(result["status"]) for name, result in one.items()}
    assert statuses == {name: "no-equilibrium" if name == "burst" else "finished" for name in one}
    assert all("growth_strain" in one[name] for name in ("the paper's scheme", "burst"))
    assert one["the paper's scheme"]["growth_strain"].max() > 1e-4
    assert one["error bars"]["error by total"].min() > 0
