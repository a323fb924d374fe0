"""Files of fits and measured curves: what is read, and what is wrong with them."""

from pathlib import Path

import pytest

from fenics_yeast import MeasuredCurve, Scene, SceneError
from fenics_yeast.scene import FitProblem

BUD = """
cell = { shape = "sphere", diameter = 5 }
wall = { thickness = 0.1, shear_modulus = 40 }
turgor = { pressure = 0.2 }
growth = { zone = { pole = "top", half_angle = 24 }, threshold = 1, time = 45 }
run = { end = 40 }
"""
FIT = """
scene = "bud.toml"
vary = ["growth.threshold", "growth.time"]
[[curve]]
file = "cell.csv"
noise = 0.01
"""
CELL = "time_min,volume_ratio\n5,1.05\n10,1.06\n20,1.07\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in (("bud.toml", BUD), ("fit.toml", FIT), ("cell.csv", CELL)):
        (tmp_path / name).write_text(text)
    return tmp_path


def load(folder: Path, old: str = "", new: str = "") -> FitProblem:
    """Load the fit with some of its text replaced."""
    assert old in FIT
    (folder / "fit.toml").write_text(FIT.replace(old, new))
    return FitProblem.load(folder / "fit.toml")


def test_a_fit_starts_from_the_values_of_its_scene(folder: Path) -> None:
    problem = load(folder)
    assert [(one.key, one.start, one.unit) for one in problem.varied] == [
        ("growth.threshold", 1.0, "MPa"),
        ("growth.time", 45.0, "min"),
    ]
    (curve,) = problem.curves
    assert curve.values == [1.05, 1.06, 1.07] and curve.relative_errors == [0.01] * 3


def test_limits_have_units(folder: Path) -> None:
    limits = '[vary."growth.time"]\nfrom = "0.5 h"\nto = "3600 s"\nstart = 40\n'
    table = limits + '[vary."growth.threshold"]'
    (time, threshold) = load(folder, 'vary = ["growth.threshold", "growth.time"]', table).varied
    assert (time.low, time.start, time.high) == (30, 40, 60)
    assert threshold.low < threshold.start == 1 < threshold.high


def test_errors_of_each_value_replace_the_noise(folder: Path) -> None:
    (folder / "cell.csv").write_text("time_min,length_um,error\n5,5.1,0.02\n10,5.2,0.03\n")
    (curve,) = load(folder).curves
    assert curve.relative_errors == [0.02, 0.03] and curve.column == "pole_height_um"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("vary", "vari", r"unknown key; did you mean vary\?"),
        ("noise", "nois", r"curve\[0\].nois = 0.01: unknown key; did you mean curve\[0\].noise\?"),
        ("growth.time", "growth.tim", r"vary.growth.tim: unknown key; did you mean growth.time\?"),
        ("growth.time", "wall.bending", "expected the key of a number that can vary"),
        ("growth.time", "growth.threshold", "a key is given twice"),
        ("noise = 0.01", "", "no noise; set noise, e.g. 0.01"),
        ("noise = 0.01", 'noise = 0.01\noffset = "fre"', r'curve\[0\].offset = "fre"'),
        ("noise = 0.01", "noise = 0.01\noffset = 30", "expected less than the last time, 20 min"),
        ('"cell.csv"', '"sell.csv"', "sell.csv: no such file"),
        ("noise = 0.01", 'noise = 0.01\nset = { "growth.time" = 3 }', "set.growth.time is varied"),
        ("noise = 0.01", 'noise = 0.01\nset = { "turgor.presure" = 3 }', r"turgor.pressure\?"),
        (
            "noise = 0.01",
            'noise = 0.01\nset = { "turgor.pressure" = "3 min" }',
            "expected a pressure or stress",
        ),
        ('["growth.threshold", "growth.time"]', "3", "expected a list of keys"),
        (
            'vary = ["growth.threshold", "growth.time"]',
            '[vary."growth.time"]\nform = 3',
            r"vary.growth.time.form = 3: unknown key; did you mean from\?",
        ),
        (
            'vary = ["growth.threshold", "growth.time"]',
            '[vary."growth.time"]\nfrom = "3 MPa"',
            "growth.time = \"3 MPa\": expected a time",
        ),
        (
            'vary = ["growth.threshold", "growth.time"]',
            '[vary."growth.time"]\nfrom = 50\nto = 40',
            "expected from < to",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_fit_is_said(folder: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        load(folder, old, new)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time_min,volum_ratio\n1,2\n", r"unknown column volum_ratio; did you mean volume_ratio\?"),
        ("time,volume_ratio\n1,2\n", r"unknown column time; did you mean time_min\?"),
        ("time_min,bud_volume_um3\n1,2\n", "bud_volume_um3 is not a result of a run"),
        ("time_min,volume_ratio,length_um\n1,2,3\n", "volume_ratio and length_um: expected one"),
        ("time_min,volume_ratio\n1,one\n", 'row 2: volume_ratio = "one": expected a number'),
        ("time_min,volume_ratio\n1,2,3\n", "row 2: 3 cells; expected 2"),
        ("time_min,volume_ratio\n2,1\n1,1\n", "expected increasing times"),
        ("time_min,volume_ratio\n1,-1\n", "volume_ratio: expected numbers > 0"),
        ("time_min,volume_ratio\n-1,1\n", "negative; set offset"),
        ("time_min,volume_ratio,error\n1,1,7\n", "relative to the values"),
        ("time_min,volume_ratio\n", "no values"),
        ("", "expected the columns time_min and one of volume_um3"),
    ],
)
def test_what_is_wrong_with_a_curve_is_said(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "cell.csv"
    path.write_text(text)
    with pytest.raises(SceneError, match=message):
        MeasuredCurve.read(path, noise=0.01)


def test_a_fit_needs_a_run_and_enough_values() -> None:
    curve = MeasuredCurve("a", "volume_ratio", [5], [1.05], 0.01)
    bud = Scene.from_toml(BUD)
    with pytest.raises(SceneError, match="1 values cannot fix 2 unknowns"):
        FitProblem.of(bud, [curve], ["growth.time", "growth.threshold"])
    still = bud.with_values({"run": None, "growth": None})
    with pytest.raises(SceneError, match="needs a run in time"):
        FitProblem.of(still, [curve], ["wall.thickness"])


def test_a_fit_file_without_end_is_refused() -> None:
    with pytest.raises(SceneError, match="/dev/zero: larger than 10 MB; expected a fit file"):
        FitProblem.load(Path("/dev/zero"))
