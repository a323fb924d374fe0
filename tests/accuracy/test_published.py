"""The benchmarks of `demos/published`: every row of their tables holds, and each has a figure."""

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PUBLISHED = Path(__file__).parents[2] / "demos" / "published"
SHARED = {"benchmark", "solid"}
NAMES = sorted({path.stem for path in PUBLISHED.glob("*.py")} - SHARED)


@pytest.fixture
def published(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Import path of the scripts, as when one of them runs."""
    monkeypatch.syspath_prepend(str(PUBLISHED))
    yield
    for name in {*NAMES, *SHARED}:
        sys.modules.pop(name, None)


@pytest.mark.parametrize("name", NAMES)
def test_published_numbers_are_reproduced(
    name: str, published: None, tmp_path: Path, monkeypatch, capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    script = importlib.import_module(name)
    script.main()  # which checks the rows
    table = capsys.readouterr().out
    assert "published" in table and "outside" not in table, table
    assert len(table.splitlines()) >= 3
    assert (tmp_path / f"out/{name}.png").read_bytes().startswith(b"\x89PNG")
