"""`fenics-yeast fit` and `design` end to end, with their files and endings."""

import csv
import json
import re
import signal
from pathlib import Path

import pytest
from support.command import call, finish, start, tree, wait_for

FIT = """
scene = "bud.toml"
vary = { "growth.time" = { from = "20 min", to = "90 min", start = "60 min" } }
[[curve]]
file = "cell.csv"
noise = 0.01
"""
BUD = """
cell = { shape = "sphere", diameter = 5 }
wall = { thickness = 0.1, shear_modulus = 40 }
turgor = { pressure = 0.20265 }
growth = { zone = { pole = "top", half_angle = 24 }, threshold = 1, time = 30 }
run = { end = 40 }
numerics = { tolerance = 0.01, thickness_points = 3 }
"""
# With a growth time of 45 min, by another program.
CELL = """time_min,volume_ratio
10,1.0558
20,1.0668
30,1.0773
40,1.0891
50,1.1038
60,1.1241
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in (("bud.toml", BUD), ("fit.toml", FIT), ("cell.csv", CELL)):
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.process
def test_a_fit_from_file_to_figures(folder: Path) -> None:
    out = folder / "out"
    done = finish("fit", str(folder / "fit.toml"), "--out", str(out), "--profile", "--jobs", "1")
    assert (done.returncode, done.stderr) == (0, "")
    figures = {f"figures/{name}.png" for name in ("fit", "profile")}
    assert tree(out) == {"fit.json", "fit.csv", "runs.csv"} | figures
    found = json.loads((out / "fit.json").read_text())
    time = found["parameters"]["growth.time"]
    assert time["value"] == pytest.approx(45, rel=5e-3) and time["unit"] == "min"
    assert 35 < time["low"] < 45 < time["high"] < 55 and time["at_limit"] is False
    assert found["degrees_of_freedom"] == 5 and found["chi2"] < 0.1 and found["runs"] > 5
    rows = list(csv.DictReader((out / "fit.csv").read_text().splitlines()))
    assert [float(row["time_min"]) for row in rows] == [10, 20, 30, 40, 50, 60]
    for row in rows:
        away = (float(row["measured"]) - float(row["model"])) / float(row["error"])
        assert float(row["standardised_residual"]) == pytest.approx(away)
    assert f"growth.time  {time['value']:.5g} (" in done.stdout and "runs in" in done.stdout


@pytest.mark.process
def test_an_interrupted_fit_resumes_from_its_best_values(folder: Path) -> None:
    out = folder / "out"
    command = ("fit", str(folder / "fit.toml"), "--out", str(out), "--jobs", "1")

    def rows() -> list[str]:
        table = out / "runs.csv"
        return table.read_text().splitlines() if table.exists() else []

    with start(*command, "--bootstrap", "500") as process:
        wait_for(lambda: len(rows()) > 4, process)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == 130 and "rerun with --resume" in errors
    tried = rows()
    done = finish(*command, "--resume")
    assert (done.returncode, done.stderr) == (0, "")
    assert rows()[: len(tried)] == tried
    first, best = (list(csv.DictReader(part)) for part in (rows(), tried))
    chi2 = float(first[len(tried) - 1]["chi2"])
    assert chi2 == pytest.approx(min(float(row["chi2"]) for row in best), rel=1e-6)


def test_bad_input_ends_with_2(folder: Path) -> None:
    (folder / "cell.csv").write_text("time,volume_ratio\n1,2\n")
    for command in ("fit", "design"):
        done = call(command, str(folder / "fit.toml"))
        assert done.exit_code == 2 and "did you mean time_min?" in done.stderr


def test_no_fit_ends_with_4(folder: Path) -> None:
    (folder / "fit.toml").write_text(FIT.replace("20 min", "1 min").replace("90 min", "4 min")
                                     .replace("60 min", "2 min"))  # fmt: skip
    done = call("fit", str(folder / "fit.toml"), "--out", str(folder / "out"), "--jobs", "1")
    assert done.exit_code == 4 and "no fit found" in done.stderr


def test_a_design_shows_expected_intervals(folder: Path) -> None:
    done = call("design", str(folder / "fit.toml"))
    assert done.exit_code == 0 and "growth.time  60 (" in done.stdout
    low, high = re.findall(r"\((\S+) to (\S+) min\)", done.stdout)[0]
    # It is one of the logarithm.
    assert float(low) * float(high) == pytest.approx(60**2, rel=2e-3)
