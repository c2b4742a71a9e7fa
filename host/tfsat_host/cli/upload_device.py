"""The part of `upload-sequence` that touches a board."""

from __future__ import annotations

import argparse

from tfsat_host.cli.connection import open_sequencer
from tfsat_host.cli.output import Output
from tfsat_host.maneuver import Schedule


def upload(schedule: Schedule, args: argparse.Namespace, out: Output) -> dict[str, object]:
    """Sends the schedule, has it read back and compared; the JSON keys that tell of it.

    Raises:
        TfsatError: no board, another board, a refusal, or what was read back differs.
    """
    with open_sequencer(args, out) as sequencer:
        with out.progress(f"uploading to {sequencer.port}"):
            result = sequencer.upload(schedule)
        return {
            "verified": True,
            "written": result.written,
            "identity": sequencer.identity.describe(),
            "device": {"port": sequencer.port, **sequencer.identity.as_dict()},
            "maneuver_crc": f"{result.stored.crc:04x}",
            "generation": result.stored.generation,
        }
