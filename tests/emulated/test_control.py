"""Control lines against a robot in virtual time."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.emulated.control import MAX_LINE_BYTES, ControlLines, LineTooLong
from tfsat_host.emulated.server import RobotServer


class Person:
    """Types lines and has patience."""

    def __init__(self, server: RobotServer) -> None:
        self.server = server
        self.lines = ControlLines(server)

    def __call__(self, line: str) -> str:
        self.lines.feed(line.encode() + b"\n")
        while True:
            replies = self.lines.replies()
            if replies:
                (reply,) = replies
                return reply
            self.server.step()

    def values(self, line: str) -> list[str]:
        word, *values = self(line).split()
        assert word == "ok"
        return values


@pytest.fixture
def person(server: RobotServer) -> Person:
    return Person(server)


def test_waiting_passes_virtual_time(person: Person) -> None:
    assert person("time") == "ok 0.000000 still"
    assert person("wait 20ms") == "ok"
    # To the microsecond: virtual time has no drift.
    assert person("time") == "ok 0.020000 still"


def test_swinging_moves_the_joint_and_comes_back(person: Person) -> None:
    assert person("hold 2 3 4") == "ok"
    assert person("swing 1 60 2s 1") == "ok for 2 s"
    # Half of a swing of 2 s: the joint is at its farthest.
    assert person("wait 1") == "ok"
    assert person.values("time")[1] == "swinging"
    assert float(person.values("angles")[0]) == pytest.approx(60.0, abs=1.0)
    assert person("wait still") == "ok"
    assert float(person.values("time")[0]) == pytest.approx(2.0, abs=0.01)
    assert float(person.values("angles")[0]) == pytest.approx(0.0, abs=0.5)


def test_a_drop_lands_and_nobody_touches_the_robot_meanwhile(person: Person) -> None:
    assert person("drop 500ms") == "ok falls for 0.5 s"
    assert person("wait 0.1") == "ok"
    assert person.values("time")[1] == "falling"
    # Whoever touches a falling robot would be part of the drop.
    for line in ("hold 1", "seat", "swing 1 10 1 1", "sweep 1", "close 1", "open 1 45", "turn z 90", "drop"):
        assert person(line).startswith("error The robot is falling")
    assert person("wait still") == "ok"
    assert float(person.values("time")[0]) == pytest.approx(0.5, abs=0.02)
    assert person("seat") == "ok"


def test_a_wait_holds_back_the_same_sender_only(server: RobotServer) -> None:
    patient, quick = ControlLines(server), ControlLines(server)
    # The second line waits behind the first one.
    patient.feed(b"wait 5ms\nangles\n")
    quick.feed(b"time\n")
    assert patient.replies() == []
    assert not patient.done
    assert quick.replies() == ["ok 0.000000 still"]
    # A step is a millisecond.
    for _ in range(5):
        server.step()
    assert patient.replies() == ["ok", "ok 0.00 0.00 0.00"]
    assert patient.done


@pytest.mark.parametrize(
    ("line", "plugged"), [("power {} off", "power {} on"), ("cable {} pull", "cable {} plug")]
)
@pytest.mark.parametrize("board", ["sequencer", "logger"])
def test_without_power_or_cable_there_is_no_port(
    person: Person, tmp_path: Path, board: str, line: str, plugged: str
) -> None:
    link = tmp_path / "robot" / board
    assert link.is_char_device()
    assert person(line.format(board)) == "ok"
    # No dangling link either: a program must see that there is no board.
    assert not link.is_symlink()
    assert person(plugged.format(board)) == "ok"
    assert link.is_char_device()


def test_a_plugged_cable_of_a_board_without_power_is_no_port(person: Person, tmp_path: Path) -> None:
    person("power logger off")
    person("cable logger pull")
    person("cable logger plug")
    assert not (tmp_path / "robot" / "logger").is_symlink()


def test_switches_reach_the_boards(
    server: RobotServer, person: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[tuple[object, ...]] = []
    # What the lines call, without letting it happen.
    monkeypatch.setattr(server.robot, "knock", lambda *values: calls.append(("knock", *values)))
    monkeypatch.setattr(server.robot, "set_switch", lambda *values: calls.append(("switch", *values)))
    for line in ("knock 1 20ms", "knock 2 0.5", "release 1", "press 1"):
        assert person(line) == "ok"
    assert calls == [("knock", 1, 20_000), ("knock", 2, 500_000), ("switch", 1, False), ("switch", 1, True)]


def test_help_names_every_command(person: Person) -> None:
    assert person("help") == person("HELP")
    for word in ("hold", "swing", "sweep", "close", "open", "turn", "seat", "press", "release", "knock", "power",
                 "cable", "reset", "fault", "drop", "angles", "card", "time", "wait", "quit"):  # fmt: skip
        assert word in person("help")


def test_a_joint_that_was_left_open_is_closed_by_hand(person: Person) -> None:
    assert person("swing 2 40 2 1") == "ok for 2 s"
    assert person("wait 1") == "ok"
    assert float(person.values("angles")[1]) == pytest.approx(40.0, abs=1.0)
    assert person("close 2") == "ok"
    assert person("open 3 45") == "ok"
    assert person("angles") == "ok 0.00 0.00 45.00"
    assert person("open 3 145").startswith("error")
    assert person("close 3") == "ok"
    assert person.values("angles") == ["0.00", "0.00", "0.00"]
    assert person("close 4").startswith("error")


def test_quit_stops(server: RobotServer, person: Person) -> None:
    assert not server.stopping
    assert person("quit") == "ok"
    assert server.stopping


def test_it_stops_by_itself(server: RobotServer) -> None:
    server.stop_after(0.003)
    steps = 0
    while not server.stopping:
        server.step()
        steps += 1
    # Three steps of a millisecond each.
    assert steps == 3


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("dance", "no command 'dance'"),
        ("hold", "Write: hold BODY"),
        ("hold 5", "bodies 1 to 4"),
        ("hold x", "'x' is not understood as BODY"),
        # A superscript digit is a digit to Python's isdigit, but no number.
        ("hold ²", "'²' is not understood"),
        ("swing 1 60 2.0", "Write: swing"),
        ("swing 4 60 2 1", "no such joint"),
        ("swing 0 60 2 1", "no such joint"),
        ("swing 1 400 2 1", "would leave its range"),
        ("swing 1 nan 2 1", "'nan' is not understood as DEGREES"),
        ("swing 1 60 0 1", "out of range"),
        ("swing 1 60 2 0", "1 to 1000 cycles"),
        ("sweep", "Write: sweep JOINT"),
        ("sweep 4", "no joint 4"),
        ("turn z", "Write: turn x|y|z DEGREES"),
        ("turn w 90", "'w' is not understood as x|y|z"),
        ("turn z 0", "at most 720 deg"),
        ("turn z 721", "at most 720 deg"),
        ("turn z much", "'much' is not understood"),
        ("turn z 90 0", "1 to 100 rounds"),
        ("press 3", "'3' is not understood as 1|2"),
        ("knock 1 20min", "'20min' is not understood as KNOCK: seconds, or such as 20ms"),
        ("knock 1 -1", "'-1' is not understood"),
        ("knock 1 60", "at most 10 s"),
        ("power robot off", "'robot' is not understood as sequencer|logger"),
        ("power logger of", "'of' is not understood as on|off"),
        ("cable logger on", "plug|pull"),
        ("reset", "Write: reset watchdog|brown-out|button"),
        ("reset power", "'power' is not understood as watchdog|brown-out|button"),
        ("fault", "Write: fault none|imu"),
        (
            "fault me",
            "no command 'fault me'. none, imu, battery, bus, angle, servo, switch, wire, bounce, card, clock",
        ),
        ("fault imu", "Write: fault imu BODY dead|frozen|saturated|glitch|swapped|none"),
        ("fault imu 5 dead", "no body 5"),
        ("fault imu 1 tired", "'tired' is not understood as dead|frozen"),
        ("fault imu 1 swapped", "swapped with that of another body"),
        ("fault imu 1 dead 2", "swapped with that of another body"),
        ("fault bus 1 dead", "'dead' is not understood as stuck|none"),
        ("fault angle 1 turned", "turned magnet has an angle"),
        ("fault angle 1 turned far", "'far' is not understood"),
        ("fault servo 1 fast", "not understood as dead|slow|reversed"),
        ("fault switch 1 stuck", "not understood as stuck-closed|stuck-open"),
        ("fault bounce 2s", "at most 1 s"),
        ("fault card 400", "at most 100 s"),
        ("fault clock logger 1e6", "'1e6' is not understood as PPM"),
        ("fault clock logger 30000", "only by 20000 either way"),
        ("fault clock robot 1", "'robot' is not understood as sequencer|logger"),
        ("fault none now", "Write: fault none"),
        ("drop soon", "'soon' is not understood"),
        ("drop 1e9", "not understood"),
        ("card", "no recording on the card"),
        ("wait", "Write: wait"),
        ("time now", "Write: time"),
        ('card "x', "no closing quotation"),
    ],
)
def test_a_bad_line_says_why(person: Person, line: str, reason: str) -> None:
    reply = person(line)
    assert reply.startswith("error ")
    assert reason in reply
    assert "\n" not in reply


def test_empty_lines_and_comments_get_no_reply(server: RobotServer) -> None:
    lines = ControlLines(server)
    # Comments, blank lines and Windows line ends cost no reply.
    lines.feed(b"\n  \n# a remark\r\ntime # now\r\n")
    assert lines.replies() == ["ok 0.000000 still"]


@given(data=st.data(), text=st.binary(max_size=200))
def test_any_bytes_give_one_reply_a_line_however_they_are_cut(
    server: RobotServer, data: st.DataObject, text: bytes
) -> None:
    uncut_lines, cut = ControlLines(server), ControlLines(server)
    text += b"\n"
    uncut_lines.feed(text)
    # The same bytes in pieces: a stream has no message boundaries.
    at = sorted(data.draw(st.lists(st.integers(0, len(text)), max_size=5)))
    for start, end in zip([0, *at], [*at, len(text)], strict=True):
        cut.feed(text[start:end])
    replies = uncut_lines.replies()
    assert cut.replies() == replies
    # Random bytes are no command: each line gets an error, and nothing crashes.
    assert all(reply.startswith("error ") for reply in replies)
    assert len(replies) <= text.count(b"\n")


def test_a_sender_without_line_ends_is_not_listened_to_for_ever(server: RobotServer) -> None:
    lines = ControlLines(server)
    # Just short of the limit: only the next byte is too many.
    lines.feed(b"x" * MAX_LINE_BYTES)
    with pytest.raises(LineTooLong):
        lines.feed(b"x")


def test_a_sweep_rests_at_its_stops_and_ends_where_it_began(person: Person) -> None:
    assert person("hold 2 3 4") == "ok"
    assert person("sweep 1") == "ok for 32 s"
    assert person("wait 3") == "ok"
    # In the rest at the first stop.
    assert person("angles") == "ok 30.00 0.00 0.00"
    assert person("wait 5") == "ok"
    assert person("angles") == "ok 90.00 0.00 0.00"
    assert person.values("time")[1] == "swinging"
    assert person("wait still") == "ok"
    assert float(person.values("time")[0]) == pytest.approx(32.0, abs=0.01)
    assert person("angles") == "ok 0.00 0.00 0.00"


def test_a_turn_takes_all_bodies_there_and_back(server: RobotServer, person: Person) -> None:
    server.robot.record_truth(10_000)
    assert person("turn z -90 1") == "ok for 8.4 s"
    assert person("wait 3.5") == "ok"
    assert person.values("time")[1] == "swinging"
    # Columns 4 to 20: a quaternion for each body.
    body_1_to_4 = server.robot.truth()[-1, 4:20].reshape(4, 4)
    for attitude in body_1_to_4:
        assert attitude == pytest.approx([0, 0, -(0.5**0.5), 0.5**0.5], abs=1e-9)
    assert person("wait still") == "ok"
    assert float(person.values("time")[0]) == pytest.approx(8.4, abs=0.01)
    # Back where it began, whichever sign the quaternion has.
    assert abs(server.robot.truth()[-1, 7]) == pytest.approx(1.0)


def test_a_hold_ends_a_turn(person: Person) -> None:
    assert person("turn y 90") == "ok for 21.2 s"
    assert person("wait 2") == "ok"
    assert person("hold 1 2 3 4") == "ok"
    assert person.values("time")[1] == "still"
