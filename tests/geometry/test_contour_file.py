"""Files of contours as other programs write them: read, or refused for what was found."""

import numpy as np
import pytest
from support.shapes import ellipse

from fenics_yeast.geometry import ContourError, read_contour, read_contours, smooth_contour

POINTS = ((0.0, 1.5, 0.0), (-2.0, 0.25, 2.0))


def table(mark: str, heading: tuple[str, str] = ("r", "z"), comma: bool = False) -> str:
    lines = [mark.join(heading), *(f"{r}{mark}{z}" for r, z in zip(*POINTS, strict=True))]
    text = "\n".join(lines) + "\n"
    return text.replace(".", ",") if comma else text


@pytest.mark.parametrize(
    "text",
    [
        table(","), table(";"), table("\t"), table(" "), table("   "), table(", "),
        table(";", comma=True), table("\t", comma=True), table(",", ('"r"', "'z'")),
        table(",", ("r [µm]", "z [µm]")), table(" ", ("r [µm]", "z (um)")),
        table(";", ("R_um", "Z/µm")), table(",").replace("\n", "\r\n"),
        "# by hand\n name , Z, R\na,-2,0\n\nb,0.25,1.5\n c ,2,0\n",
        table(",").replace("1.5", '"1.5"'),
    ],
)  # fmt: skip
def test_tables_of_other_programs_are_read(tmp_path, text):
    path = tmp_path / "contour.csv"
    for encoding in ("utf-8", "utf-8-sig", "latin-1", "utf-16"):
        path.write_bytes(text.encode(encoding))
        assert read_contour(path) == POINTS


def test_units_of_the_heading_and_pixels_are_converted(tmp_path):
    path = tmp_path / "contour.csv"
    path.write_text(table(",", ("r (nm)", "z (nm)")))
    assert read_contour(path)[0] == pytest.approx([1e-3 * r for r in POINTS[0]])
    for heading in (("r", "z"), ("r [px]", "z [pixels]")):
        path.write_text(table(",", heading))
        assert read_contour(path, 0.065)[1] == pytest.approx([0.065 * z for z in POINTS[1]])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "no such file beside the scene"),
        ("", 'has no points; expected the heading "r,z"'),
        ("r,z\n", "has no points"),
        ("x,y\n1,2\n", 'begins with "x,y"; expected the heading "r,z"'),
        ("0,1\n1,2\n", 'begins with "0,1"; expected the heading'),
        ("r,z\n0,1\n0;2\n", 'line 3: found "0;2"; expected a number for r and z'),
        ("r,z\n0,one\n", 'line 2: found "0,one"'),
        ("r,z\n0,nan\n", "line 2: numbers must be finite"),
        ("r [px],z [px]\n0,1\n", "is in pixels; set cell.scale"),
        ("r [mm],z [mm]\n0,1\n", 'has the unit "mm" in its heading; expected µm, nm or px'),
    ],
)
def test_files_that_are_no_contours_are_refused(tmp_path, text, said):
    path = tmp_path / "contour.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(ContourError) as caught:
        read_contour(path)
    assert said in str(caught.value) and len(str(caught.value).splitlines()) == 1


def test_a_scale_is_refused_where_the_heading_has_a_unit(tmp_path):
    path = tmp_path / "contour.csv"
    path.write_text(table(",", ("r [µm]", "z [µm]")))
    with pytest.raises(ContourError, match=r"is in µm, says its heading; remove cell\.scale"):
        read_contour(path, 0.065)


def outline(number: int, axis: float = 0.0, turn: float = 0.0) -> np.ndarray:
    """Both halves of the ellipse, counter-clockwise from its right side."""
    t = np.linspace(0, 2 * np.pi, number)
    r, z = 2.0 * np.cos(t), 3.5 * np.sin(t)
    return np.column_stack(
        [axis + r * np.cos(turn) - z * np.sin(turn), r * np.sin(turn) + z * np.cos(turn)]
    )


def write(path, points):
    np.savetxt(path, points, delimiter=",", header="r,z", comments="", fmt="%.10f")


@pytest.mark.parametrize("axis", [0.0, 12.3])
@pytest.mark.parametrize("end", [None, -1])
def test_a_closed_outline_is_folded_about_its_axis(tmp_path, axis, end):
    """Wherever it begins, in either direction, with its first point repeated or not."""
    for points in (outline(201, axis), np.roll(outline(201, axis)[:-1], 60, axis=0)[::-1]):
        path = tmp_path / "contour.csv"
        write(path, points[:end])
        r, z = map(np.array, read_contour(path))
        assert (r[0], r[-1]) == (0, 0) and z[0] < z[-1]
        assert r.min() >= 0
        np.testing.assert_allclose((r / 2) ** 2 + (z / 3.5) ** 2, 1, atol=1e-5)


@pytest.mark.parametrize("number", [61, 121])
def test_a_folded_outline_keeps_its_volume(tmp_path, number):
    """Although chords of so few points leave out up to 3e-3 of it; its pole is given twice."""
    path = tmp_path / "contour.csv"
    write(path, np.roll(outline(number)[:-1], number // 4, axis=0)[[*range(number - 1), 0]])
    r, z = map(tuple, read_contour(path))
    curve = smooth_contour(r, z)
    t = np.linspace(0, curve.end, 4001)
    (radius, _), (_, slope) = curve.point(t, 0), curve.point(t, 1)
    volume = np.pi * (radius**2 * slope)[:-1].sum() * curve.end / 4000
    assert volume == pytest.approx(4 / 3 * np.pi * 2**2 * 3.5, rel=2e-6)


def test_an_outline_that_is_not_upright_is_refused(tmp_path):
    path = tmp_path / "contour.csv"
    write(path, outline(201, turn=0.5))
    with pytest.raises(ContourError, match=r"halves are up to .* apart; rotate it"):
        read_contour(path)


def test_half_a_contour_stays_as_it_is(tmp_path):
    path = tmp_path / "contour.csv"
    points = np.column_stack(ellipse(60))
    write(path, points)
    np.testing.assert_allclose(np.column_stack(read_contour(path)), points, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "per_minute"), [("time", 1), ("time_min", 1), ("t [min]", 1), ("t (h)", 1 / 60),
                             ("time_s", 60)]
)  # fmt: skip
def test_contours_of_several_times_are_read_from_one_table(tmp_path, name, per_minute):
    path = tmp_path / "contours.csv"
    times = [30.0, 0.0]
    points = [np.column_stack(ellipse(40, 2 + time / 100)) for time in times]
    rows = [(time * per_minute, *row) for time, each in zip(times, points, strict=True)
            for row in each]  # fmt: skip
    np.savetxt(path, rows, delimiter=";", header=f"{name};r;z", comments="", fmt="%.10f")
    found = read_contours(path)
    assert [contour.time for contour in found] == pytest.approx([0, 30])
    for contour, each in zip(found, points[::-1], strict=True):
        np.testing.assert_allclose(np.column_stack(contour[:2]), each, atol=1e-9)


def test_a_table_without_times_is_one_contour_of_unknown_time(tmp_path):
    path = tmp_path / "contour.csv"
    write(path, np.column_stack(ellipse(60)))
    (found,) = read_contours(path)
    assert found == (*read_contour(path), None)


def test_a_time_that_is_no_number_is_refused(tmp_path):
    path = tmp_path / "contours.csv"
    path.write_text("t,r,z\n0,1,2\nlate,1,2\n")
    with pytest.raises(ContourError, match=r"line 3: .* expected a number for r, z and time"):
        read_contours(path)
