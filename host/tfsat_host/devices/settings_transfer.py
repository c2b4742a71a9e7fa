"""The servo settings' way onto the sequencer and back."""

from __future__ import annotations

from dataclasses import dataclass

from tfsat_host.devices.client import Client
from tfsat_host.devices.stored_record import VerifyError, repeat_until_stored
from tfsat_host.protocol.enums import Origin
from tfsat_host.protocol.messages import (
    SettingsReadReply,
    SettingsReadRequest,
    SettingsWriteReply,
    SettingsWriteRequest,
)
from tfsat_host.servo_settings import ServoSettings


@dataclass(frozen=True, slots=True)
class StoredSettings:
    """The servo settings in force.

    Attributes:
        origin: Factory or uploaded.
        generation: Settings that the board has stored.
        settings: What they say.
    """

    origin: Origin
    generation: int
    settings: ServoSettings


@dataclass(frozen=True, slots=True)
class SettingsUpload:
    """A verified upload: `written` is False when the board held the same settings already."""

    written: bool
    stored: StoredSettings


def read_settings(client: Client) -> StoredSettings:
    """The servo settings that the board uses now."""
    reply = client.request(SettingsReadRequest(), SettingsReadReply)
    return StoredSettings(reply.origin, reply.generation, ServoSettings(reply.frame_us, reply.servo))


def write_settings(client: Client, settings: ServoSettings) -> SettingsUpload:
    """Has the settings stored, reads them back and compares.

    Raises:
        BoardError: the board refused; its settings are unchanged.
        VerifyError: the board holds something else than was sent.
    """
    request = SettingsWriteRequest(settings.frame_us, settings.servos)
    before = read_settings(client)
    repeat_until_stored(
        client,
        lambda: client.request(request, SettingsWriteReply),
        "The settings from before are still in force.",
    )
    stored = read_settings(client)
    if stored.settings != settings:
        raise VerifyError(
            what=f"The sequencer holds {stored.settings}, but {settings} was sent.",
            meaning="Its servos would go elsewhere than you asked for. Do not arm it.",
            next_step="Run the same upload again; if it recurs, replace the board.",
        )
    # The board's own word is about its last request of that content, which may be of an earlier upload.
    return SettingsUpload(written=stored.generation != before.generation, stored=stored)
