"""The golden blocks of protocol/golden_vectors.json as a C++ header for the block layout's test."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.paths import REPOSITORY

_ENUMS = {"kind": "BlockKind", "code": "EventCode", "stop_reason": "StopReason"}

_HEAD = """\
#pragma once
#include "../../../firmware/teensy_logger/src/core/block_layout.h"

namespace tfsat_test {

struct GoldenBlock {
  void (*fill)(tfsat::logger::Block& block);
  uint8_t bytes[512];
};
"""


def write_header(path: Path) -> None:
    """Write a header with `tfsat_test::kGoldenBlocks`: how to fill each block, and its bytes."""
    blocks = json.loads((REPOSITORY / "protocol" / "golden_vectors.json").read_text())["blocks"]
    assert {block["kind"] for block in blocks} == {"header", "data", "footer"}
    lines = [_HEAD]
    for number, block in enumerate(blocks):
        lines += [f"inline void fill_{number}(tfsat::logger::Block& block) {{"]
        lines += ["  using namespace tfsat::logger;", "  using namespace tfsat::protocol;"]
        lines += [f"  {statement}" for statement in _statements(block)]
        lines += ["}", ""]
    lines += ["static const GoldenBlock kGoldenBlocks[] = {"]
    for number, block in enumerate(blocks):
        data = ", ".join(str(byte) for byte in bytes.fromhex(block["bytes"]))
        lines += [f"  {{fill_{number}, {{{data}}}}},"]
    lines += ["};", "", "}  // namespace tfsat_test", ""]
    path.write_text("\n".join(lines))


def _statements(block: dict[str, Any]) -> Iterator[str]:
    if block["kind"] != "data":
        yield f"Log{block['kind'].title()} payload = {{}};"
        yield from _assign("payload", block["body"])
        yield "put_payload(block, payload);"
    for name in ("sample", "event"):
        for slot, values in enumerate(block.get(f"{name}s", [])):
            yield f"{name.title()} {name}_{slot} = {{}};"
            yield from _assign(f"{name}_{slot}", values)
            yield f"put_{name}(block, {slot}, {name}_{slot});"
    yield "BlockHeader head = {};"
    yield from _assign("head", block["head"])
    yield "seal(block, head);"


def _assign(target: str, value: Any) -> Iterator[str]:
    field = target.rpartition(".")[2]
    if isinstance(value, dict):
        for name, part in value.items():
            yield from _assign(f"{target}.{name}", part)
    elif isinstance(value, list):
        for index, part in enumerate(value):
            yield from _assign(f"{target}[{index}]", part)
    elif field in _ENUMS:
        yield f"{target} = static_cast<{_ENUMS[field]}>({value});"
    elif isinstance(value, float):
        yield f"{target} = {value!r}f;"
    else:
        yield f"{target} = {value}{'u' if value >= 0 else ''};"
