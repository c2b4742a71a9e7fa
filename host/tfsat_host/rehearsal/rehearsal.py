"""A rehearsal of one drop: flown, decoded, evaluated, reported, compared with the truth, and kept in a folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tfsat_host.emulated.build import Variant, ensure_built, sequencer_hex
from tfsat_host.emulated.imu_part import ImuPart, load_imu
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.maneuver import Maneuver, Schedule, schedule_maneuver
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import SILENT, Notices
from tfsat_host.plan.facility import load_tower
from tfsat_host.quantity import record
from tfsat_host.rehearsal import rehearsed_drop as drops
from tfsat_host.rehearsal import series as many
from tfsat_host.rehearsal.day import Preflight
from tfsat_host.rehearsal.faults.fault import Fault
from tfsat_host.rehearsal.faults.fault_catalog import faults_named
from tfsat_host.rehearsal.folder import ResultFolder
from tfsat_host.rehearsal.judgement import JudgedDay
from tfsat_host.rehearsal.rehearsed_drop import Drop
from tfsat_host.rehearsal.result import REHEARSAL, RehearsalResult, with_quick_look
from tfsat_host.rehearsal.run_folder import RunFolder
from tfsat_host.rehearsal.series import Series
from tfsat_host.rehearsal.series_result import TABLE, SeriesResult, write_series
from tfsat_host.rehearsal.truth_comparison import truth_text
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import load_robot_of_boards, require_all_parts
from tfsat_host.run import drop_report
from tfsat_host.run.drop_evaluation import EvaluatedRun
from tfsat_host.run.files import MANEUVER, ROBOT
from tfsat_host.sdlog import DropLog


@dataclass(frozen=True, slots=True)
class RehearsalOptions:
    """On which robot a drop is rehearsed.

    Attributes:
        sequencer: Its firmware's core on this computer, or the image that is flashed in an emulated ATmega32U4.
        robot: A robot file, or the name of a shipped one; None: the drop tower's.
        as_filed: The robot is exactly what its file says.
        imu: Another IMU on every body, by name or file; None: the robot's own.
        despite_preflight: It is dropped even if the preflight says NO-GO.
    """

    sequencer: Literal["native", "avr"] = "native"
    robot: str | None = None
    as_filed: bool = False
    imu: str | None = None
    despite_preflight: bool = False

    def nominal_robot(self) -> RobotModel:
        """Load the robot from its file.

        Raises:
            TfsatError: it cannot be read, or there are no boards for such a robot.
        """
        return load_robot_of_boards(self.robot)

    def part(self) -> ImuPart | None:
        """Load the chosen IMU; None: the robot's own. Raises UsageError, TfsatError."""
        if self.imu is None:
            return None
        if self.as_filed:
            raise UsageError(
                what="--imu and --as-filed contradict each other: a robot as its file has it has no part's errors.",
                meaning="Nothing was flown.",
                next_step="Leave one of them out.",
            )
        return load_imu(self.imu)

    def image(self, note: Callable[[str], None]) -> Path | None:
        """Return the sequencer's image; None for its native core.

        Builds what is missing, with a note.
        """
        hex_path = sequencer_hex(note) if self.sequencer == "avr" else None
        ensure_built(Variant(avr=hex_path is not None), note)
        return hex_path


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """A drop that is to be rehearsed.

    Attributes:
        maneuver: What flies.
        schedule: Of it.
        filed: The robot as its file has it.
        faults: What goes wrong.
        options: On which robot.
        part: Its IMUs; None: its own.
    """

    maneuver: Maneuver
    schedule: Schedule
    filed: RobotModel
    faults: tuple[Fault, ...]
    options: RehearsalOptions
    part: ImuPart | None

    @classmethod
    def of(
        cls,
        maneuver: Maneuver,
        options: RehearsalOptions = RehearsalOptions(),
        faults: Sequence[str] = (),
        schedule: Schedule | None = None,
    ) -> Rehearsal:
        """Build the rehearsal of a maneuver, with faults by name, such as `gyro-dead` or `gyro-dead@powered`.

        A fault has a moment behind its name if it is another than its own; `schedule` is the maneuver's, if
        it was built already.

        Raises:
            TfsatError: robot, IMU, maneuver or faults are refused.
        """
        robot = options.nominal_robot()
        if faults:
            require_all_parts(robot)
        return cls(
            maneuver,
            schedule or schedule_maneuver(maneuver),
            robot,
            faults_named(faults),
            options,
            options.part(),
        )

    def series(self, seed: int, image: Path | None) -> Series:
        """Drops of the robots of a seed, the first of which `run` rehearses. Raises EnvelopeError."""
        options = self.options
        preflight = Preflight.of(
            self.schedule, self.filed, load_tower(None), image, despite=options.despite_preflight
        )
        names = tuple(fault.name for fault in self.faults)
        return Series(self.schedule, self.filed, seed, options.as_filed, image, names, self.part, preflight)

    def run(
        self, folder: Path, seed: int = 1, *, force: bool = False, notices: Notices = SILENT
    ) -> RehearsalResult:
        """Rehearses the drop and leaves its run, report and result in a folder, all or nothing.

        The folder is that of another rehearsal, empty, or not there; with `force` files may be overwritten
        that no rehearsal made. `seed` is that of the robot, of noise and contact bounce.

        Raises:
            UsageError: the folder holds something else.
            TfsatError: the robot cannot be emulated, or the folder cannot be written.
        """
        # First of all: a folder that may not be overwritten is refused before anything is built or flown.
        run_folder = RunFolder(folder, force=force)
        series = self.series(seed, self.options.image(notices.note))
        with notices.progress("Rehearsing", total=drops.STEPS) as advance:
            drop = series.rehearse(series.truth(1), lambda _: advance(1))
        robot = self.filed.path.read_bytes()  # which may lie in this very folder
        with run_folder.replace_files():
            # Faults may have made another robot of it: the truth is the one that flew.
            log = run_folder.write(self.maneuver, drop, robot, truth_text(drop, self.filed))
            # Evaluate from the files that were just written, so that they are rehearsed, too.
            evaluated, refusal = _evaluate_folder(run_folder, drop, log)
            judged = (
                JudgedDay(drop, log, refusal=refusal)
                if evaluated is None
                else JudgedDay(drop, log, evaluated.found, evaluated.verdict)
            )
            result = with_quick_look(
                RehearsalResult(
                    self.options.sequencer,
                    self.options.as_filed,
                    self.schedule,
                    self.filed,
                    judged,
                    evaluated,
                    None,
                    folder,
                    tuple(run_folder.files),
                ),
                notices,
            )
            # The summary comes last: writing it seals the folder with the hashes of all files.
            run_folder.write_summary(record(REHEARSAL, result))
        for stale in run_folder.removed:
            notices.note(f"Removed {stale}: it was made of the recording that this one replaces.")
        return result

    def run_many(
        self,
        folder: Path,
        runs: int,
        seed: int = 1,
        *,
        force: bool = False,
        notices: Notices = SILENT,
        stop: Callable[[], bool] = lambda: False,
    ) -> SeriesResult | None:
        """Rehearses as many drops, each of another robot, and leaves a table of them.

        `folder` and `force` as of `run`; `seed` is that of all robots. `stop` is asked often: whether to
        begin no more drops.

        Returns:
            What was flown; None, and nothing written, if that is nothing.

        Raises:
            UsageError: the folder holds something else.
            TfsatError: the robot cannot be emulated, or the folder cannot be written.
        """
        series = self.series(seed, self.options.image(notices.note))
        result_folder = ResultFolder(folder, force=force)
        with notices.progress("Rehearsing", total=runs) as advance:
            outcomes = many.fly_many(series, runs, progress=lambda: advance(1), stop=stop)
        # Stopped before the first drop: a folder of nothing would replace one of something.
        if not outcomes:
            return None
        result = SeriesResult(series, runs, outcomes, folder / TABLE, self._command_of_one(folder))
        write_series(result_folder, self.maneuver, result)
        return result

    def _command_of_one(self, folder: Path) -> Advice:
        """Return the command that flies one drop of a series alone, with seed and folder to be filled in."""
        options = self.options
        words = ["--file", str(folder / MANEUVER), "--robot", str(folder / ROBOT)]
        words += [word for fault in self.faults for word in ("--fault", fault.name)]
        words += ["--imu", options.imu] if options.imu else []
        words += ["--as-filed"] if options.as_filed else []
        words += ["--despite-preflight"] if options.despite_preflight else []
        words += ["--sequencer", options.sequencer] if options.sequencer != "native" else []
        return Advice(NextStep("rehearse", (*words, "--seed", "SEED", "--out", "DIR")))


def _evaluate_folder(
    folder: RunFolder, drop: Drop, log: DropLog | None
) -> tuple[EvaluatedRun | None, TfsatError | None]:
    """Evaluate the recording as `report` would; return the evaluation or why it cannot be evaluated.

    Both are None if nothing fell.
    """
    if log is None or drop.refused is not None:
        return None, None
    # Announced before it is written, so that an interruption removes half a page.
    folder.announce(drop_report.PAGE)
    try:
        # Dated by the rehearsal's clock: the same rehearsal gives the same bytes.
        report = drop_report.report([folder.path], made_at=folder.collected)
    except TfsatError as error:
        return None, error
    folder.files += report.files
    return report.runs[0], None
