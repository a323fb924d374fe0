"""The mode of a run's first bifurcation."""

import numpy as np
import pytest
from mpi4py import MPI

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import BucklingMode, buckling_modes

RING = """
cell = { shape = "cylinder", diameter = 200, length = 100, edge = "guided" }
wall = { thickness = 0.5, law = "linear", young_modulus = 1000, poisson_ratio = 0.3 }
path = { until = { pressure = -5e-5 }, steps = 5 }
numerics = { elements = 8 }
"""
CAPSULE = """
cell = { shape = "capsule", diameter = 5, length = 15 }
wall = { thickness = 0.1, shear_modulus = 40 }
path = { until = { pressure = -0.012 }, steps = 5 }
numerics = { elements = 24 }
"""


def found(text: str, comm: MPI.Comm | None = None) -> BucklingMode:
    mode = simulate(Scene.from_toml(text), comm=comm).mode
    assert mode is not None
    assert np.linalg.norm([mode.radial, mode.around, mode.axial], axis=0).max() == pytest.approx(1)
    return mode


def test_a_ring_buckles_without_stretching_its_wall() -> None:
    """`u_θ = -u_r / n`, which keeps the length of the ring: Timoshenko and Gere 1961."""
    mode = found(RING)
    assert mode.waves == 2
    assert mode.radial == pytest.approx(np.full(len(mode.S), 1.25**-0.5), rel=1e-4)
    assert mode.around == pytest.approx(-mode.radial / 2, rel=1e-4)
    assert abs(mode.axial).max() < 1e-4


@pytest.mark.distributed
def test_a_capsule_buckles_around_its_middle_on_any_number_of_ranks() -> None:
    mode, alone = found(CAPSULE), found(CAPSULE, MPI.COMM_SELF)
    assert mode.waves == 3
    for name in ("S", "r", "z", "radial", "around", "axial"):
        assert getattr(mode, name) == pytest.approx(getattr(alone, name), abs=1e-6)
    assert mode.radial == pytest.approx(mode.radial[::-1], abs=1e-6)
    assert mode.axial == pytest.approx(-mode.axial[::-1], abs=1e-6)
    assert mode.S[np.argmax(abs(mode.radial))] == pytest.approx(mode.S[-1] / 2, rel=0.1)


def test_the_mode_of_a_run_is_near_that_of_linear_buckling() -> None:
    mode = found(CAPSULE)
    (linear,) = buckling_modes(Scene.from_toml(CAPSULE), [3])
    for name in ("radial", "around", "axial"):
        assert getattr(mode, name) == pytest.approx(getattr(linear, name), abs=0.01)


def test_a_wall_that_stays_stable_has_no_mode() -> None:
    inflated = CAPSULE.replace("-0.012", "0.2")
    assert simulate(Scene.from_toml(inflated)).mode is None
