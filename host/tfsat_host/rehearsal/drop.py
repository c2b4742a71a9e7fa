"""What a rehearsed day leaves behind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.devices.sequencer import StoredManeuver, Upload
from tfsat_host.errors import TfsatError
from tfsat_host.protocol.messages import RecordStopReply, SequencerStatusReply
from tfsat_host.rehearsal.checked import Checked

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Drop:
    """See the module.

    Attributes:
        card: The newest recording on the card, byte by byte; empty if there is none.
        from_ram: That recording was fetched from the logger's RAM instead.
        upload: Of the maneuver that flew; None: it did not come through.
        checked: The preflight's result; None: there was none.
        sequencer: Its status after the landing; None: it does not answer.
        recording: The logger's account of the recording; None: it does not answer, or has none.
        calibration: What the bench told of this robot; what was only drawn of it, it says.
        recordings: Of the morning, by their files' names.
        collected: When the card was taken out, by the team's clock.
        truth: See `EmulatedRobot.truth`; from the start of the recording.
        released_s: Virtual time at which both switches first were open; None: nobody let go.
        landed_s: Virtual time of the landing; None: nobody let go.
        refused: What ended the day before the drop; None: nothing did.
        setbacks: What else went wrong on the way; a sentence each.
    """

    card: bytes
    from_ram: bool
    upload: Upload[StoredManeuver] | None
    checked: Checked | None
    sequencer: SequencerStatusReply | None
    recording: RecordStopReply | None
    calibration: Calibration
    recordings: Mapping[str, bytes]
    collected: datetime
    truth: FloatArray
    released_s: float | None
    landed_s: float | None
    refused: TfsatError | None
    setbacks: tuple[str, ...]
