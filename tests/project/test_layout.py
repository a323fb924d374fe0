"""The rooms of the package: their order, their faces, their size; read from the source."""

from pathlib import Path

import pytest
from support.imports import (
    Package,
    backwards,
    circles,
    heavy_at_start,
    past_the_face,
    too_long,
    wordy_rooms,
)

ROOT = Path(__file__).parents[2] / "fenics_yeast"
# Each imports only from those before it; "" is the package itself, with its public names.
ORDER = (
    "geometry", "scene", "_form_cache", "_mpi", "_dolfinx", "mechanics", "solve", "simulation",
    "output", "figures", "studies", "", "command", "__main__",
)  # fmt: skip
# What a room must not know although it comes before.
APART = {
    (room, other)
    for room, others in {
        "_form_cache": ("geometry", "scene"),
        "_mpi": ("geometry", "scene"),
        "_dolfinx": ("scene",),
        "mechanics": ("scene",),
        "solve": ("scene",),
    }.items()
    for other in others
}
HEAVY = {
    "basix", "dolfinx", "ffcx", "matplotlib", "meshio", "mpi4py", "pandas", "petsc4py", "pint",
    "PIL", "rich", "scipy", "ufl", "vtk",
}  # fmt: skip
# What starts quickly: a command loads the rest when it needs it.
LIGHT = ("", "geometry", "scene", "simulation", "output", "figures", "studies", "command.main")


@pytest.fixture(scope="module")
def package() -> Package:
    return Package(ROOT)


def test_rooms_import_only_from_rooms_to_their_left(package: Package) -> None:
    """Late imports, those for types and the tables of late names included."""
    assert backwards(package, ORDER, APART) == []


def test_rooms_import_only_what_the_face_of_another_lists(package: Package) -> None:
    found = past_the_face(package)
    assert [one for one in found if not one.startswith("__main__.py")] == []


def test_no_file_imports_itself_by_way_of_others(package: Package) -> None:
    assert circles(package) == []


def test_rooms_load_no_heavy_library_when_they_are_imported(package: Package) -> None:
    assert heavy_at_start(package, LIGHT, HEAVY) == []


def test_no_file_has_more_than_350_lines(package: Package) -> None:
    assert too_long(package, 350, 10**6) == []


def test_the_package_does_not_grow(package: Package) -> None:
    assert too_long(package, 10**6, 22_100) == []


def test_every_room_says_in_three_lines_what_it_is_for(package: Package) -> None:
    assert wordy_rooms(package, 3) == []


def test_no_room_hides_the_function_simulate(package: Package) -> None:
    assert "simulate" not in {name for module in package.files for name in module.split(".")}
    assert not list(ROOT.rglob("simulate"))


# That each rule can fail ----------------------------------------------------------------------

SMALL = ("first", "second", "third")


def made(root: Path, **files: str) -> Package:
    """A package of three rooms; `second__a` is the file a of the second, `second` its face."""
    texts = dict.fromkeys(("", *SMALL), '"""A room."""\n') | files
    for name, text in texts.items():
        path = root.joinpath("small", *name.split("__"))
        path = path / "__init__.py" if name in ("", *SMALL) else path.with_suffix(".py")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return Package(root / "small")


LATE_FACE = """
__all__ = ["slow"]
_LATE = {"slow": "a"}
"""


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("from ..first import x", False),
        ("from ..third import x", True),
        ("from .. import third", True),
        ("from ..third.a import x", True),
        ("from small.third import x", True),
        ("import small.third.a", True),
        ("def f():\n    from ..third import x", True),
        ("if TYPE_CHECKING:\n    from ..third import x", True),
        ("try:\n    pass\nexcept ImportError:\n    from ..third import x", True),
        ("class A:\n    def f(self):\n        with b:\n            from ..third import x", True),
        ("import third", False),
    ],
)
def test_an_import_from_the_right_is_found(tmp_path: Path, text: str, wrong: bool) -> None:
    package = made(tmp_path, second__a=text, third__a="")
    assert bool(backwards(package, ("", *SMALL), set())) is wrong


def test_a_late_name_that_a_face_takes_from_the_right_is_found(tmp_path: Path) -> None:
    package = made(tmp_path, second='_LATE = {"x": ".third.a"}', third__a="")
    assert backwards(package, ("", *SMALL), set()) == [
        "second/__init__.py:1: imports x from third.a"
    ]


def test_rooms_that_must_not_know_each_other_are_found(tmp_path: Path) -> None:
    package = made(tmp_path, third__a="from ..first import x")
    assert backwards(package, ("", *SMALL), set()) == []
    assert backwards(package, ("", *SMALL), {("third", "first")}) == [
        "third/a.py:1: imports x from first"
    ]


def test_a_room_without_a_place_is_found(tmp_path: Path) -> None:
    assert backwards(made(tmp_path), ("", "first", "second"), set()) == ["third: not in the order"]


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("from ..second import slow", False),
        ("from ..second import other", True),
        ("from ..second import a", True),
        ("from ..second.a import slow", True),
        ("def f():\n    from ..second.a import slow", True),
        ("from .b import anything", False),
    ],
)
def test_an_import_past_a_face_is_found(tmp_path: Path, text: str, wrong: bool) -> None:
    package = made(tmp_path, second=LATE_FACE, second__a="", third__a=text, third__b="")
    assert bool(past_the_face(package)) is wrong


@pytest.mark.parametrize(
    ("back", "circle"),
    [
        ("", []),
        ("from .a import x", ["second.a -> second.b -> second.a"]),
        ("def f():\n    from .a import x", ["second.a -> second.b -> second.a"]),
        ("from . import slow", ["second.a -> second.b -> second.a"]),
        ("from ..third import x", ["second.a -> second.b -> third -> third.c -> second.a"]),
    ],
)
def test_a_circle_is_found(tmp_path: Path, back: str, circle: list[str]) -> None:
    package = made(
        tmp_path, second=LATE_FACE, second__a="from . import b", second__b=back,
        third="from .c import x", third__c="from ..second import slow",
    )  # fmt: skip
    assert circles(package) == circle


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("import scipy.special", True),
        ("from scipy import special", True),
        ("if True:\n    import scipy", True),
        ("from ..second import quick", True),  # whose file loads it
        ("from ..second import slow", False),
        ("def f():\n    import scipy", False),
        ("if TYPE_CHECKING:\n    import scipy", False),
    ],
)
def test_a_heavy_library_is_found(tmp_path: Path, text: str, wrong: bool) -> None:
    second = "from .b import quick\n" if "quick" in text else ""
    package = made(tmp_path, second=second, second__b="import scipy", third="from .a import x",
                   third__a=text)  # fmt: skip
    assert bool(heavy_at_start(package, ("third",), {"scipy"})) is wrong


def test_length_is_counted(tmp_path: Path) -> None:
    package = made(tmp_path, third__a="\n" * 10)
    assert too_long(package, 10, 14) == []
    assert too_long(package, 9, 13) == ["third/a.py: 10 lines", "small: 14 lines"]


def test_a_room_that_says_nothing_or_too_much_is_found(tmp_path: Path) -> None:
    package = made(tmp_path, first='"""One.\n\nTwo.\nThree.\n"""', second='"""1\n2\n3\n4"""',
                   third="")  # fmt: skip
    assert wordy_rooms(package, 3) == [
        "second/__init__.py: 4 lines of docstring", "third/__init__.py: 0 lines of docstring"
    ]  # fmt: skip
