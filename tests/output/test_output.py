"""The output folder: what a run leaves behind, and how it is read while the run still goes."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from fenics_yeast import Scene
from fenics_yeast.output import read_history, read_profiles, read_scene, read_summary
from fenics_yeast.output.folder import OutputError, OutputFolder
from fenics_yeast.simulation import COLUMNS, History, Profile, Profiles, Result, Row, Timings

CONTRACT = (
    "time_min, pressure_MPa, volume_um3, volume_ratio, pole_height_um, bud_radius_um, "
    "neck_radius_um, max_growth_strain, dissipation_rate, step_min, newton_iterations, stable, "
    "force_uN, displacement_um, unstable_waves"
)


def a_row(time: float) -> Row:
    third = time / 3  # needs all its digits
    values = (time, 0.1, 65.4, 1 + third, 5.0, 1.0, 1.0, np.float64(third), 0.0, 0.2, 3, True,
              0.5, -0.25, None if time == 0 else 3)  # fmt: skip
    return Row(
        **dict.fromkeys(COLUMNS, True) | dict(zip(CONTRACT.split(", "), values, strict=True))
    )


def a_profile(time: float) -> Profile:
    nodes, points, n = 5, 4, 3
    line = np.linspace(0, 1, nodes)
    fields = np.arange(points * n * 2).reshape(points, n, 2) / 7 + time
    return Profile(
        time=time, S=line, r=line + time, z=line / 3, psi=line, S_points=line[1:] - 0.1,
        xi=np.array([-0.1, 0.0, 0.1]), strain=fields, stress=2 * fields, growth_strain=3 * fields,
    )  # fmt: skip


def a_result(**changes: object) -> Result:
    values = {
        "history": History([a_row(0), a_row(1)]), "profiles": Profiles((a_profile(1),)),
        "status": "no-equilibrium", "message": "it went soft", "end_time": 1.0, "dofs": 7,
        "steps": 1, "rejected_steps": 2, "newton_iterations": 6, "timings": Timings(loop_s=1.5),
    }  # fmt: skip
    return Result(**(values | changes))


@pytest.fixture
def scene(cell_scene: Scene) -> Scene:
    return cell_scene.with_values({"run.save": [1, 2]})


def same(a: Profile, b: Profile) -> bool:
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in vars(a))


def test_files_are_those_of_the_contract(tmp_path: Path, scene: Scene) -> None:
    with OutputFolder(tmp_path / "new" / "run", scene) as folder:
        for time in (0.0, 1.0):
            folder.accepted(a_row(time))
        folder.saved(a_profile(1.0))
        folder.finish(a_result(), Timings(import_s=0.5, total_s=9.0))
    written = {path.name for path in folder.path.iterdir()}
    assert written == {"scene.toml", "history.csv", "profiles.npz", "run.json"}

    assert Scene.load(folder.path / "scene.toml") == scene
    with open(folder.path / "history.csv") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == CONTRACT.split(", ")
    assert [float(row["volume_ratio"]) for row in rows] == [1.0, 1 + 1 / 3]
    assert rows[1]["newton_iterations"] == "3"
    with np.load(folder.path / "profiles.npz") as arrays:
        assert {"S", "r", "z", "psi", "strain", "stress", "growth_strain"} <= set(arrays)

    summary = json.loads((folder.path / "run.json").read_text())
    keys = (
        "status end_time_min message versions dofs steps rejected_steps newton_iterations timings "
        "error_estimate bifurcation warnings"
    )
    assert list(summary) == keys.split()
    assert summary["status"] == "no-equilibrium"
    assert list(summary["versions"]) == ["fenics_yeast", "dolfinx", "petsc", "python", "numpy"]
    assert all(version[0].isdigit() for version in summary["versions"].values())
    timings = {"import_s", "setup_s", "compile_s", "loop_s", "output_s", "total_s"}
    assert set(summary["timings"]) == timings
    assert summary["timings"]["total_s"] == 9.0


def test_what_is_written_is_read_back_to_the_last_digit(tmp_path: Path, scene: Scene) -> None:
    rows, profiles = [a_row(t) for t in (0.0, 0.1, 2.0)], [a_profile(t) for t in (0.1, 2.0)]
    with OutputFolder(tmp_path, scene) as folder:
        for row in rows:
            folder.accepted(row)
        for profile in profiles:
            folder.saved(profile)
        result = a_result(history=History(rows), profiles=Profiles(tuple(profiles)))
        folder.finish(result, Timings())
    assert read_scene(tmp_path) == scene
    assert list(read_history(tmp_path).rows) == rows
    assert all(map(same, read_profiles(tmp_path), profiles))
    assert len(read_profiles(tmp_path)) == 2
    assert read_summary(tmp_path).status == "no-equilibrium"


def test_a_run_that_still_goes_can_be_read(tmp_path: Path, scene: Scene) -> None:
    with OutputFolder(tmp_path, scene) as folder:
        assert len(read_history(tmp_path)) == len(read_profiles(tmp_path)) == 0
        folder.accepted(a_row(1.0))
        folder.saved(a_profile(1.0))
        assert read_history(tmp_path).at(1.0) == a_row(1.0)
        assert same(read_profiles(tmp_path).at(1.0), a_profile(1.0))
        assert read_summary(tmp_path) is None


def test_a_history_cut_anywhere_reads_up_to_the_last_whole_line(
    tmp_path: Path, scene: Scene
) -> None:
    with OutputFolder(tmp_path, scene) as folder:
        for time in (0.0, 1.0):
            folder.accepted(a_row(time))
    path = tmp_path / "history.csv"
    whole = path.read_bytes()
    first, second = (whole.index(b"\n", at) + 1 for at in (0, whole.index(b"\n") + 1))
    for length in range(first, len(whole) + 1):
        path.write_bytes(whole[:length])
        expected = (length >= second) + (length == len(whole))
        assert len(read_history(tmp_path)) == expected


def test_damage_is_reported_with_its_place(tmp_path: Path, scene: Scene) -> None:
    with OutputFolder(tmp_path, scene) as folder:
        folder.accepted(a_row(0.0))
    with open(tmp_path / "history.csv", "a") as file:
        file.write("1,2,three\n")
    with pytest.raises(OutputError, match=r"history\.csv: line 3 is damaged"):
        read_history(tmp_path)
    (tmp_path / "profiles.npz").write_bytes(b"PK")
    with pytest.raises(OutputError, match=r"profiles\.npz: damaged"):
        read_profiles(tmp_path)
    (tmp_path / "run.json").write_text("{")
    with pytest.raises(OutputError, match=r"run\.json: damaged"):
        read_summary(tmp_path)
    with pytest.raises(OutputError, match=r"elsewhere: no such directory"):
        read_history(tmp_path / "elsewhere")
    (tmp_path / "elsewhere").mkdir()
    for read, name in ((read_history, "history"), (read_scene, "scene")):
        with pytest.raises(OutputError, match=rf"no {name}\..*; not the output directory"):
            read(tmp_path / "elsewhere")


def test_a_second_run_replaces_the_first_and_nothing_else(tmp_path: Path, scene: Scene) -> None:
    with OutputFolder(tmp_path, scene) as folder:
        for time in (0.0, 1.0):
            folder.accepted(a_row(time))
        folder.saved(a_profile(1.0))
        folder.finish(a_result(), Timings())
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "shapes.png").write_text("of the first run")
    (tmp_path / "figures" / "mine.png").write_text("drawn by hand")
    (tmp_path / "notes.txt").write_text("dear diary")
    other = scene.with_values({"turgor.pressure": 0.1})
    with OutputFolder(tmp_path, other):
        assert read_scene(tmp_path) == other
        assert len(read_history(tmp_path)) == len(read_profiles(tmp_path)) == 0
        assert read_summary(tmp_path) is None
    assert {path.name for path in (tmp_path / "figures").iterdir()} == {"mine.png"}
    assert (tmp_path / "notes.txt").read_text() == "dear diary"


@pytest.mark.parametrize("name", ["scene.toml", "history.csv", "run.json"])
def test_a_file_of_somebody_else_is_never_overwritten(
    tmp_path: Path, scene: Scene, name: str
) -> None:
    (tmp_path / name).write_text("precious")
    with pytest.raises(OutputError, match=f"contains a {name} that is not from a run"):
        OutputFolder(tmp_path, scene)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "precious"


def test_an_unwritable_place_is_reported_on_one_line(tmp_path: Path, scene: Scene) -> None:
    file = tmp_path / "file"
    file.write_text("")
    for place in (file, file / "below"):
        with pytest.raises(
            OutputError, match=r"must be a directory, but it or .* is a file; choose another"
        ):
            OutputFolder(place, scene)
    with pytest.raises(OutputError, match=r"^/proc/here: cannot be written: .*; choose another"):
        OutputFolder(Path("/proc/here"), scene)


def test_no_temporary_file_stays(tmp_path: Path, scene: Scene) -> None:
    with OutputFolder(tmp_path, scene) as folder:
        broken = a_profile(1.0)
        folder.saved(broken)
        object.__setattr__(broken, "r", np.zeros(99))  # cannot be stacked with the next
        with pytest.raises(ValueError):
            folder.saved(a_profile(2.0))
            folder.finish(a_result(profiles=Profiles((broken, a_profile(2.0)))), Timings())
    assert not list(tmp_path.glob("*.part"))
    assert len(read_profiles(tmp_path)) == 1  # the whole file from before


def test_profiles_of_many_saved_times_are_all_there_at_the_end(
    tmp_path: Path, scene: Scene
) -> None:
    profiles = tuple(map(a_profile, np.linspace(0, 10, 200)))
    with OutputFolder(tmp_path, scene) as folder:
        for profile in profiles:
            folder.saved(profile)
        folder.finish(a_result(profiles=Profiles(profiles)), Timings())
    assert len(read_profiles(tmp_path)) == 200
    assert all(map(same, read_profiles(tmp_path), profiles))


def test_what_an_interrupt_kept_from_the_folder_is_there_at_the_end(
    tmp_path: Path, scene: Scene
) -> None:
    with OutputFolder(tmp_path, scene) as folder:
        folder.accepted(a_row(0.0))
        folder.finish(a_result(), Timings())
    assert list(read_history(tmp_path).rows) == [a_row(0), a_row(1)]
    assert same(read_profiles(tmp_path).at(1), a_profile(1))
