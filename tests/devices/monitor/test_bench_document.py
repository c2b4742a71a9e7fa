"""The examples of docs/bench.md do what they say."""

from __future__ import annotations

import shlex

from tests.cli.process import RunCli
from tests.cli.test_documentation import shell_examples
from tests.paths import REPOSITORY
from tfsat_host.protocol.limits import JOG_IDLE_MS, JOG_SPEED_CDEG_S


def test_its_examples_run(tfsat_host: RunCli) -> None:
    examples = shell_examples(REPOSITORY / "docs" / "bench.md")
    assert len(examples) == 2
    for example in examples:
        # The first word of an example is the command itself.
        program, *arguments = shlex.split(example)
        assert program == "tfsat-host"
        tfsat_host(*arguments)


def test_it_says_how_soon_a_board_without_orders_stops_the_pulses() -> None:
    text = " ".join((REPOSITORY / "docs" / "bench.md").read_text(encoding="utf-8").split())
    assert f"the board stops the pulses {JOG_IDLE_MS / 1000:g} s after the last order" in text
    assert f"within {JOG_SPEED_CDEG_S / 100 * JOG_IDLE_MS / 1000:g} deg" in text
