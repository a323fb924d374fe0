"""Python, commands and scenes in the documents run; files and functions named there exist."""

import ast
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from support.command import COMMAND as PROGRAM

from fenics_yeast import Scene, simulate
from fenics_yeast.simulation import COLUMNS, EXIT_STATUS

TOP = Path(__file__).parents[2]
DOCUMENTS = [*sorted(TOP.glob("*.md")), *sorted((TOP / "docs").glob("*.md"))]
COMMAND = ".venv/bin/fenics-yeast"


def blocks(language: str) -> list[str]:
    """Fenced blocks of a language in all documents."""
    fence = re.compile(rf"^```{language}\n(.*?)^```$", re.M | re.S)
    return [block for path in DOCUMENTS for block in fence.findall(path.read_text())]


def commands() -> list[str]:
    """Indented lines that call the command, joined where a backslash says so."""
    texts = [path.read_text().replace("\\\n", " ") for path in DOCUMENTS]
    lines = [line for text in texts for line in text.splitlines()]
    return [line.strip() for line in lines if line.startswith(f"    {COMMAND} ")]


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A folder that looks like the top of the repository, to be written to."""
    (tmp_path / "demos").symlink_to(TOP / "demos")
    return tmp_path


def run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=240)
    # A run may end at a loss of equilibrium.
    ended = done.returncode == 3 and "no equilibrium" in done.stderr
    assert ended or (done.returncode, done.stderr) == (0, ""), f"{command}: {done.stderr}"


@pytest.mark.process
@pytest.mark.parametrize("number", range(len(blocks("python"))))
def test_python_block(number: int, checkout: Path) -> None:
    run([sys.executable, "-c", blocks("python")[number]], checkout)


@pytest.mark.slow
@pytest.mark.process
def test_commands_in_their_order(checkout: Path) -> None:
    """A command finds what those before it left."""
    assert len(commands()) >= 3
    for call in commands():
        arguments = shlex.split(call, comments=True)[1:]
        run([*PROGRAM, *arguments], checkout)


def test_commands_have_their_path() -> None:
    """Otherwise they would not work as they stand, nor be run here."""
    for path in DOCUMENTS:
        assert not re.search(r"^    (fenics-yeast|python) ", path.read_text(), re.M), path


def is_scene(block: str) -> bool:
    return {"cell", "wall"} <= tomllib.loads(block).keys()


@pytest.mark.parametrize("number", range(len(blocks("toml"))))
def test_toml_block(number: int) -> None:
    """A whole scene is valid; a part of one is TOML."""
    block = blocks("toml")[number]
    if is_scene(block):
        Scene.from_toml(block)


def test_there_is_something_to_run() -> None:
    assert blocks("python")
    assert any(is_scene(block) for block in blocks("toml"))


def test_targets_of_make_exist() -> None:
    makefile = (TOP / "Makefile").read_text()
    targets = {
        target
        for path in DOCUMENTS
        for target in re.findall(r"`make ([a-z0-9-]+)", path.read_text())
    }
    for path in DOCUMENTS:
        targets |= set(re.findall(r"^    make ([a-z0-9-]+)", path.read_text(), re.M))
    assert {"demo", "test"} <= targets
    for target in targets:
        assert re.search(rf"^{target}:", makefile, re.M), target


def test_links_lead_somewhere() -> None:
    for path in DOCUMENTS:
        for link in re.findall(r"\]\(([^)#]+)[^)]*\)", path.read_text()):
            assert link.startswith("https://") or (path.parent / link).exists(), f"{path}: {link}"


def defined_in(path: Path) -> set[str]:
    """Names of functions, classes, methods and constants of a module."""
    names = set()
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            names |= {f"{node.name}.{m.name}" for m in node.body if isinstance(m, ast.FunctionDef)}
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names |= {target.id for target in targets if isinstance(target, ast.Name)}
    return names


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_code_named_in_a_document_exists(path: Path) -> None:
    text = " ".join(path.read_text().split())
    files = re.findall(r"`((?:fenics_yeast|tests|demos)/[\w./]*)(?:::\w+)?`", text)
    for name in files:
        assert (TOP / name).exists(), name
    listed = re.findall(r"`(fenics_yeast/[\w/]+\.py)`: ((?:`[\w.]+`(?:, )?)+)", text)
    for name, functions in listed:
        for function in re.findall(r"`([\w.]+)`", functions):
            assert function in defined_in(TOP / name), f"{name}: {function}"
    if path.name in ("how-a-run-works.md", "model.md"):
        assert len(listed) > 10


def first_cells(path: Path, heading: str) -> list[str]:
    """Names in the first column of the table below a heading."""
    section = path.read_text().split(f"## {heading}\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (`[^|]+) \|", section, re.M)
    return [name for row in rows for name in re.findall(r"`([^`]+)`", row)]


def test_tables_of_outputs_are_those_of_the_code(cell_scene: Scene) -> None:
    page = TOP / "docs" / "outputs.md"
    assert first_cells(page, "Columns of `history.csv`") == list(COLUMNS)
    assert first_cells(page, "How a run ends") == list(EXIT_STATUS)
    static = cell_scene.with_values({"growth": None, "run": None})
    profiles = simulate(static).profiles
    assert set(first_cells(page, "Arrays of `profiles.npz`")) == set(profiles.arrays())


@pytest.mark.process
def test_nothing_else_lies_at_the_top() -> None:
    """What a visitor sees first; a checkout only."""
    if not (TOP / ".git").exists():
        pytest.skip("no checkout")
    done = subprocess.run(["git", "ls-files"], cwd=TOP, capture_output=True, text=True, check=True)
    assert {name.split("/")[0] for name in done.stdout.splitlines()} <= {
        ".ci", ".dockerignore", ".gitignore", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md",
        "LICENSE", "Makefile", "README.md", "demos", "docker", "docs", "fenics_yeast",
        "pyproject.toml", "tests",
    }  # fmt: skip
