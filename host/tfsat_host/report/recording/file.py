"""Writes the MCAP file of an evaluated drop."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.report.contents.reported import Reported
from tfsat_host.sdlog.export_mcap import BodyFrames, write_mcap

if TYPE_CHECKING:
    from tfsat_host.sdlog.export_mcap import Channel, Stamp

MARKER = b"made by tfsat-host report"
"""Stands in the file's first record: how the command knows its own."""
NOTE = "Bodies and joints are as they were evaluated; positions are about the center of mass, which falls freely."


def write_evaluated_mcap(drop: Reported, path: Path) -> None:
    """The recording as `decode` writes it, its quick look replaced by the evaluation.

    Raises:
        MissingExtraError: the extra `mcap` is not installed.
    """

    def channels(stamp: Stamp) -> list[Channel]:
        from tfsat_host.report.recording.channels import Topics
        from tfsat_host.report.recording.scene import scene_channel, words_channel

        topics = Topics(drop.evaluation, stamp)
        return [*topics.channels(), scene_channel(drop, topics, stamp), words_channel(drop, topics, stamp)]

    write_mcap(drop.evaluation.log, path, BodyFrames((), (), (NOTE,)), channels, MARKER)
