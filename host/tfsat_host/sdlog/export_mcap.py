"""MCAP: the recording for Foxglove, PlotJuggler and Rerun, with the bodies' frames.

Messages are Protobuf with Foxglove's schemas, because that is what all three read today without a plug-in:
Foxglove by its schemas' names, Rerun by its importer for the same ones (and by reflection for the rest), and
PlotJuggler by the descriptors in the file, of which it plots every number. JSON is unknown to Rerun, ROS
messages would call for ROS's definitions. Each body has a topic of its own with `foxglove.FrameTransform`
instead of one `FrameTransforms` for all: PlotJuggler names the entries of a list by their position, and
a body left out of one message would move the others to a wrong curve.

Times are Unix time if the logger knew it, else its clock since power-up (then viewers show 1970).
"""

from __future__ import annotations

import heapq
import json
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .droplog import DropLog
from .extras import check_extra
from .frames import BodyFrames
from .metadata import metadata

if TYPE_CHECKING:
    from .mcap_channels import Channel, Stamp

MCAP_MARKER = b"made by tfsat-host decode"
"""The library's name in the file's first record: how the command knows a file of its own."""
METADATA_NAME = "tfsat"
"""The metadata record that describes the recording: values are text, or JSON."""


def write_mcap(
    log: DropLog,
    path: Path,
    frames: BodyFrames,
    also: Callable[[Stamp], Sequence[Channel]] | None = None,
    marker: bytes = MCAP_MARKER,
) -> None:
    """Write all messages by time, and the recording's metadata; invalid readings are left out.

    Args:
        log: What was recorded.
        path: Where to.
        frames: From `tfsat_host.evaluation.quick.body_frames`.
        also: More channels, such as those of an evaluation, given what stamps their messages.
        marker: Of the command that makes the file.

    Raises:
        MissingExtraError: the extra `mcap` is not installed.
    """
    check_extra("mcap")
    from mcap.writer import Writer
    from mcap_protobuf.schema import register_schema

    from .mcap_channels import channels

    offset_us = log.unix_offset_us or 0
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(library=marker.decode())
        schemas: dict[Any, int] = {}
        streams = []
        stamp = partial(_stamp, offset_us=offset_us)
        for channel in (*channels(log, frames, stamp), *(also(stamp) if also else ())):
            kind = channel.message_class
            if kind not in schemas:
                schemas[kind] = register_schema(writer, kind)
            number = writer.register_channel(channel.topic, "protobuf", schemas[kind], channel.metadata)
            streams.append(_numbered(number, channel.messages()))
        for t_us, number, data in heapq.merge(*streams, key=lambda message: message[0]):
            time_ns = (t_us + offset_us) * 1000
            writer.add_message(number, log_time=time_ns, publish_time=time_ns, data=data)
        writer.add_metadata(METADATA_NAME, _texts(log, frames, offset_us))
        writer.finish()  # type: ignore[no-untyped-call]


def _numbered(number: int, messages: Iterator[tuple[int, bytes]]) -> Iterator[tuple[int, int, bytes]]:
    """The messages of one channel with its number."""
    for t_us, data in messages:
        yield t_us, number, data


def _stamp(message: Any, t_us: int, offset_us: int) -> None:
    seconds, micro = divmod(t_us + offset_us, 1_000_000)
    message.timestamp.seconds = seconds
    message.timestamp.nanos = micro * 1000


def _texts(log: DropLog, frames: BodyFrames, offset_us: int) -> dict[str, str]:
    """The metadata; what is no text as JSON."""
    facts = metadata(log) | {
        "clock": "unix" if offset_us else "since power-up",
        "quick_look": list(frames.notes),
    }
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in facts.items()}
