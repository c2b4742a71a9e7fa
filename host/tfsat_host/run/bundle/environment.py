"""With what a result was computed: Python, system, packages, and the very sources of tfsat."""

from __future__ import annotations

import hashlib
import platform
import sys
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from tfsat_host import __version__
from tfsat_host.protocol.limits import PROTOCOL_HASH

_PACKAGES = ("numpy", "scipy", "crcmod-plus", "fastcrc", "platformdirs", "pyserial", "rich", "rich-argparse")


def environment() -> dict[str, Any]:
    """For JSON; nothing in it names a person or a computer."""
    return {
        "tfsat": __version__,
        "sources_sha256": sources_sha256(),
        "protocol_hash": PROTOCOL_HASH.hex(),
        "python": platform.python_version(),
        "implementation": platform.python_implementation(),
        "system": platform.system(),
        "release": platform.release(),
        "machine": platform.machine(),
        "byte_order": sys.byteorder,
        "packages": {name: _version(name) for name in _PACKAGES},
    }


@cache
def sources_sha256() -> str:
    """Of the names and contents of tfsat's Python files: two versions of one number are told apart."""
    package = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py"), key=lambda path: path.relative_to(package).as_posix()):
        contents = hashlib.sha256(path.read_bytes()).hexdigest()
        digest.update(f"{path.relative_to(package).as_posix()} {contents}\n".encode())
    return digest.hexdigest()


def changed_since(before: Any) -> list[str]:
    """How this computer differs from the one that made a bundle; a sentence for each thing."""
    now = environment()
    if not isinstance(before, dict) or not isinstance(before.get("packages"), dict):
        return ["The bundle does not say with what it was computed."]
    then = {**before, **before["packages"]}
    here = {**now, **now["packages"]}
    return [
        f"{key}: {then.get(key, 'unknown')} then, {value} now."
        for key, value in here.items()
        if key != "packages" and then.get(key, "unknown") != value
    ]


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
