"""The words of the package: what it can print or raise, its docstrings and its comments.

`python tests/support/messages.py` prints every message with its place, for somebody to read.
"""

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2] / "fenics_yeast"
# Phrases that read as if translated or for which the glossary has a term, and what to write. Right
# uses pass: versions are told apart, a wall stands alone, there is none, a label goes on the axis.
FORBIDDEN = {
    r"(tell|tells|told|telling)(?! apart)": "report, say, state; or leave it out",
    r"(is|are|was|were|be) wanted": "must be, expected",
    r"(?<!stands )(?<!stand )(?<!leave )(?<!let )alone": "only, before the noun",
    r"(bears?|bearing|bore|borne)": "carry",
    r"anew": "again, from scratch",
    r"(gives?|gave|giving|given) way": "cannot carry, deforms",
    r"(go|goes|going|went|gone) on(?! (the|a|an|each|every|top|rank|one)\b)": "continue, resume",
    r"(take|takes|taken|took|taking) up": "resume",
    r"(begin|begins|begun|began) again": "restart, reset",
    r"what (lacks|is lacking)": "missing",
    r"as (it|they) comes?": "default",
    r"mended": "fixed",
    r"(cut|cuts|cutting) (a |an |the |its |their |of )?steps?": "reduce the step size",
    r"steps? (is|are|was|were|be) cut": "reduce the step size",
    r"(held|holds?) against": "compare with",
    r"half spheres?": "hemisphere",
    r"whole numbers?": "integer",
    r"thickness points?": "through-thickness integration point",
    r"(from (the )?(inside|outside)) pressure|pressure from (the )?(inside|outside)": "internal",
    r"in a word": "(leave it out)",
    r"(?<!there )(is|are) (?-i:none)": "is not a",  # None is a value
    r"(is|are|of) no (matter|use)": "has no effect",
    r"left out,": "by default,",
    r"hears? of": "is called with",
}
_PATTERNS = [
    (re.compile(rf"\b(?:{text})(?!\w)", re.IGNORECASE), better)
    for text, better in FORBIDDEN.items()
]


class Words(NamedTuple):
    """A text in the source."""

    place: str
    kind: str  # "message", "docstring", "comment"
    text: str


def words(root: Path) -> Iterator[Words]:
    """Docstrings, comments, and every string of more than a word: a message or a part of one."""
    for path in sorted(root.rglob("*.py")):
        source = path.read_text()
        tree = ast.parse(source)
        docs = set(map(id, _docstrings(tree)))
        place = str(path.relative_to(root.parent))
        for node, text in _strings(tree):
            kind = "docstring" if id(node) in docs else "message"
            if kind == "docstring" or " " in text.strip():
                yield Words(f"{place}:{node.lineno}", kind, text)
        for token in tokenize.generate_tokens(io.StringIO(source).readline):
            if token.type == tokenize.COMMENT:
                yield Words(f"{place}:{token.start[0]}", "comment", token.string.lstrip("# "))


def faults(root: Path) -> list[str]:
    """Forbidden phrases with their places, and what to write instead."""
    found = []
    for place, kind, text in words(root):
        flat = re.sub(r"\s+", " ", text)
        for pattern, better in _PATTERNS:
            for match in pattern.finditer(flat):
                around = flat[max(0, match.start() - 30) : match.end() + 30]
                found.append(f"{place}: {kind}: …{around}… ({match[0]!r}: {better})")
    return found


def capitals(root: Path) -> list[str]:
    """Messages of errors that start with a capital: they follow `error: ` or a file's name."""
    found = []
    for path in sorted(root.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and node.exc.args:
                text = _text(node.exc.args[0]) or ""
                if re.match(r"[A-Z][a-z]+ [a-z]", text):
                    found.append(f"{path.relative_to(root.parent)}:{node.lineno}: {text}")
    return found


def _docstrings(tree: ast.Module) -> Iterator[ast.AST]:
    """Strings that stand as statements: docstrings, of attributes too."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            yield node.value


def _strings(node: ast.AST) -> Iterator[tuple[ast.expr, str]]:
    """Texts in a tree; those that are joined with `+` are one."""
    text = _text(node)
    if text is not None and isinstance(node, ast.expr):
        yield node, text
        for part in ast.walk(node):
            if isinstance(part, ast.FormattedValue):
                yield from _strings(part.value)
        return
    for child in ast.iter_child_nodes(node):
        yield from _strings(child)


def _text(node: ast.AST) -> str | None:
    """A string expression with `{...}` for what is filled in, None if it is none."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(
            _text(part) or (f"{{{ast.unparse(part.value)}}}" if hasattr(part, "value") else "")
            for part in node.values
        )
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        left, right = _text(node.left), _text(node.right)
        if left is not None and right is not None:
            return left + right
    return None


if __name__ == "__main__":
    for place, kind, text in words(ROOT):
        if kind == "message":
            print(f"{place}: {' '.join(text.split())}")
    for line in faults(ROOT) + capitals(ROOT):
        print(line, file=sys.stderr)
