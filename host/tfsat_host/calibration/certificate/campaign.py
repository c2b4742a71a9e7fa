"""A campaign's certificate and the recordings beside it: each accepted step is kept at once, and all is
solved anew."""

from __future__ import annotations

import os
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host.calibration.certificate.certificate import Calibration, Landing, Paper, Subject, with_landing
from tfsat_host.calibration.certificate.file import format_calibration, read_calibration
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.servos.reached import servo_map_of
from tfsat_host.calibration.solution import Solution, solve
from tfsat_host.calibration.steps.acceptance import check_step
from tfsat_host.calibration.steps.evidence import Evidence, file_name, from_bytes, newest, sha256, to_bytes
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.robot import RobotModel


class Campaign:
    """One robot's calibration on disk.

    Attributes:
        certificate: Its file.
        calibration: What it says; None before the first step.
        evidence: The recordings that it rests on, in order of time.

    Args:
        certificate: Its file, which need not exist.
        model: The robot.
        subject: Whose sensors are being calibrated.
        force: Begin a new certificate where there is one of another subject; its recordings stay.

    Raises:
        CalibrationError: the certificate is another robot's, damaged, or one of its recordings is missing or changed.
        OSError: a file cannot be read.
    """

    def __init__(
        self, certificate: Path, model: RobotModel, subject: Subject, *, force: bool = False
    ) -> None:
        self.certificate = certificate
        self.evidence: list[Evidence] = []
        self.calibration: Calibration | None = None
        self._model = model
        self._subject = subject
        if not certificate.exists():
            return
        if force:
            self._take_if_same()
            return
        found = read_calibration(certificate)
        if found.subject != subject:
            raise _of_another(certificate, found.subject, subject)
        self.evidence = [_read(self.folder / paper.file, paper) for paper in found.papers]
        self.calibration = found

    @property
    def folder(self) -> Path:
        """Where the recordings lie."""
        return self.certificate.with_name(f"{self.certificate.stem}-recordings")

    def solution(self) -> Solution:
        """What the evidence tells."""
        return self._solved(self.evidence)

    def accept(self, step: Evidence, *, anew: bool = False) -> Calibration:
        """Checks a recorded step, solves all with it, and keeps both.

        Args:
            step: Just recorded.
            anew: Do not compare it with the zero points that were known: a sensor was fastened at another angle.

        Raises:
            CalibrationError: the step is not what was asked, or contradicts others; nothing was changed.
            OSError: a file cannot be written; the certificate is as before.
        """
        before = solve((), self._model) if anew else self.solution()
        check_step(step, before, self._model)
        return self._keep([*self.evidence, step], written=step)

    def sensors_moved(self, at: datetime) -> None:
        """What was measured before counts as before a landing; kept with the next accepted step."""
        if self.calibration is not None:
            self.calibration = with_landing(self.calibration, Landing(at, "a person: sensors were moved"))

    def _take_if_same(self) -> None:
        try:
            found = read_calibration(self.certificate)
            evidence = [_read(self.folder / paper.file, paper) for paper in found.papers]
        except CalibrationError:
            return
        if found.subject == self._subject:
            self.evidence, self.calibration = evidence, found

    def _solved(self, evidence: list[Evidence]) -> Solution:
        last = None if self.calibration is None else self.calibration.last_landing
        return solve(evidence, self._model, last)

    def _keep(self, evidence: list[Evidence], written: Evidence | None = None) -> Calibration:
        solution = self._solved(evidence)
        calibration = self._certified(solution)
        if written is not None:
            write_whole(self.folder / file_name(written), to_bytes(written))
        text = format_calibration(calibration).encode()
        write_whole(self.folder / f"certificate-{calibration.written:%Y%m%dT%H%M%S.%f}.toml", text)
        write_whole(self.certificate, text)
        self.evidence, self.calibration = list(solution.used), calibration
        return calibration

    def _certified(self, solution: Solution) -> Calibration:
        servos = [one for one in newest(solution.used).values() if one.step.kind == StepKind.SERVO]
        servos.sort(key=lambda one: one.step.joint or 0)
        before = self.calibration
        return Calibration(
            subject=self._subject,
            gyros=solution.gyros,
            joints=solution.joints,
            servo_maps=tuple(servo_map_of(one, solution.joints, self._model) for one in servos),
            servo_taken=tuple(one.taken for one in servos),
            papers=tuple(
                Paper(one.step.key, one.taken, file_name(one), sha256(to_bytes(one))) for one in solution.used
            ),
            landings=() if before is None else before.landings,
            written=datetime.now(UTC),
        )


def note_landing(certificate: Path, landing: Landing) -> bool:
    """Adds a landing to a certificate without solving anything; whether it was new.

    Raises:
        CalibrationError: the certificate cannot be understood.
        OSError: it cannot be written.
    """
    found = read_calibration(certificate)
    changed = with_landing(found, landing)
    if changed is found:
        return False
    write_whole(certificate, format_calibration(replace(changed, written=datetime.now(UTC))).encode())
    return True


def write_whole(path: Path, data: bytes) -> None:
    """Writes a file so that a power cut leaves the old one or the new one. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f".{path.name}.new")
    with beside.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    beside.replace(path)


def _read(path: Path, paper: Paper) -> Evidence:
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise CalibrationError(
            what=f"The recording {path}, on which the calibration rests, is not there.",
            meaning="The certificate could not be proven, nor computed anew with another step.",
            next_step=f"Copy it back beside the certificate, or begin anew: tfsat-host calibrate "
            f"{paper.step.split('-')[0]} "
            "with --out and another name.",
        ) from error
    if sha256(data) != paper.sha256:
        raise CalibrationError(
            what=f"The recording {path} is not the one on which the calibration rests: its SHA-256 differs.",
            meaning="It was changed or damaged since; what was computed from it cannot be proven.",
            next_step="Take it from a copy, or repeat the step with --out and another name for the "
            "certificate.",
        )
    return from_bytes(data, source=str(path))


def _of_another(certificate: Path, there: Subject, here: Subject) -> CalibrationError:
    return CalibrationError(
        what=f"{certificate} holds another calibration: it is of {there.describe()}; this would be of "
        f"{here.describe()}.",
        meaning="Nothing was measured, nothing was overwritten.",
        next_step="Name another file with --out, or add --force to begin it anew.",
    )
