"""tools/udev/60-tfsat.rules: what udev would read, and that it is the boards that the host looks for."""

from __future__ import annotations

import re
import shutil
import subprocess
from itertools import product

import pytest

from tests.paths import REPOSITORY
from tfsat_host.devices.serial_ports import PortInfo, identify

PATH = REPOSITORY / "tools" / "udev" / "60-tfsat.rules"
LINES = [line for line in PATH.read_text(encoding="ascii").splitlines() if line and not line.startswith("#")]

# udev(7): what may stand in a rule of this file, and how it is compared or assigned.
_MATCH, _ASSIGN = {"==", "!="}, {"=", "+=", ":="}
_KEYS = {
    "ACTION": _MATCH,
    "SUBSYSTEM": _MATCH,
    "SUBSYSTEMS": _MATCH,
    "ATTR{}": _MATCH,
    "ATTRS{}": _MATCH,
    "ENV{}": _MATCH | _ASSIGN,
    "MODE": _ASSIGN,
    "TAG": _ASSIGN,
    "SYMLINK": _ASSIGN,
    "GOTO": {"="},
    "LABEL": {"="},
}
_TOKEN = re.compile(r'([A-Z]+)(?:\{(\w+)\})?(==|!=|\+=|:=|=)"([^"]*)"(?:, |$)')
Token = tuple[str, str, str, str]


def tokens(line: str) -> list[Token]:
    """Split a udev rule into key, attribute, operator and value; assert that udev would read it."""
    parsed_tokens, at = [], 0
    while at < len(line):
        token = _TOKEN.match(line, at)
        assert token, line[at:]
        key, attribute, operator, value = token.groups(default="")
        # `MODE==` would compare and silently give no access.
        assert operator in _KEYS[f"{key}{{}}" if attribute else key], line
        parsed_tokens.append((key, attribute, operator, value))
        at = token.end()
    assert not line.endswith(", "), line
    return parsed_tokens


RULES = [tokens(line) for line in LINES]


def _ids(rule: list[Token]) -> set[tuple[int, int]]:
    values = {attribute: value.split("|") for _, attribute, operator, value in rule if operator == "=="}
    pairs = product(values.get("idVendor", ()), values.get("idProduct", ()))
    return {(int(vendor, 16), int(product, 16)) for vendor, product in pairs}


def _assigned_value(rule: list[Token], key: str) -> str | None:
    return next((value for name, _, operator, value in rule if name == key and operator in _ASSIGN), None)


def _of_ports() -> list[list[Token]]:
    return [rule for rule in RULES if ("SUBSYSTEM", "", "==", "tty") in rule]


def test_every_goto_has_its_label() -> None:
    labels = [value for rule in RULES for key, _, _, value in rule if key == "LABEL"]
    jumps = [value for rule in RULES for key, _, _, value in rule if key == "GOTO"]
    assert jumps == labels == ["tfsat_end"]
    assert RULES[-1][0][0] == "LABEL"


def test_udev_itself_finds_no_fault_where_it_can_be_asked() -> None:
    """`udevadm verify` came with systemd 254; an older one does not know the word and checks nothing."""
    if shutil.which("udevadm") is None:
        pytest.skip("no udevadm here")
    process = subprocess.run(["udevadm", "verify", PATH], capture_output=True, text=True, check=False)
    assert process.returncode == 0 or "Unknown command verb" in process.stderr, process.stderr


@pytest.mark.parametrize(
    "line", ['SUBSYSTEM="tty"', 'MODE=="0660"', 'TAG+="uaccess",', "MODE=0660", 'MOED="1"']
)
def test_a_mistake_would_be_found(line: str) -> None:
    with pytest.raises((AssertionError, KeyError)):
        tokens(line)


def test_it_is_read_before_the_access_is_given() -> None:
    # 73-seat-late.rules gives the access that the tag asks for: later tags come too late.
    assert int(PATH.name[:2]) < 73
    access = [
        (_assigned_value(rule, "MODE"), _assigned_value(rule, "TAG"))
        for rule in RULES
        if _ids(rule) and _assigned_value(rule, "MODE")
    ]
    assert access and set(access) == {("0660", "uaccess")}


def test_the_ports_are_those_that_the_host_looks_for() -> None:
    links = {ids: _assigned_value(rule, "SYMLINK") for rule in _of_ports() for ids in _ids(rule)}
    identities = {
        (vendor, number): identify(PortInfo("port", vendor, number))
        for vendor in (0x2341, 0x2A03, 0x16C0)
        # Every product of the three makers: a rule too many would be found, too.
        for number in range(0x10000)
    }
    expected = {
        ids: f"tfsat-{identity.board}" if identity.mode == "sketch" else None
        for ids, identity in identities.items()
        if identity is not None
    }
    assert links == expected


def test_modem_manager_leaves_every_port_alone() -> None:
    # ModemManager sends AT commands to new serial ports: bytes that the boards did not ask for.
    ignored = {
        ids for rule in RULES if ("ENV", "ID_MM_DEVICE_IGNORE", "=", "1") in rule for ids in _ids(rule)
    }
    assert ignored >= {ids for rule in _of_ports() for ids in _ids(rule)}
