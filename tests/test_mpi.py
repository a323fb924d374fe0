"""A wall shared by ranks is the same wall."""

from functools import cache

import numpy as np
import pytest

SCRIPT = """
import numpy as np
from mpi4py import MPI

from fenics_yeast import Scene, simulate
from fenics_yeast.record import COLUMNS

TEXT = '''{scenes}'''

world = MPI.COMM_WORLD
for number, text in enumerate(TEXT.split("=====")):
    result = simulate(Scene.from_toml(text))
    assert result.status == "finished", result.message
    history = np.array([getattr(result.history, name) for name in COLUMNS])
    for other in world.allgather(history):  # every rank has the history
        np.testing.assert_array_equal(other, history)
    if world.rank == 0:
        np.savez(f"{{number}}.npz", history=history, **result.profiles.arrays())
    else:
        assert len(result.profiles) == 0

# a wall of its own for each rank
alone = simulate(Scene.from_toml(text), comm=MPI.COMM_SELF)
assert len(alone.profiles) == 2
np.testing.assert_allclose(
    alone.history.volume_ratio, result.history.volume_ratio, rtol=0, atol=1e-9
)
"""


@pytest.fixture
def runs(paper_scene, fine_scene, mpirun):
    """Results by name on a number of ranks, of the paper's scheme and of one of higher order."""
    values = {"run": {"end": 1.0, "save": [0.5, 1.0]}, "turgor.ramp": 0.01, "numerics.step": 0.5}
    scenes = [
        paper_scene.with_values({**values, "numerics.elements": 120}),
        fine_scene.with_values({**values, "growth.zone.pole": "bottom", "numerics.elements": 40}),
    ]
    text = SCRIPT.format(scenes="=====".join(scene.to_toml() for scene in scenes))

    @cache
    def run(ranks: int) -> list[dict[str, np.ndarray]]:
        folder = mpirun(text, ranks)
        return [dict(np.load(folder / f"{number}.npz")) for number in range(len(scenes))]

    return run


def test_any_number_of_ranks_gives_the_same(runs):
    """History and profiles; the zone lies on one rank alone or is cut through."""
    for ranks in (2, 3):
        for alone, shared in zip(runs(1), runs(ranks), strict=True):
            assert alone.keys() == shared.keys()
            for name, values in alone.items():
                assert values.shape == shared[name].shape, name
                np.testing.assert_allclose(shared[name], values, rtol=1e-9, atol=1e-9, err_msg=name)
    assert runs(1)[0]["growth_strain"].max() > 1e-4
