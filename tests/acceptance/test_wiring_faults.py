"""Each wiring fault is named with its pin, and blames nothing that is right."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NoReturn

import pytest

from tests.acceptance.bench_in_emulation import NAMES, accept, emulated_bench
from tests.robot.fewer_parts import smaller_robot
from tfsat_host.acceptance.bench import StillArmed, Task
from tfsat_host.acceptance.steps import STEPS, make_step
from tfsat_host.acceptance.wiring_faults import WIRING_FAULTS, WiringFault
from tfsat_host.devices.jogging import JogClient
from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.emulated.emulated_robot import BoardIndex
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.preflight.preflight_check import go

SERVOS_RIGHT = replace(go("fine"), name="servos")
UPLOADED = schedule_maneuver(four_stroke(40.0, 50.0))

STEPS_FOR = {
    "imu": ("rest", "motion"),
    "angle": ("motion",),
    "switch": ("switches",),
    "switches": ("switches",),
    "stroke": ("boards", "switches", "time"),
    "clock": ("boards", "switches", "time"),
    "servo": ("motion", "servos"),
    "battery": ("motion", "switches", "servos", "supply"),
    "card": ("boards", "card"),
}
"""By the first word of a fault the steps that name it, and those that these rest on."""


@pytest.mark.parametrize("fault", WIRING_FAULTS.values(), ids=WIRING_FAULTS.keys())
def test_a_fault_is_named_and_nothing_else(fault: WiringFault) -> None:
    with emulated_bench([fault.name]) as (bench, _):
        acceptance = accept(bench, STEPS_FOR[fault.name.split("-")[0]])
    sentences = [check.sentence for check in acceptance.checks]
    assert any(fault.finding in sentence for sentence in sentences), sentences
    wrong = [check.sentence for check in acceptance.checks if check.blocks and not check.follows]
    # A battery that carries one servo is no fault by the settings, which allow one.
    assert len(wrong) == (0 if fault.name == "battery-weak" else 1), wrong


def test_there_are_more_than_fifteen() -> None:
    assert len(WIRING_FAULTS) >= 15


def test_faults_together_are_each_named() -> None:
    with emulated_bench(["imu-3-4-swapped", "angle-2-swapped", "switch-2-stuck"]) as (bench, _):
        acceptance = accept(bench, ("rest", "motion", "switches"))
    text = " ".join(check.sentence for check in acceptance.checks)
    for name in ("imu-3-4-swapped", "angle-2-swapped", "switch-2-stuck"):
        assert WIRING_FAULTS[name].finding in text


def test_a_robot_that_is_right_is_accepted_and_keeps_what_its_boards_held() -> None:
    with emulated_bench() as (bench, robot):
        bench.sequencer.upload(UPLOADED)
        held, settings = bench.sequencer.read_back(), bench.sequencer.settings().settings
        files = robot.card_slot.files()
        acceptance = accept(bench)
        assert not acceptance.remaining, [check.sentence for check in acceptance.checks if check.blocks]
        assert bench.sequencer.read_back().strokes == held.strokes
        assert bench.sequencer.settings().settings == settings
        assert bench.sequencer.status().state.name == "SAFE"
        assert robot.card_slot.files() == files
    assert [step.name for step in acceptance.steps] == list(NAMES)
    # The crystals of this robot, as the emulator drew them.
    truth = robot.imperfections
    expected_ppm = truth.sequencer_clock_ppm - truth.logger_clock_ppm
    rate, std = (acceptance.evidence("clock-ratio", key) for key in ("rate_ppm", "rate_ppm_std"))
    assert abs(rate - expected_ppm) < 3 * std
    assert std < 10.0
    assert max(map(abs, acceptance.evidence("stroke-times", "residual_us"))) < 5.0


@pytest.mark.parametrize("step", ["time", "servos", "supply"])
def test_ctrl_c_leaves_nothing_armed_and_nothing_driven(step: str) -> None:
    with emulated_bench() as (bench, robot):
        before = accept(bench, ("boards", "motion", "switches"))
        if step == "supply":
            before = before.with_step(replace(before.steps[0], name="servos", checks=(SERVOS_RIGHT,)))
        held, settings = bench.sequencer.read_back(), bench.sequencer.settings().settings
        wait, waits = bench.sequencer.wait, 0

        def interrupt(duration_s: float) -> None:
            nonlocal waits
            wait(duration_s)
            waits += 1
            if waits == 2:
                raise KeyboardInterrupt

        for board in (bench.sequencer, bench.logger):
            # A servo's motion passes its time on the logger's clock, an armed run on the sequencer's.
            board.wait = interrupt  # type: ignore[method-assign]
        with pytest.raises(KeyboardInterrupt):
            make_step(STEPS[NAMES.index(step)], bench, before)
        status = bench.sequencer.status()
        assert (status.state.name, status.servos_driven) == ("SAFE", 0)
        assert bench.sequencer.settings().settings == settings
        assert bench.sequencer.read_back().strokes == held.strokes
        assert bench.logger.status().state.name in ("IDLE", "STOPPED")
        assert not robot.card_slot.files()


def test_a_link_that_breaks_while_armed_ends_the_session_with_that_on_the_screen() -> None:
    """A cable that is pulled does not disarm: whoever stands beside the robot must know."""
    with emulated_bench() as (bench, robot):
        before = accept(bench, ("boards", "switches"))

        def never() -> NoReturn:
            raise PortError(PortProblem.LOST, what="The connection was lost.", next_step="")

        bench.reopen = never
        press = bench.hands.do

        class Hands:
            def do(self, task: Task, number: int = 0) -> None:
                if task is Task.LET_GO:
                    robot.set_cable(BoardIndex.SEQUENCER, False)
                else:
                    press(task, number)

        bench.hands = Hands()
        with pytest.raises(StillArmed, match="could not be disarmed") as caught:
            make_step(STEPS[NAMES.index("time")], bench, before)
        assert "IT MAY STILL BE ARMED" in caught.value.meaning
        assert "Open S4, then S3" in caught.value.next_step
        # True: nothing but its supply stops it now.
        robot.set_cable(BoardIndex.SEQUENCER, True)
        again = JogClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        assert again.status().state.name == "ARMED"


def test_a_recording_that_runs_is_not_touched() -> None:
    with emulated_bench() as (bench, _):
        session = bench.logger.start_recording().session
        acceptance = accept(bench, ("boards", "switches", "card", "time"))
        status = bench.logger.status()
    assert (status.state.name, status.session) == ("RECORDING", session)
    assert [check.name for check in acceptance.checks if check.blocks] == ["boards", "card", "stroke-line"]


def test_bad_supply_is_seen_by_the_restart_that_it_causes() -> None:
    with emulated_bench(["battery-weak"]) as (bench, _):
        allowed = bench.sequencer.settings().settings
        bench.sequencer.write_settings(replace(allowed, moving_at_once=2))
        acceptance = accept(bench, ("motion", "switches", "servos", "supply"))
        assert bench.sequencer.settings().settings.moving_at_once == 2
    (supply,) = acceptance.steps[-1].checks
    assert supply.blocks
    assert "restarted when 2 started at once" in supply.sentence
    assert "brown out" in supply.sentence


def test_a_smaller_robot_is_accepted_by_what_it_has(tmp_path: Path) -> None:
    robot = smaller_robot(tmp_path, bodies=3, without_imu=[2])
    with emulated_bench(robot=robot) as (bench, emulated):
        acceptance = accept(bench)
        assert not [check.sentence for check in acceptance.checks if check.blocks]
        (answering,) = (check for check in acceptance.checks if check.name == "imus-answer")
        assert (
            answering.sentence
            == "IMUs: 2 of 2 answer. Absent by the robot file: body 4, joint 3, IMU of body 2."
        )
        emulated.faults.imu(3, "dead")
        (answering, _) = accept(bench, ["rest"]).checks
        assert answering.sentence.startswith("IMUs: IMU 3 (")
        assert "does not answer" in answering.sentence
