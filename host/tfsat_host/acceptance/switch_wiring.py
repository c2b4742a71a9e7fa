"""Which release switch reaches which pin of which board: from what both boards see while each is pressed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tfsat_host.acceptance.wires import BOARD_NAMES, SWITCH_PINS
from tfsat_host.preflight.preflight_check import PreflightCheck, judge
from tfsat_host.protocol.limits import SWITCH_COUNT

Closed = tuple[bool, ...]
"""Whether a pin was closed while no switch was pressed, switch 1, switch 2."""


def check_switches(seen_open: Sequence[Mapping[str, int]]) -> PreflightCheck:
    """Check that each pin follows its own switch.

    Args:
        seen_open: By board its `switches_open`: with no switch pressed, with switch 1 pressed, with switch 2.
    """
    closed: dict[str, list[Closed]] = {
        board: [tuple(not seen[board] >> pin & 1 for seen in seen_open) for pin in range(SWITCH_COUNT)]
        for board in SWITCH_PINS
    }
    wrong = _of_both_boards(closed) or [
        sentence for board in SWITCH_PINS for sentence in _of_one_board(board, closed[board])
    ]
    return judge(
        wrong,
        "Release switches: {}.",
        "Correct the wiring, then repeat the step.",
        "Release switches: both boards see each open and close.",
        closed={board: [list(pin) for pin in pins] for board, pins in closed.items()},
    )


def _of_both_boards(closed: Mapping[str, Sequence[Closed]]) -> list[str]:
    """Name what both boards see alike: it is at the switch, not at a board's pin."""
    sequencer, logger = (closed[board] for board in SWITCH_PINS)
    if sequencer != logger:
        return []
    if sequencer == [_only(1), _only(0)]:
        return ["switches 1 and 2 are exchanged at both boards"]
    wrong = []
    for pin, shown in enumerate(sequencer):
        if all(shown):
            wrong.append(f"switch {pin + 1} never opens: stuck, or its cable is shorted")
        elif not any(shown):
            wrong.append(f"switch {pin + 1} never closes: stuck, or its cable is cut")
    return wrong


def _of_one_board(board: str, closed: Sequence[Closed]) -> list[str]:
    pins, name = SWITCH_PINS[board], BOARD_NAMES[board]
    if list(closed) == [_only(1), _only(0)]:
        return [f"the wires of switches 1 and 2 are swapped at the {name} (pins {pins[0]} and {pins[1]})"]
    wrong = []
    for pin, shown in enumerate(closed):
        if shown == _only(pin):
            continue
        does = "never opens" if all(shown) else "never closes" if not any(shown) else "follows another switch"
        wrong.append(f"switch {pin + 1} {does} at the {name}: the wire to pin {pins[pin]}")
    return wrong


def _only(switch: int) -> Closed:
    """Return what a pin shows that follows this switch, from 0, alone."""
    return tuple(pressed == switch for pressed in (None, *range(SWITCH_COUNT)))
