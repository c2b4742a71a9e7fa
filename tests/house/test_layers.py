"""Which package of the host may import which: downwards and in no circle, lazy and type-only imports included."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator

import pytest

from tests.paths import HOST

LAYERS = (
    (
        "angles",
        "arrays",
        "config",
        "crash",
        "errors",
        "file_hash",
        "file_lock",
        "json_values",
        "notices",
        "output_files",
        "protocol",
        "quantity",
        "units",
        "whole_file",
    ),
    ("robot", "maneuver", "servo_settings", "sdlog"),
    ("dynamics",),
    ("calibration", "design", "devices", "emulated", "flashing", "plan"),
    ("evaluation",),
    ("present", "report"),
    ("preflight", "record", "run"),
    ("rehearsal",),
    ("cli",),
)
LEVEL = {package: level for level, packages in enumerate(LAYERS) for package in packages}


def _imports(top: str = "") -> dict[tuple[str, str], set[str]]:
    """The files behind each arrow between two rooms of a package: its folders, and its own modules."""
    package = ".".join(filter(None, ("tfsat_host", top)))
    folder = HOST / top
    rooms = {path.stem for path in folder.glob("*.py")} | {path.parent.name for path in folder.glob("*/*.py")}
    arrows: dict[tuple[str, str], set[str]] = defaultdict(set)
    for path in folder.rglob("*.py"):
        inside = path.relative_to(folder).with_suffix("").parts
        for name in _names(ast.parse(path.read_text(encoding="utf-8"))):
            room = name.removeprefix(f"{package}.").partition(".")[0]
            if (
                name.startswith(f"{package}.")
                and room in rooms - {inside[0]}
                and not inside[0].startswith("__")
            ):
                arrows[inside[0], room].add("/".join(inside))
    return arrows


def _names(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("tfsat_host"):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.startswith("tfsat_host."))


def test_every_package_has_its_layer() -> None:
    there = {path.stem for path in HOST.glob("*.py")} | {
        path.parent.name for path in HOST.glob("*/__init__.py")
    }
    assert {name for name in there if not name.startswith("__")} == LEVEL.keys()


def test_no_package_imports_one_above_it() -> None:
    upwards = {arrow: files for arrow, files in _imports().items() if LEVEL[arrow[1]] > LEVEL[arrow[0]]}
    assert upwards == {}


def test_no_two_packages_of_a_layer_import_each_other() -> None:
    arrows = _imports()
    assert [arrow for arrow in arrows if arrow[::-1] in arrows and LEVEL[arrow[0]] == LEVEL[arrow[1]]] == []


@pytest.mark.parametrize("package", ["calibration", "dynamics", "evaluation", "plan", "run", "report"])
def test_rooms_of_a_package_import_each_other_in_no_circle(package: str) -> None:
    arrows = _imports(package)
    assert arrows
    left = {room for arrow in arrows for room in arrow}
    while free := {
        room for room in left if not any(arrow[0] == room and arrow[1] in left for arrow in arrows)
    }:
        left -= free
    assert {arrow: files for arrow, files in arrows.items() if set(arrow) <= left} == {}
