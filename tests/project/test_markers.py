"""Tests that start processes are marked, so that the others can run quickly by themselves."""

import ast
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
STARTERS = {"subprocess.run", "subprocess.Popen", "command.start", "command.finish"}


def references(node: ast.AST) -> set[str]:
    """Names that a function mentions, fixtures among its parameters included."""
    found = {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
    found |= {part.arg for part in ast.walk(node) if isinstance(part, ast.arg)}
    return found | {ast.unparse(part) for part in ast.walk(node) if isinstance(part, ast.Attribute)}


def unmarked(source: str) -> list[str]:
    """Tests of a module that start a process without the marker `process`."""
    tree = ast.parse(source)
    starters = STARTERS | {
        alias.asname or alias.name
        for node in tree.body
        if isinstance(node, ast.ImportFrom) and node.module == "support.command"
        for alias in node.names
        if alias.name in ("start", "finish")
    }
    defined = {
        node.name: node for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef)
    }

    def starts(name: str, seen: frozenset[str] = frozenset()) -> bool:
        named = references(defined[name])
        inner = (named & defined.keys()) - seen - {name}
        return bool(named & starters) or any(starts(one, seen | {name}) for one in inner)

    def marks(nodes: list[ast.expr]) -> bool:
        return any("mark.process" in ast.unparse(node) for node in nodes)

    if any(isinstance(n, ast.Assign) and "pytestmark" in ast.unparse(n) and marks([n.value])
           for n in tree.body):  # fmt: skip
        return []
    return [
        name
        for name, node in defined.items()
        if name.startswith("test_") and starts(name)
        if isinstance(node, ast.FunctionDef) and not marks(node.decorator_list)
    ]


@pytest.mark.parametrize("path", sorted(TESTS.rglob("test_*.py")), ids=lambda path: path.stem)
def test_tests_that_start_a_process_are_marked(path: Path) -> None:
    assert unmarked(path.read_text()) == []


MODULE = """
from support.command import finish
{}
def helper(): return finish("run")
@pytest.fixture
def run(): return helper
@pytest.mark.parametrize("x", [1])
{}
def test_it(x, run): run()
def test_other(): pass
"""


@pytest.mark.parametrize(
    ("module", "function", "found"),
    [
        ("", "", ["test_it"]),
        ("", "@pytest.mark.process", []),
        ("pytestmark = pytest.mark.process", "", []),
    ],
)
def test_a_process_without_its_marker_is_found(module: str, function: str, found: list) -> None:
    assert unmarked(MODULE.format(module, function)) == found
