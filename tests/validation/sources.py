"""What a proof is of: a hash over the code that its campaign runs; comments and docstrings do not count."""

from __future__ import annotations

import ast
import hashlib
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from tests.paths import REPOSITORY

_PYTHON_ROOTS = ("", "host", "tools")
_NATIVE = ("firmware", "tools/emulator/src")
_C_COMMENT_OR_TEXT = re.compile(r'"(?:\\.|[^"\\\n])*"|//[^\n]*|/\*.*?\*/', re.DOTALL)


def code_sha256(module: str, root: Path = REPOSITORY) -> str:
    """Return the SHA-256 of a module's code, of all that it imports here and of the emulated robot.

    Lazy imports count too; the emulated robot counts with its sources and data.

    Args:
        module: Dotted name of the campaign that computes the numbers, not of the page that renders them.
        root: The repository.
    """
    digest = hashlib.sha256()
    for path in sorted(_imported_paths(module, root)):
        digest.update(f"{path.relative_to(root).as_posix()}\0{_bare_python(path)}\0".encode())
    for path in _native(root):
        digest.update(f"{path.relative_to(root).as_posix()}\0{_bare(path)}\0".encode())
    return digest.hexdigest()


def _imported_paths(module: str, root: Path) -> set[Path]:
    imported_paths: set[Path] = set()
    names = [module]
    while names:
        for path in set(_files(names.pop(), root)) - imported_paths:
            imported_paths.add(path)
            names += _imports(ast.parse(path.read_text(encoding="utf-8")))
    return imported_paths


def _files(name: str, root: Path) -> Iterator[Path]:
    """Yield the file of a dotted name, or of the module that contains it, and its packages' own files."""
    parts = name.split(".")
    for end in range(1, len(parts) + 1):
        place = Path(*parts[:end])
        for folder in _PYTHON_ROOTS:
            for path in (root / folder / place.with_suffix(".py"), root / folder / place / "__init__.py"):
                if path.is_file():
                    yield path


def _imports(tree: ast.AST) -> list[str]:
    names: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            names += (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            names += (alias.name for alias in node.names)
    return names


def _bare_python(path: Path) -> str:
    """Return the syntax tree without docstrings of modules, classes, functions and attributes."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            body[:] = [statement for statement in body if not _is_text(statement)]
    return ast.dump(tree)


def _is_text(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def _native(root: Path) -> Iterable[Path]:
    sources = (
        path
        for folder in _NATIVE
        for path in (root / folder).rglob("*")
        if path.suffix in (".cpp", ".h", ".ino")
    )
    return sorted([*sources, *(root / "robots").glob("*.toml")])


def _bare(path: Path) -> str:
    """C++ without comments and layout; other files as they stand."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".toml":
        return text
    return " ".join(
        _C_COMMENT_OR_TEXT.sub(lambda match: match[0] if match[0][0] == '"' else " ", text).split()
    )
