"""Sweeps over the rows of a table."""

import csv
from pathlib import Path

import pytest
from support import command
from support.scenes import SMALL

from fenics_yeast import Scene, SceneError
from fenics_yeast.studies import CaseRow, is_combined, parse_variation, plan, read_paired

BUD = Scene.from_toml(SMALL)
TABLE = "turgor.pressure,growth.threshold,growth.time\n0.2 MPa,0.9,45 min\n0.25,1000 kPa,1 h\n"


@pytest.fixture
def table(tmp_path):
    def write(text: str):
        path = tmp_path / "cells.csv"
        path.write_text(text)
        return path

    return write


@pytest.mark.parametrize(
    "text",
    [
        TABLE,
        TABLE.replace(",", ";"),
        TABLE.replace(",", "\t"),
        "\ufeff# of cells\n" + TABLE.replace(",", " , ") + "\n\n",
        '"turgor.pressure","growth.threshold",growth.time\n"0.2 MPa",0.9,45\n0.25,1,60\n',
    ],
)
def test_each_row_is_a_case_with_units(table, text):
    cases = plan(BUD, [read_paired(table(text))])
    assert [case.values for case in cases] == [(0.2, 0.9, 45), (0.25, 1, 60)]
    assert cases[1].scene == BUD.with_values(
        {"turgor.pressure": 0.25, "growth.threshold": 1, "growth.time": 60}
    )
    assert cases[0].name == "turgor.pressure=0.2_growth.threshold=0.9_growth.time=45"


def test_rows_are_combined_with_the_values_of_other_options(table):
    cases = plan(BUD, [read_paired(table(TABLE)), parse_variation("wall.thickness=0.1,0.12")])
    assert [case.values for case in cases] == [
        (0.2, 0.9, 45, 0.1), (0.2, 0.9, 45, 0.12), (0.25, 1, 60, 0.1), (0.25, 1, 60, 0.12)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "cells.csv: empty; expected scene keys as headings"),
        ("growth.time\n", "cells.csv: no values below its headings"),
        ("growth.time,\n30,3\n", "cells.csv: column 2 has no heading"),
        ("growth.time,wall.thickness\n30,\n", "line 2: no value for wall.thickness; fill it in"),
        ("growth.time,wall.thickness\n30\n", "line 2: no value for wall.thickness; fill it in"),
        ("growth.time\n30,2\n", "line 2: 2 values for 1 columns"),
        ("growth.tim\n30\n", "cells.csv: line 2: scene: growth.tim = 30: unknown key; did you "
         "mean growth.time?"),
        ("# times\ngrowth.time\n30\n-3\n", "cells.csv: line 4: scene: growth.time = -3: expected"),
        ("growth.time\n30 MPa\n", 'line 2: scene: growth.time = "30 MPa": expected a time'),
        ("growth.time,growth.time\n30,30\n", "growth.time: given twice"),
    ],
)  # fmt: skip
def test_a_table_that_cannot_be_used_is_refused_on_one_line(table, text, said):
    with pytest.raises(SceneError) as refusal:
        plan(BUD, [read_paired(table(text))])
    assert said in str(refusal.value) and "\n" not in str(refusal.value)


def test_other_files_are_refused(tmp_path):
    with pytest.raises(SceneError, match=r"none\.csv: no such file"):
        read_paired(tmp_path / "none.csv")
    (tmp_path / "picture.csv").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(SceneError, match=r"picture\.csv: not UTF-8"):
        read_paired(tmp_path / "picture.csv")
    with pytest.raises(SceneError, match="larger than 10 MB; expected a table of cases"):
        read_paired(Path("/dev/zero"))


def test_the_command_names_what_is_missing(here):
    done = command.call("sweep", "small.toml")
    assert done.exit_code == 2
    assert done.stderr == (
        "error: nothing to vary; give --vary TABLE.KEY=V1,V2,... or --with FILE.csv\n"
    )
    done = command.call("sweep", "small.toml", "--with", "cells.csv")
    assert (done.exit_code, done.stderr) == (2, "error: cells.csv: no such file\n")


@pytest.mark.slow
@pytest.mark.process
def test_a_sweep_over_rows_has_a_table_and_a_figure_and_can_be_continued(here):
    (here / "cells.csv").write_text(TABLE)
    sweep = ("sweep", "small.toml", "--with", "cells.csv", "--out", "sweep", "--set", "run.end=4",
             "--set", "run.save=[4]")  # fmt: skip
    done = command.finish(*sweep)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith("2 cases: 2 finished; see sweep/sweep.csv, sweep/sweep.png\n")
    with open(here / "sweep" / "sweep.csv") as file:
        rows = list(csv.DictReader(file))
    assert [(row["turgor.pressure"], row["growth.time"]) for row in rows] == [
        ("0.2", "45.0"), ("0.25", "60.0")
    ]  # fmt: skip
    assert (here / "sweep" / "sweep.png").read_bytes().startswith(b"\x89PNG")
    (here / "cells.csv").write_text(TABLE + "0.3,1,30\n")
    done = command.finish(*sweep)
    assert done.stdout.startswith("2 of 3 cases have already ended; skipping them\n3/3  ")
    plot = command.finish("plot", "sweep")
    assert (plot.returncode, plot.stdout) == (0, "sweep/sweep.png\n")


@pytest.mark.parametrize(
    ("rows", "combined"),
    [
        ([(1, 5), (1, 6), (2, 5), (2, 6)], True),
        ([(1, 5), (2, 6)], False),
        ([(1, 5, 7), (2, 5, 7)], False),
        ([(1,), (2,)], False),
        ([(1, 5)], False),
    ],
)
def test_all_combinations_of_two_values_and_more_are_told_from_rows(rows, combined):
    cases = [CaseRow(str(values), values, "finished", "") for values in rows]
    assert is_combined(cases) is combined
