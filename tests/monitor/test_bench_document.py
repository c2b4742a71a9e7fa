"""The examples of docs/bench.md do what they say."""

from __future__ import annotations

import shlex

from tests.cli.process import RunCli
from tests.cli.test_documentation import ROOT, shell_examples


def test_its_examples_run(tfsat_host: RunCli) -> None:
    examples = shell_examples(ROOT / "docs" / "bench.md")
    assert len(examples) == 2
    for example in examples:
        program, *arguments = shlex.split(example)
        assert program == "tfsat-host"
        tfsat_host(*arguments)
