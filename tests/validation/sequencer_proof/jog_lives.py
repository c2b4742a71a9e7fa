"""Campaign 7: random lives of JOG. A joint moves only while somebody asks, within its limits, and is let go in time."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from tests.fixtures.sequencer.board import AvrBoard, ResetCause
from tests.fixtures.sequencer.cable import connect
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import Bench, pin_edges
from tests.validation.sequencer_proof.link import QUESTION
from tests.validation.sequencer_proof.signals import CYCLES_PER_US, Pulse, whole_pulses
from tfsat_host.protocol.framing import Frame, encode_frame
from tfsat_host.protocol.limits import JOG_CONFIRM, JOG_IDLE_MS, JOG_SPEED_CDEG_S, JOINT_COUNT
from tfsat_host.protocol.messages import ArmRequest, DisarmRequest, JogRequest, ServoSetting
from tfsat_host.servo_settings import ServoSettings

LIFE_US = 6_000_000
IDLE_US = JOG_IDLE_MS * 1000
TAKEN_US = 25_000
"""From an order, or from what ends a jog, to the pulses that show it: a frame, and USB's millisecond."""
GONE_US = 10_000
"""A pulled cable is one without traffic for 3 ms; a closed port is told by a control transfer."""
START_US = 500_000
"""After a reset the board reads its own image before it answers."""
FILLING = (98, 112)
"""Questions whose answers just fill the host's buffer, or the chip's as well."""
NS_PER_TICK = 500
WIDTH_TOLERANCE_TICKS = 1
SPEED_TOLERANCE_CDEG = 20


class Order(NamedTuple):
    """A JOG with the flag, of a joint that there is, to an angle within its limits: somebody asks.

    `read_us`: when the board has read it at the latest; later than `t_us` behind answers that were left.
    """

    t_us: int
    read_us: int
    joint: int
    from_cdeg: int
    to_cdeg: int


class End(NamedTuple):
    """Something that ends every jog: DISARM, a closed port, a pulled cable, a reset."""

    t_us: int
    what: str


@dataclass(slots=True)
class Life:
    """What was asked in one life, and what came of it.

    Attributes:
        orders: All that may move a joint.
        ends: All that let go.
    """

    orders: list[Order] = field(default_factory=list)
    ends: list[End] = field(default_factory=list)


class Lives(NamedTuple):
    """Some lives.

    Attributes:
        lives: How many.
        orders: That asked for a move.
        ends: DISARMs, closed ports, pulled cables, resets.
        jogs: Times that a joint got pulses.
        pulses: In all.
    """

    lives: int
    orders: int
    ends: int
    jogs: int
    pulses: int


def jog_lives(bench: Bench, seed: int, count: int) -> Lives:
    """Live `count` random lives. Raises Broken where a joint moved that nobody asked for, or otherwise than asked."""
    totals = Counter[str]()
    for number in range(seed, seed + count):
        rng = random.Random(number)
        board = bench.board()
        settings = _draw_settings(rng)
        connect(board).write_settings(settings)
        pin_edges(board)
        life = _Operator(board, rng, settings).live()
        edges = pin_edges(board)
        board.close()
        trains = [whole_pulses(edges, pin) for pin in range(JOINT_COUNT)]
        try:
            jogs = check_life(life, trains, settings)
        except Broken as error:
            raise Broken(f"life {number}: {error}") from error
        pulses = sum(map(len, trains))
        totals += Counter(orders=len(life.orders), ends=len(life.ends), jogs=jogs, pulses=pulses)
    return Lives(count, totals["orders"], totals["ends"], totals["jogs"], totals["pulses"])


def jog_row(parts: Sequence[Lives]) -> tuple[int, ...]:
    """Sum up all lives."""
    return tuple(sum(column) for column in zip(*parts, strict=True))


def _draw_settings(rng: random.Random) -> ServoSettings:
    servos = []
    for _ in range(JOINT_COUNT):
        reverse = rng.randrange(2)
        servos.append(
            ServoSetting(2_000 if reverse else 1_000, 11_111, reverse, 0, rng.randrange(2_000, 9_001))
        )
    return ServoSettings(20_000, tuple(servos))


# ------------------------------------------------------------------ lives


@dataclass(slots=True)
class _Operator:
    """Somebody at the cable who does anything."""

    board: AvrBoard
    rng: random.Random
    settings: ServoSettings
    life: Life = field(default_factory=Life)
    sequence: int = 0
    answers_us: int = 0

    def live(self) -> Life:
        acts: tuple[tuple[Callable[[], None], int], ...] = (
            (self._jog, 8),
            (self._order_once, 3),
            (self._order_wrongly, 2),
            (self._disarm, 2),
            (self._close_port, 2),
            (self._pull_cable, 1),
            (self._reset, 1),
            (self._move_switches, 2),
            (self._send_noise, 1),
            (self._stop_reading, 1),
        )
        ends_us = self.board.now_us + LIFE_US
        while self.board.now_us < ends_us:
            (act,) = self.rng.choices([act for act, _ in acts], [weight for _, weight in acts])
            act()
            self.board.read()
        # Whatever was asked last is over by then.
        self.board.run(IDLE_US + 2 * TAKEN_US)
        return self.life

    def _send(self, request: bytes, kind: int) -> bool:
        # A port that is not there takes nothing: what waits for it would be sent later than it was asked.
        if not self.board.link_ready:
            return False
        self.sequence = (self.sequence + 1) % 256
        self.board.write(encode_frame(Frame(kind, self.sequence, request)))
        return True

    def _order(self, order: Order) -> None:
        request = JogRequest(order.joint, order.from_cdeg, order.to_cdeg, JOG_CONFIRM)
        if self._send(request.encode(), JogRequest.TYPE):
            read_us = max(self.board.now_us, self.answers_us)
            self.life.orders.append(order._replace(t_us=self.board.now_us, read_us=read_us))

    def _draw_order(self, joint: int) -> Order:
        servo = self.settings.of(joint)
        angles_cdeg = [self.rng.randint(servo.min_cdeg, servo.max_cdeg) for _ in range(2)]
        return Order(0, 0, joint, *angles_cdeg)

    def _jog(self) -> None:
        order = self._draw_order(self.rng.randint(1, JOINT_COUNT))
        for _ in range(self.rng.randint(2, 8)):
            self._order(order)
            self.board.run(self.rng.randint(5_000, 400_000))
            self.board.read()
            # Now and then another target, or another joint, which is refused.
            if self.rng.random() < 0.3:
                order = order._replace(to_cdeg=self._draw_order(order.joint).to_cdeg)
            if self.rng.random() < 0.1:
                self._order(self._draw_order(self.rng.randint(1, JOINT_COUNT)))

    def _order_once(self) -> None:
        self._order(self._draw_order(self.rng.randint(1, JOINT_COUNT)))
        self.board.run(self.rng.randint(1_000, 1_500_000))

    def _order_wrongly(self) -> None:
        joint = self.rng.randint(1, JOINT_COUNT)
        order, servo = self._draw_order(joint), self.settings.of(joint)
        wrong = self.rng.choice(
            (
                JogRequest(joint, order.from_cdeg, order.to_cdeg, JOG_CONFIRM ^ 1),
                JogRequest(self.rng.choice((0, 4, 255)), order.from_cdeg, order.to_cdeg, JOG_CONFIRM),
                JogRequest(joint, order.from_cdeg, servo.max_cdeg + 1, JOG_CONFIRM),
                JogRequest(joint, order.from_cdeg, servo.min_cdeg - 1, JOG_CONFIRM),
            )
        )
        self._send(wrong.encode(), JogRequest.TYPE)
        # No token of so young a board.
        self._send(ArmRequest(self.rng.randrange(0x8000, 0x10000)).encode(), ArmRequest.TYPE)
        self.board.run(self.rng.randint(1_000, 300_000))

    def _end(self, what: str, delay_us: int = 0) -> None:
        self.life.ends.append(End(self.board.now_us + delay_us, what))

    def _disarm(self) -> None:
        if self._send(DisarmRequest().encode(), DisarmRequest.TYPE):
            self._end("DISARM")
        self.board.run(self.rng.randint(1_000, 300_000))

    def _close_port(self) -> None:
        if not self.board.link_ready:
            return
        self.board.port(False)
        self._end("closed port", GONE_US)
        self.board.run(self.rng.randint(2 * GONE_US, 500_000))
        self.board.port(True)
        self.board.run(self.rng.randint(5_000, 50_000))

    def _pull_cable(self) -> None:
        self.board.cable(False)
        self._end("pulled cable", GONE_US)
        self.board.run(self.rng.randint(2 * GONE_US, 500_000))
        self.board.cable(True)
        self.board.run(self.rng.randint(50_000, 200_000))

    def _reset(self) -> None:
        self.board.reset(self.rng.choice((ResetCause.WATCHDOG, ResetCause.BROWN_OUT)))
        self._end("reset")
        self.answers_us = self.board.now_us + START_US
        self.board.run(self.rng.randint(1_000, 800_000))

    def _move_switches(self) -> None:
        for index in range(2):
            self.board.switch(index, closed=self.rng.random() < 0.5)
            self.board.run(self.rng.randint(10, 100_000))

    def _send_noise(self) -> None:
        if self.board.link_ready:
            self.board.write(self.rng.randbytes(self.rng.randint(1, 64)) + b"\0")
        self.board.run(self.rng.randint(1_000, 50_000))

    def _stop_reading(self) -> None:
        """Leave all answers: the board's next ones wait, and with them what is asked after them."""
        if not self.board.link_ready:
            return
        for _ in range(self.rng.randint(*FILLING)):
            self.board.write(QUESTION)
            self.board.run(2_000)
        first = len(self.life.orders)
        for _ in range(self.rng.randint(0, 2)):
            self._order(self._draw_order(self.rng.randint(1, JOINT_COUNT)))
        self.board.run(self.rng.randint(0, 1_500_000))
        if self.rng.random() < 0.5:
            # What the board has not read goes with the port.
            self._close_port()
            first = len(self.life.orders)
        # The board reads on once its answers are taken.
        while self.board.read():
            self.board.run(5_000)
        waiting = self.life.orders[first:]
        self.life.orders[first:] = [order._replace(read_us=self.board.now_us) for order in waiting]


# ------------------------------------------------------------------ judged


class _Driven(NamedTuple):
    """A pulse of one joint, microseconds."""

    t_us: float
    joint: int
    pulse: Pulse


def check_life(life: Life, trains: Sequence[Sequence[Pulse]], settings: ServoSettings) -> int:
    """Check each pulse of a life; return how often a joint was taken up. Raises Broken."""
    driven = sorted(
        _Driven(pulse.rise / CYCLES_PER_US, joint, pulse)
        for joint, train in enumerate(trains, start=1)
        for pulse in train
    )
    jogs = 0
    before: _Driven | None = None
    for now in driven:
        _check_asked(life, now)
        if _cut_by_reset(life, now):
            continue
        _check_angle(life, now, settings)
        taken_up = (
            before is None or before.joint != now.joint or now.t_us - before.t_us > 3 * settings.frame_us
        )
        if before is not None and not _let_go(life, before, now):
            if before.joint != now.joint:
                raise Broken(f"joint {now.joint} moves while joint {before.joint} is held, at {now.t_us} us")
            _check_speed(before, now, settings)
        jogs += taken_up
        before = now
    return jogs


def _check_asked(life: Life, now: _Driven) -> None:
    """Require an order for this joint within the last second, and nothing since that lets go."""
    for order in life.orders:
        if order.joint != now.joint or not order.t_us <= now.t_us <= order.read_us + IDLE_US + TAKEN_US:
            continue
        if not any(order.t_us <= end.t_us < now.t_us - TAKEN_US for end in life.ends):
            return
    last = max((order.t_us for order in life.orders if order.t_us <= now.t_us), default=0)
    raise Broken(
        f"joint {now.joint} is driven at {now.t_us} us, and nobody asks; the last order came at {last} us"
    )


def _let_go(life: Life, before: _Driven, now: _Driven) -> bool:
    """Tell whether a jog may have ended between two pulses, so that another one began."""
    start_us = before.t_us - 2 * TAKEN_US
    if any(start_us <= end.t_us <= now.t_us for end in life.ends):
        return True
    stalled = [order for order in life.orders if order.t_us < order.read_us]
    if any(order.t_us <= now.t_us and start_us <= order.read_us + TAKEN_US for order in stalled):
        return True
    # By a second without orders.
    asked = [order.t_us for order in life.orders if order.joint == before.joint and order.t_us <= now.t_us]
    gaps = zip(asked, [*asked[1:], now.t_us], strict=True)
    return any(after - first >= IDLE_US - TAKEN_US and after >= start_us for first, after in gaps)


def _cut_by_reset(life: Life, now: _Driven) -> bool:
    ends_us = now.t_us + now.pulse.width / CYCLES_PER_US
    return any(end.what == "reset" and now.t_us <= end.t_us <= ends_us + 1 for end in life.ends)


def _angle_cdeg(pulse: Pulse, servo: ServoSetting) -> float:
    change_ns = pulse.width * 1000 / CYCLES_PER_US - servo.zero_us * 1000
    return (-change_ns if servo.reversed else change_ns) * 100 / servo.ns_per_deg


def _check_angle(life: Life, now: _Driven, settings: ServoSettings) -> None:
    """Require an angle between those that were named in the orders of the last two seconds before this jog."""
    servo = settings.of(now.joint)
    tolerance_cdeg = WIDTH_TOLERANCE_TICKS * NS_PER_TICK * 100 / servo.ns_per_deg
    named = [
        angle_cdeg
        for order in life.orders
        if order.joint == now.joint and order.t_us <= now.t_us
        for angle_cdeg in (order.from_cdeg, order.to_cdeg)
    ]
    angle_cdeg = _angle_cdeg(now.pulse, servo)
    if not min(named) - tolerance_cdeg <= angle_cdeg <= max(named) + tolerance_cdeg:
        raise Broken(f"joint {now.joint} at {angle_cdeg} cdeg, ordered between {min(named)} and {max(named)}")


def _check_speed(before: _Driven, now: _Driven, settings: ServoSettings) -> None:
    servo = settings.of(now.joint)
    change_cdeg = abs(_angle_cdeg(now.pulse, servo) - _angle_cdeg(before.pulse, servo))
    most_cdeg = JOG_SPEED_CDEG_S * (now.t_us - before.t_us) / 1e6 + SPEED_TOLERANCE_CDEG
    if change_cdeg > most_cdeg:
        raise Broken(f"joint {now.joint} moves {change_cdeg} cdeg within {now.t_us - before.t_us} us")
