"""The imports of a package, read from its source, and the rules that they must keep."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

TYPING, TOP, LATE = "typing", "top", "late"  # under TYPE_CHECKING, at module level, in a function


@dataclass(frozen=True)
class Import:
    """A name that one module of the package takes from another, or a library that it loads."""

    file: str  # with the package's directory as the root: "solve/residual.py"
    line: int
    module: str  # within the package "solve.residual", "" the package itself; a library "scipy"
    name: str  # "" for a library
    when: str
    inside: bool

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: imports {self.name} from {self.module or 'the package'}"


class Package:
    """Modules of a package by dotted name, their imports and the faces of its rooms."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.files = {_dotted(path.relative_to(root)): path for path in sorted(root.rglob("*.py"))}
        self.trees = {name: ast.parse(path.read_text()) for name, path in self.files.items()}
        self.imports = {name: list(self._imports(name)) for name in self.files}

    def file(self, module: str) -> str:
        """Path of a module below the package."""
        return str(self.files[module].relative_to(self.root))

    def is_room(self, module: str) -> bool:
        """Whether a module is a directory's `__init__`."""
        return self.files[module].name == "__init__.py" and module != ""

    def public(self, module: str) -> set[str]:
        """Names in `__all__` of a module."""
        value = _assigned(self.trees[module], "__all__")
        return set(ast.literal_eval(value)) if value is not None else set()

    def late(self, module: str) -> dict[str, str]:
        """Names that a face imports when first used, and the modules that hold them."""
        value = _assigned(self.trees[module], "_LATE")
        table = ast.literal_eval(value) if value is not None else {}
        return {name: _resolved(module, f".{file}") for name, file in table.items()}

    def target(self, found: Import) -> str:
        """Module that an import within the package loads, also where a face gives a name late."""
        below = f"{found.module}.{found.name}".strip(".")
        if below in self.files or found.module not in self.files:
            return below
        return self.late(found.module).get(found.name, found.module)

    def _imports(self, module: str) -> Iterator[Import]:
        file = self.file(module)
        for node, when in _walk(self.trees[module].body, TOP):
            if isinstance(node, ast.Import):
                for alias in node.names:
                    inside = alias.name.split(".")[0] == self.root.name
                    name = alias.name.partition(".")[2] if inside else alias.name
                    yield Import(file, node.lineno, name, "", when, inside)
            elif isinstance(node, ast.ImportFrom):
                absolute = not node.level and (node.module or "").split(".")[0] == self.root.name
                if node.level:
                    folder = module if self.files[module].name == "__init__.py" else _above(module)
                    base = _resolved(folder, "." * node.level + (node.module or ""))
                else:
                    base = (node.module or "").partition(".")[2] if absolute else node.module or ""
                inside = bool(node.level) or absolute
                for alias in node.names:
                    yield Import(file, node.lineno, base, alias.name, when, inside)
        for name, target in self.late(module).items():
            yield Import(file, 1, target, name, LATE, True)


def _dotted(path: Path) -> str:
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _above(module: str) -> str:
    return module.rpartition(".")[0]


def _resolved(folder: str, name: str) -> str:
    """Module that a relative name means in a folder: `.a` is in it, `..a` beside it."""
    rest = name.lstrip(".")
    for _ in range(len(name) - len(rest) - 1):
        folder = _above(folder)
    return f"{folder}.{rest}".strip(".")


def _assigned(tree: ast.Module, name: str) -> ast.expr | None:
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == name:
            return node.value
    return None


def _walk(body: list[ast.stmt], when: str) -> Iterator[tuple[ast.AST, str]]:
    for node in body:
        yield node, when
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            yield from _walk(node.body, TYPING)
            yield from _walk(node.orelse, when)
            continue
        inner = LATE if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) else when
        for field in ("body", "orelse", "finalbody"):
            yield from _walk(getattr(node, field, []), inner)
        for part in (*getattr(node, "handlers", []), *getattr(node, "cases", [])):
            yield from _walk(part.body, inner)


# Rules ----------------------------------------------------------------------------------------


def room(module: str) -> str:
    """First part of a dotted name: the room of a module, or a module beside the rooms."""
    return module.split(".")[0]


def backwards(package: Package, order: tuple[str, ...], apart: set[tuple[str, str]]) -> list[str]:
    """Imports from a room to the right, and from one that another must not know (`apart`)."""
    place = {name: i for i, name in enumerate(order)}
    found = [f"{name or '__init__'}: not in the order" for name in _rooms(package) - place.keys()]
    for module, imports in package.imports.items():
        for one in imports:
            here, there = room(module), room(package.target(one)) if one.inside else ""
            if not one.inside or not {here, there} <= place.keys():
                continue
            if place[here] < place[there] or (here, there) in apart:
                found.append(str(one))
    return found


def past_the_face(package: Package) -> list[str]:
    """Imports from within another room, or of a name that its face does not list."""
    found = []
    for module, imports in package.imports.items():
        for one in imports:
            owner = room(package.target(one)) if one.inside else ""
            if owner in package.files and package.is_room(owner) and owner != room(module):
                whole = one.module == "" and one.name == owner  # `from . import simulation`
                if not whole and (one.module != owner or one.name not in package.public(owner)):
                    found.append(str(one))
    return found


def circles(package: Package) -> list[str]:
    """Chains of imports from a file to itself, late ones and those for types included."""
    graph = {
        module: sorted({package.target(one) for one in imports if one.inside} - {module})
        for module, imports in package.imports.items()
    }
    found, done = [], set()

    def follow(module: str, chain: tuple[str, ...]) -> None:
        if module in chain:
            found.append(" -> ".join((*chain[chain.index(module) :], module)))
        elif module not in done:
            for other in graph.get(module, ()):
                follow(other, (*chain, module))
            done.add(module)

    for module in graph:
        follow(module, ())
    return found


def heavy_at_start(package: Package, light: tuple[str, ...], heavy: set[str]) -> list[str]:
    """Libraries that modules load when they are imported, through whichever of the others."""
    found = []
    for start in light:
        before: dict[str, str] = {start: package.file(start)}
        open_ = [start]
        while open_:
            module = open_.pop()
            for one in package.imports[module]:
                if one.when == TOP and not one.inside and room(one.module) in heavy:
                    found.append(f"{before[module]}:{one.line}: loads {one.module}")
                elif one.when == TOP and one.inside:
                    target = package.target(one)
                    for loaded in {target, room(target)} & package.files.keys() - before.keys():
                        before[loaded] = f"{before[module]} -> {package.file(loaded)}"
                        open_.append(loaded)
    return found


def too_long(package: Package, file: int, whole: int) -> list[str]:
    """Files, and the package, of more lines than they may have."""
    lines = {module: path.read_text().count("\n") for module, path in package.files.items()}
    found = [f"{package.file(m)}: {n} lines" for m, n in lines.items() if n > file]
    total = sum(lines.values())
    return found + ([f"{package.root.name}: {total} lines"] if total > whole else [])


def wordy_rooms(package: Package, lines: int) -> list[str]:
    """Rooms whose `__init__` does not say in so many lines what they are for."""
    found = []
    for module in filter(package.is_room, package.files):
        said = [
            line for line in (ast.get_docstring(package.trees[module]) or "").split("\n") if line
        ]
        if not 0 < len(said) <= lines:
            found.append(f"{package.file(module)}: {len(said)} lines of docstring")
    return found


def _rooms(package: Package) -> set[str]:
    return {room(module) for module in package.files}
