"""Messages, docstrings and comments of the package keep to its glossary."""

from pathlib import Path

import pytest
from support.messages import ROOT, capitals, faults, words


def test_the_package_uses_no_phrase_that_the_glossary_replaces() -> None:
    assert faults(ROOT) == []


def test_messages_of_errors_start_with_a_small_letter() -> None:
    assert capitals(ROOT) == []


def test_messages_are_listed_with_their_places() -> None:
    messages = {text: place for place, kind, text in words(ROOT) if kind == "message"}
    assert len(messages) > 300
    (place,) = (place for text, place in messages.items() if "sudo apt install gcc" in text)
    assert place.startswith("fenics_yeast/_form_cache.py:")


@pytest.fixture
def package(tmp_path: Path) -> Path:
    root = tmp_path / "small"
    root.mkdir()
    return root


SOURCE = '''\
"""The first line."""


def f(x: int) -> None:
    """Of a function."""
    if x > 3:  # too many, by far
        raise ValueError(f"{x} is too many, {'far too' if x > 9 else 'a bit'} many; " + "try 3")
    print("all", "is well", x)
'''


def test_every_text_is_found(package: Path) -> None:
    (package / "a.py").write_text(SOURCE)
    assert {tuple(one) for one in words(package)} == {
        ("small/a.py:1", "docstring", "The first line."),
        ("small/a.py:5", "docstring", "Of a function."),
        ("small/a.py:6", "comment", "too many, by far"),
        ("small/a.py:7", "message",
         "{x} is too many, {'far too' if x > 9 else 'a bit'} many; try 3"),
        ("small/a.py:7", "message", "far too"),
        ("small/a.py:7", "message", "a bit"),
        ("small/a.py:8", "message", "is well"),
    }  # fmt: skip


@pytest.mark.parametrize(
    "text",
    [
        "raise ValueError('a closed cell is wanted')",
        "raise ValueError(f'{x}: a closed cell ' + 'is wanted')",
        "def f():\n    '''Told in one\n    line.'''",
        "def f():\n    '''Is told in\n    one line.'''",
        "x = 1  # on rank 0 alone",
        "print('the wall bears no more')",
        "print('the wall gives way')",
        "print('the run goes on from 40 min')",
        "print('a plot draws what lacks')",
        "print('steps were cut, for they were long')",
        "print('a whole number')",
        "print('3 thickness points')",
        "print('it is compiled anew')",
        "print('a disc is none')",
        "print('0.1 (as it comes)')",
    ],
)
def test_a_forbidden_phrase_is_found(package: Path, text: str) -> None:
    (package / "a.py").write_text(text)
    (found,) = faults(package)
    assert found.startswith("small/a.py:")


@pytest.mark.parametrize(
    "text",
    [
        "print('two versions are told apart')",
        "print('a wall stands alone')",
        "print('standalone, anewest, unwanted, forbearing')",
        "print('what goes on the axis')",
        "print('if there is none, the value is None')",
        "x = tell(alone=3)",
        "print('the step size was reduced')",
    ],
)
def test_right_uses_pass(package: Path, text: str) -> None:
    (package / "a.py").write_text(text)
    assert faults(package) == []


def test_a_capital_at_the_start_of_a_message_is_found(package: Path) -> None:
    (package / "a.py").write_text(
        "raise ValueError('Something is wrong')\nraise ValueError('MPI is missing')\n"
        "raise ValueError(f'{x} is wrong')\nraise KeyError\n"
    )
    assert capitals(package) == ["small/a.py:1: Something is wrong"]
