"""A campaign's certificate and its recordings: each accepted step is kept at once, and all is solved again."""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host.calibration.acceptance import check_step
from tfsat_host.calibration.calibration_errors import CalibrationError, NotKeptError
from tfsat_host.calibration.certificate.certificate import (
    Calibration,
    Landing,
    Recording,
    Subject,
    exchanged_imus,
    with_landing,
)
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.certificate.recordings_archive import recordings_folder, write_certificate
from tfsat_host.calibration.certificate.simulated_quantities import (
    BESIDE_SIMULATED,
    measured_by,
    with_measured,
)
from tfsat_host.calibration.replacements import IMUS, NEVER_REPLACED, Replacement, Specimens
from tfsat_host.calibration.solution import Solution, solve
from tfsat_host.calibration.steps.evidence import Evidence, file_name, from_bytes, sha256, to_bytes
from tfsat_host.file_lock import LockError, one_at_a_time
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import ignore_absent
from tfsat_host.whole_file import write_whole

_LOG = logging.getLogger(__name__)

_Recordings = Mapping[tuple[str, datetime], Recording]


class Campaign:
    """One robot's calibration on disk.

    Attributes:
        certificate: Its file.
        calibration: What it says; None before the first step.
        evidence: The recordings that it rests on, in order of time.
        left_out: Recordings that are gone or were changed since, and count no more; a sentence each.

    Args:
        certificate: Its file, which need not exist.
        model: The robot.
        subject: Whose sensors are being calibrated.
        force: Begin a new certificate where there is one of another subject, or one that cannot be understood.
        replaced: Of `PARTS`, what was replaced since: the subject differs in these.

    Raises:
        CalibrationError: the certificate is another robot's, or damaged.
        OSError: a file cannot be read.
    """

    def __init__(
        self,
        certificate: Path,
        model: RobotModel,
        subject: Subject,
        *,
        force: bool = False,
        replaced: Collection[str] = (),
    ) -> None:
        self.certificate = certificate
        self.evidence: list[Evidence] = []
        self.calibration: Calibration | None = None
        self.left_out: tuple[str, ...] = ()
        self._model = model
        self._subject = subject.of_robot(model)
        self._recordings: _Recordings = {}
        self._moved: Landing | None = None
        self._replaces = False
        self._replaced = replaced
        if certificate.exists():
            self._open(force)

    @property
    def folder(self) -> Path:
        """Where the recordings lie, and each certificate that was ever written."""
        return recordings_folder(self.certificate)

    def check_lock(self) -> None:
        """Find out before anything is measured whether the certificate can be locked.

        Raises:
            CalibrationError: another program writes it for long, or the file system refuses locks.
            OSError: nothing can be written there.
        """
        with _one_writer(self.certificate):
            pass

    def solution(self) -> Solution:
        """Solve the calibration from the evidence."""
        return solve(self.evidence, self._model, self._last_landing(), self._specimens)

    def accept(self, step: Evidence, *, anew: bool = False) -> Calibration:
        """Checks a recorded step, solves all with it, and keeps both.

        What another program has written meanwhile is kept as well.

        Args:
            step: Just recorded.
            anew: Do not compare it with the zero points that were known: a sensor was fastened at another angle.

        Raises:
            CalibrationError: the step is not what was asked, or contradicts others; nothing was changed.
            NotKeptError: a file cannot be written; the certificate is as before.
        """
        with _one_writer(self.certificate):
            # Only under the lock: until then another program may add steps to the certificate.
            self._catch_up()
            # Pins on which nothing hangs read anything.
            step = replace(step, counts=ignore_absent(step.counts, self._model))
            self._check_time(step)
            check_step(step, () if anew else self.evidence, self._model, self._specimens)
            return self._keep(step)

    def sensors_moved(self, at: datetime) -> None:
        """Mark everything measured before `at` as before a landing; kept with the next accepted step."""
        if self.calibration is not None:
            self._moved = Landing(at, "a person: sensors were moved")
            self.calibration = with_landing(self.calibration, self._moved)

    def replace_parts(self, at: datetime) -> Calibration:
        """Ends what rests on the parts that were replaced, and keeps all else with its dates.

        Raises:
            CalibrationError: there is no certificate yet, or it was simulated; nothing was changed.
            NotKeptError: a file cannot be written; the certificate is as before.
        """
        with _one_writer(self.certificate):
            self._catch_up()
            before = self.calibration
            if before is None or before.simulated_quantities:
                raise CalibrationError(
                    what=f"{self.certificate} "
                    + ("does not exist." if before is None else "was simulated by a rehearsal."),
                    meaning="There is nothing that a replaced part could end.",
                    next_step=Advice("To begin a calibration: ", NextStep("calibrate bias")),
                )
            ends = (Replacement(at, part, before.subject.of_part(part)) for part in self._replaced)
            ended = replace(before, replacements=(*before.replacements, *ends))
            solution = solve(self.evidence, self._model, self._last_landing(), ended.specimens)
            calibration = self._make_certificate(solution, self._recordings, ended)
            try:
                write_certificate(self.certificate, calibration)
            except OSError as error:
                lost = f"That {', '.join(self._replaced)} was replaced is not kept"
                raise _not_kept(self.certificate, self.certificate, error, lost) from error
            self._take(calibration)
            return calibration

    def not_older_than(self, step: Evidence) -> Evidence | None:
        """Find the newest recording of the same step that is not older: the given one would not count."""
        newer = (
            evidence
            for evidence in self.evidence
            if evidence.step.key == step.step.key and evidence.recorded_at >= step.recorded_at
        )
        return max(newer, key=lambda evidence: evidence.recorded_at, default=None)

    def _open(self, force: bool) -> None:
        try:
            calibration = read_calibration(self.certificate)
        except CalibrationError:
            if not force:
                raise
            # Begin empty in memory; the old file stays until a step is accepted.
            self._replaces = True
            return
        put_on = [part for part in calibration.parts_put_on(self._model) if part not in self._replaced]
        if self._is_same_robot(calibration.subject) and not put_on:
            self._take(calibration)
        elif force:
            self._replaces = True
        else:
            there = calibration.subject.of_robot(self._model)
            raise _of_another(self.certificate, there, self._subject, put_on)

    def _is_same_robot(self, subject: Subject) -> bool:
        """Return whether another subject differs from this one at most in absent parts, and in those replaced."""
        for part in self._replaced:
            subject = subject.with_part(part, self._subject.of_part(part))
        return subject.of_robot(self._model) == self._subject

    def _catch_up(self) -> None:
        """Takes what another program has written since."""
        # A certificate that is about to be replaced has nothing to take over.
        if self._replaces or not self.certificate.exists():
            return
        calibration = read_calibration(self.certificate)
        last_written = None if self.calibration is None else self.calibration.written
        if self._is_same_robot(calibration.subject) and calibration.written != last_written:
            self._take(calibration)
            # The mark that sensors were moved is not on disk before the next step: set it again.
            if self._moved is not None:
                self.calibration = with_landing(calibration, self._moved)

    def _take(self, calibration: Calibration) -> None:
        evidence, left_out = [], []
        for recording in calibration.recordings:
            try:
                # A recording that is gone or changed costs its own step, not the campaign.
                evidence.append(_read(self.folder / recording.file, recording))
            except CalibrationError as error:
                left_out.append(error.what)
        self._recordings = _by_step(calibration.recordings)
        self.evidence, self.calibration, self.left_out = evidence, calibration, tuple(left_out)

    @property
    def _specimens(self) -> Specimens:
        return NEVER_REPLACED if self.calibration is None else self.calibration.specimens

    def _last_landing(self) -> datetime | None:
        return None if self.calibration is None else self.calibration.last_landing

    def _check_time(self, step: Evidence) -> None:
        """Refuse a step that is not newer than the newest recording of the same step."""
        newer_evidence = self.not_older_than(step)
        if newer_evidence is not None:
            raise CalibrationError(
                what=f"This step was recorded {step.recorded_at:%Y-%m-%d %H:%M} UTC, before the one that the "
                f"certificate rests on, {newer_evidence.recorded_at:%Y-%m-%d %H:%M} UTC.",
                meaning="It is an old recording, or the computer's clock was set back; it would not count.",
                next_step="Set the clock and run this command again, or name another certificate with --out.",
            )

    def _keep(self, step: Evidence) -> Calibration:
        # Solve before writing: steps that contradict each other leave the disk unchanged.
        solution = solve([*self.evidence, step], self._model, self._last_landing(), self._specimens)
        data, file = to_bytes(step), file_name(step)
        recording = Recording(step.step.key, step.recorded_at, file, sha256(data))
        recordings = {**self._recordings, **_by_step([recording])}
        calibration = self._make_certificate(solution, recordings, self.calibration)
        try:
            # The recording first: a certificate never names one that is not there.
            write_whole(self.folder / file, data)
            write_certificate(self.certificate, calibration)
        except OSError as error:
            # Which write failed: if the recording is there, it was the certificate's.
            unwritten = self.certificate if (self.folder / file).exists() else self.folder / file
            raise _not_kept(unwritten, self.certificate, error) from error
        # What a newer recording has replaced stays on disk, but counts no more.
        self.evidence, self.calibration = list(solution.used_evidence), calibration
        self._recordings = _by_step(calibration.recordings)
        self._replaces = False
        return calibration

    def _make_certificate(
        self, solution: Solution, recordings: _Recordings, before: Calibration | None
    ) -> Calibration:
        used = solution.used_evidence
        made = Calibration(
            subject=self._subject,
            gyros=solution.gyros,
            joints=solution.joints,
            servo_maps=solution.servo_maps(self._model),
            servo_dynamics=solution.servo_dynamics(self._model),
            recordings=tuple(recordings[evidence.step.key, evidence.recorded_at] for evidence in used),
            landings=() if before is None else before.landings,
            replacements=() if before is None else before.replacements,
            written=datetime.now(UTC),
            logger_image=_image_in(used[-1]) if used else None,
        )
        simulated = () if before is None else before.simulated_quantities
        if before is None or not simulated or not {entry.step.kind for entry in used} <= BESIDE_SIMULATED:
            return made
        # No recording tells what a rehearsal simulated: it stays where nothing was measured.
        kept = with_measured(before.of_robot(self._model), used, self._model)
        measured, servos = measured_by(used), tuple((entry, kept.joints) for entry, _ in solution.servos)
        return replace(
            made,
            gyros=kept.gyros,
            joints=kept.joints,
            servo_maps=kept.servo_maps,
            servo_dynamics=replace(solution, servos=servos).servo_dynamics(self._model),
            simulated_quantities=tuple(name for name in simulated if name not in measured),
        )


def note_landing(certificate: Path, landing: Landing, now: datetime | None = None) -> bool:
    """Adds a landing to a certificate without solving anything; whether it was new.

    Its values stay those of the fall that has just ended, to evaluate it by, until the next step is accepted.
    `now` is when it is written; None: as the computer's clock says.

    Raises:
        CalibrationError: the certificate cannot be understood, or another program writes it for long.
        OSError: it cannot be written.
    """
    with _one_writer(certificate):
        calibration = read_calibration(certificate)
        changed = with_landing(calibration, landing)
        # The same object comes back where the landing is known: there is nothing to write.
        if changed is calibration:
            return False
        write_certificate(certificate, replace(changed, written=now or datetime.now(UTC)))
        return True


def _not_kept(
    unwritten: Path, certificate: Path, error: OSError, lost: str = "This step was not kept"
) -> NotKeptError:
    return NotKeptError(
        what=f"{unwritten} could not be written: {error.strerror or error}.",
        meaning=f"{lost}; {certificate} is as before.",
        next_step="Free disk space, or make the file writable, and run this command again.",
    )


@contextmanager
def _one_writer(certificate: Path) -> Iterator[None]:
    """Lock the certificate so that no other program writes it while the block runs.

    Raises CalibrationError, OSError.
    """
    certificate.parent.mkdir(parents=True, exist_ok=True)
    try:
        with one_at_a_time(
            # Lock a file of its own: each write replaces the certificate, and a lock on it would be lost.
            certificate.with_name(f".{certificate.name}.lock"),
            f"the calibration {certificate}",
        ):
            yield
    except LockError as error:
        raise CalibrationError(
            what=error.what, meaning=f"{error.meaning} No step was kept.", next_step=error.next_step
        ) from error


def _image_in(step: Evidence) -> str | None:
    """Return the CRC of the image that the logger ran when the step was recorded.

    None: a core that ran natively, which has no image.
    """
    return step.origin.image_crc if step.origin.image_crc.strip("0") else None


def _by_step(recordings: Iterable[Recording]) -> _Recordings:
    return {(recording.step, recording.recorded_at): recording for recording in recordings}


def _read(path: Path, recording: Recording) -> Evidence:
    again = Advice(
        "Copy it back next to the certificate, or repeat the step: ",
        NextStep("calibrate show"),
        " names the commands.",
    )
    try:
        data = path.read_bytes()
        _LOG.debug("read %s: a recording of the calibration", path)
    except FileNotFoundError as error:
        raise CalibrationError(
            what=f"The recording {path} of this calibration does not exist.",
            meaning="Its step no longer counts once another step is accepted.",
            next_step=again,
        ) from error
    # By its hash before anything is parsed: only the bytes that were accepted count.
    if sha256(data) != recording.sha256:
        raise CalibrationError(
            what=f"The recording {path} of this calibration is modified: its SHA-256 differs.",
            meaning="It was changed or damaged; its step no longer counts once another step is accepted.",
            next_step=again,
        )
    return from_bytes(data, source=str(path))


def _of_another(certificate: Path, there: Subject, here: Subject, put_on: list[str]) -> CalibrationError:
    parts, silent = ["PART"], ""
    difference = f"it is of {there.describe()}; this would be of {here.describe()}"
    # The same robot on the same logger: it has other IMUs, or more joints.
    if there.describe() == here.describe():
        imus = [IMUS[body - 1] for body in exchanged_imus(there, here.who_am_i)]
        others = [part for part in imus if part not in put_on]
        differences = [f"{part} was absent" for part in put_on]
        differences += [
            f"{part} was {there.name_part(part)} and is {here.name_part(part)}" for part in others
        ]
        difference, parts = "; ".join(differences), [*put_on, *others]
        silent = " and ".join(part for part in others if here.of_part(part) == "00")
    return CalibrationError(
        what=f"{certificate} holds another calibration: {difference}.",
        meaning="Nothing was measured, nothing was overwritten.",
        next_step=Advice(
            *((f"Check plug and cable of {silent}: ", NextStep("monitor"), ". ") if silent else ()),
            "If a part of that robot was replaced, or put on: ",
            NextStep("calibrate replaced", tuple(parts)),
            ". Else name another file with --out, or add --force to begin it again.",
        ),
    )
