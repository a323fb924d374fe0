"""Scenes, meshes and ways to run that several tests share."""

import csv
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support import ranks
from support.scenes import SMALL

# Nothing that loads dolfinx, which the tests of scenes and geometry do without.
from fenics_yeast import Scene
from fenics_yeast.scene import Cell, Growth, Numerics, Run, Turgor, Wall, Zone, parse_assignment
from fenics_yeast.simulation import Result

DATA = Path(__file__).parent / "data"
# The container takes all from Debian and goes without VTK for its size; `make test` installs it.
collect_ignore = [] if find_spec("vtkmodules") else ["figures/test_surface.py"]


Table = list[dict[str, str]]


@pytest.hookimpl(trylast=True)
def pytest_configure(config: pytest.Config) -> None:
    """Under mpirun, show only the tests of rank 0."""
    world = ranks.world()
    if world is not None and world.rank > 0:
        config.pluginmanager.unregister(name="terminalreporter")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run what the documents show first, for a reader tries that; mark what starts mpirun."""
    items.sort(key=lambda item: item.path.name != "test_docs.py")
    for item in items:
        if "mpirun" in getattr(item, "fixturenames", ()):
            item.add_marker("ranks")


def pytest_exception_interact(node: pytest.Item, report: pytest.TestReport) -> None:
    """Under mpirun, end all ranks when a test fails on one, which the others would wait for."""
    world = ranks.world()
    if world is not None and world.size > 1:
        print(f"rank {world.rank}: {node.nodeid}\n{report.longreprtext}", file=sys.__stderr__)
        world.Abort(1)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with a scene in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SMALL)
    return tmp_path


@pytest.fixture(scope="session")
def read_table() -> Callable[[str], Table]:
    """Read the rows of a table in `data`, by column."""

    def read(name: str) -> Table:
        lines = (DATA / name).read_text().splitlines()
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))

    return read


@pytest.fixture(scope="session")
def cell_scene() -> Scene:
    """The cell of the reference tables, its turgor applied at once; numerics of the preset."""
    return Scene(
        cell=Cell(shape="sphere", diameter=5.0),
        wall=Wall(thickness=0.1, shear_modulus=40.0, ogden_exponent=2.0),
        turgor=Turgor(pressure=0.20265, ramp=0.0),
        growth=Growth(zone=Zone(pole="top", half_angle=24.0), threshold=1.0, time=45.0),
        run=Run(end=90.0),
    )


@pytest.fixture(scope="session")
def paper_scene(cell_scene: Scene) -> Scene:
    """The paper's bud with the paper's scheme and κ = 100, to 90 min."""
    numerics = Numerics(preset="paper", shear_penalty=100.0)
    return cell_scene.with_values({"numerics": numerics, "run.save": (40.0, 70.0, 80.0, 90.0)})


@pytest.fixture(scope="session")
def fine_scene(cell_scene: Scene) -> Scene:
    """The paper's bud, converged: V/V0 to 1e-5 at 80 min, 4e-5 at 90 min."""
    numerics = Numerics(
        elements=60,
        order=3,
        grading="graded",
        geometry="curved",
        thickness_points=3,
        shear_penalty=1000.0,
        integrator="sdirk3",
        step=1.0,
    )
    return cell_scene.with_values({"numerics": numerics})


@pytest.fixture(scope="session")
def sphere_scene(fine_scene: Scene) -> Scene:
    """A sphere that grows everywhere, on few elements: its solution is smooth."""
    return fine_scene.with_values(
        {
            "growth.zone.half_angle": 180.0,
            "numerics.elements": 12,
            "numerics.grading": "uniform",
            "run.end": 8.0,
        }
    )


@pytest.fixture(scope="session")
def elastic_scene(sphere_scene: Scene) -> Scene:
    """A sphere under turgor that does not grow."""
    return sphere_scene.with_values({"growth": None, "run": None})


@pytest.fixture(scope="session")
def reference_run(
    cell_scene: Scene, fine_scene: Scene, read_table: Callable[[str], Table]
) -> Callable[[str, int], SimpleNamespace]:
    """Run a case of `volumes.csv`: its result and the table's V/V0 by time. Each runs once."""
    from fenics_yeast import simulate

    table = read_table("volumes.csv")
    done: dict[tuple[str, int], SimpleNamespace] = {}

    def run(case: str, thickness_points: int) -> SimpleNamespace:
        key = (case, thickness_points)
        if key not in done:
            rows = [
                row for row in table
                if (row["case"], int(row["thickness_points"])) == key
            ]  # fmt: skip
            wanted = {float(row["time_min"]): float(row["volume_ratio"]) for row in rows}
            scene = cell_scene if "numerics.preset" in rows[0]["changes"] else fine_scene
            changes = dict(map(parse_assignment, filter(None, rows[0]["changes"].split(";"))))
            changes["numerics.thickness_points"] = thickness_points
            if thickness_points != 3:
                changes["numerics.order"] = 4  # as in the default preset, compiled anyhow
            changes["run"] = Run(end=max(wanted), save=tuple(wanted))
            result = simulate(scene.with_values(changes))
            done[key] = SimpleNamespace(result=result, wanted=wanted)
        return done[key]

    return run


@pytest.fixture(scope="session")
def bud_run(reference_run: Callable[[str, int], SimpleNamespace]) -> Result:
    """The growing bud to 90 min, converged."""
    return reference_run("base", 3).result


@pytest.fixture(scope="session")
def one_element():
    """A mesh of one element on one rank, on which functions of constants can be evaluated."""
    from fenics_yeast import _dolfinx as dx

    return dx.interval_mesh(dx.MPI.COMM_SELF, np.array([0.0, 1.0]))


@pytest.fixture
def mpirun(tmp_path: Path) -> Callable[[str, int], Path]:
    """Run a Python text on a number of ranks, in a directory that is returned."""

    def run(text: str, number: int) -> Path:
        folder = tmp_path / f"{number}-ranks"
        folder.mkdir()
        script = folder / "script.py"
        script.write_text(text)
        done = subprocess.run(
            [*ranks.mpirun(number), sys.executable, str(script)],
            cwd=folder, env=ranks.environment(), capture_output=True, text=True, timeout=600,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return folder

    return run
