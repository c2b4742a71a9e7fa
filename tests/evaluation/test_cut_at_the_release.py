"""Recordings that end about the release: an evaluation of what there is, or a refusal in words."""

from __future__ import annotations

from pathlib import Path

from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.motion.samples import EvaluationError
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.rehearsal.rehearse import rehearse
from tfsat_host.rehearsal.truth import truth_as_filed
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import load

STEP = 4
AROUND_S = (-0.3, 0.5)


def test_every_end_around_the_release(tmp_path: Path) -> None:
    schedule, robot = schedule_maneuver(four_stroke(59.0, 70.0)), load_robot()
    drop = rehearse(schedule, robot, truth_as_filed(robot, 1))
    file = tmp_path / "SD.bin"
    said = []
    for blocks in range(STEP, len(drop.card) // BLOCK_BYTES, STEP):
        file.write_bytes(drop.card[: blocks * BLOCK_BYTES])
        log = load(file)
        if log.release_us is None or not AROUND_S[0] < log.t_s[-1] < AROUND_S[1]:
            continue
        try:
            evaluate(log, robot, drop.calibration, schedule)
            said.append("evaluated")
        except EvaluationError as refused:
            said.append(refused.meaning)
    assert "It has nothing of the fall: there is nothing to evaluate." in said
    assert said[-1] == "evaluated"
