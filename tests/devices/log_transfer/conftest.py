from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.devices.log_transfer.bench import Bench


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    """Yield a bench: a robot with its logger, in virtual time."""
    with Bench(tmp_path) as log_bench:
        yield log_bench
