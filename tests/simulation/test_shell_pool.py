"""Shells that serve one run after another give the same digits as new ones, without new forms."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from mpi4py import MPI
from support import scenes

from fenics_yeast import Scene, simulate
from fenics_yeast import _dolfinx as dx
from fenics_yeast.simulation import Result, ShellPool

BUD = Scene.from_toml(scenes.SMALL)
HYPHA = BUD.with_values({"growth.polarity": {"width": 1.0, "follow": "tip"}})
CAP = Scene.from_toml("""
[cell]
shape = "cone"
outer_diameter = 6
inner_diameter = 2
height = 1
edge = "hinged"
inner_edge = "free"
[wall]
thickness = 0.2
shear_modulus = 40
[turgor]
pressure = 0.05
""")
INDENTED = Scene.from_toml("""
cell = { shape = "sphere", diameter = 5 }
wall = { thickness = 0.1, shear_modulus = 40 }
turgor = { pressure = 0.2 }
load = { point_force = -0.01 }
""")
CASES: dict[str, tuple[Scene, list[dict[str, object]]]] = {
    "numbers": (BUD, [{"growth.time": 30}, {"wall.thickness": 0.12, "wall.shear_modulus": 30}]),
    "places of nodes": (
        BUD.with_values({"numerics": {"preset": "default", "tolerance": 0.01}}),
        [{"cell.diameter": 4.0}, {"growth.zone.half_angle": 30.0}],
    ),
    "spans and tips": (HYPHA, [{"growth.polarity.width": 0.5}, {"growth.threshold": 1.2}]),
    "laws": (
        BUD.with_values({"wall.energy_per": "grown", "wall.thickness_change": "elastic"}),
        [{"wall.ogden_exponent": 2.5}],
    ),
    "zones of the wall": (
        BUD.with_values(
            {"wall.zone": [{"from_fraction": 0.2, "to_fraction": 0.4, "thickness": 0.2}]}
        ),
        [{"wall.zone": [{"from_fraction": 0.2, "to_fraction": 0.4, "thickness": 0.3}]}],
    ),
    "free edges": (CAP, [{"cell.inner_diameter": 3}, {"cell.height": 2}]),
    "forces": (INDENTED, [{"load.point_force": -0.02}, {"cell.diameter": 4.0}]),
}


def same(one: Result, other: Result) -> bool:
    """Whether two results have the same digits."""
    assert one.status == other.status and one.message == other.message
    for a, b in zip(one.profiles.all, other.profiles.all, strict=True):
        for x, y in zip(vars(a).values(), vars(b).values(), strict=True):
            np.testing.assert_array_equal(x, y)
    return one.history.rows == other.history.rows


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """The forms and expressions that are built, as a growing list."""
    built: list[str] = []
    for name in ("compile_form", "compile_expression"):
        build = getattr(dx, name)

        def counted(*arguments: Any, build: Any = build, name: str = name) -> Any:
            built.append(name)
            return build(*arguments)

        monkeypatch.setattr(dx, name, counted)
    yield built


@pytest.mark.slow
@pytest.mark.distributed
@pytest.mark.parametrize("case", CASES)
def test_a_shell_used_again_gives_the_digits_of_a_new_one(case: str, compiled: list[str]) -> None:
    first, others = CASES[case]
    expected = [simulate(first.with_values(changes)) for changes in [*others, {}]]
    with ShellPool() as shells:
        simulate(first, shells=shells)
        compiled.clear()
        for changes, new in zip([*others, {}], expected, strict=True):
            assert same(simulate(first.with_values(changes), shells=shells), new)
        assert compiled == []


def test_a_run_that_lost_its_equilibrium_leaves_no_trace() -> None:
    expected = simulate(BUD)
    with ShellPool() as shells:
        lost = simulate(BUD.with_values({"turgor.pressure": 50.0}), shells=shells)
        assert lost.status == "no-equilibrium"
        assert same(simulate(BUD, shells=shells), expected)


def test_another_structure_has_a_shell_of_its_own() -> None:
    with ShellPool() as shells:
        shell = shells.borrow(BUD)
        shells.give_back(shell)
        assert shells.borrow(BUD.with_values({"growth.time": 10})) is shell
        for changes in (
            {"numerics.elements": BUD.numerics.elements + 2},
            {"wall.energy_per": "grown"},
            {"wall.bending": False},
            {"growth": None, "run": None},
            {"growth.from": 5},
        ):
            shells.give_back(shell)
            assert shells.borrow(BUD.with_values(changes)) is not shell
            assert shells.borrow(BUD) is shell


def test_a_pool_keeps_only_the_last_shells() -> None:
    with ShellPool() as shells:
        lent = [shells.borrow(BUD.with_values({"numerics.elements": n})) for n in range(8, 18)]
        for shell in lent:
            shells.give_back(shell)
        again = [shells.borrow(BUD.with_values({"numerics.elements": n})) for n in range(8, 18)]
        assert [a is b for a, b in zip(again, lent, strict=True)] == [False] * 2 + [True] * 8


def test_threads_never_share_a_shell() -> None:
    expected = [simulate(BUD.with_values({"growth.time": t}), comm=MPI.COMM_SELF) for t in (30, 40)]
    with ShellPool() as shells, ThreadPoolExecutor(2) as pool:

        def run(time: float) -> Result:
            scene = BUD.with_values({"growth.time": time})
            return simulate(scene, shells=shells, comm=MPI.COMM_SELF)

        for _ in range(3):
            for new, old in zip(pool.map(run, (30, 40)), expected, strict=True):
                assert same(new, old)
