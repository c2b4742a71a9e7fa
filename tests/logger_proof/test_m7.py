"""The core on a Cortex-M7 under QEMU: the same bytes on the card as on the PC, and how much it takes."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.emulator_avr.building import Edit
from tests.logger_proof.broken import Broken
from tests.logger_proof.building import INSTRUCTIONS, build_for_m7
from tests.logger_proof.instructions import count_instructions
from tests.logger_proof.m7 import SHORT_SEEDS, compare, twins


def test_the_card_holds_the_same_bytes_as_after_the_pcs_run(pc: Path, m7: Path) -> None:
    same = twins(pc, m7, [(seed, 1) for seed in SHORT_SEEDS])
    assert same.seeds == len(SHORT_SEEDS)
    assert same.bytes_compared > len(SHORT_SEEDS) * 1_000_000


@pytest.mark.prove
def test_a_core_that_depends_on_the_size_of_a_pointer_is_found(pc: Path, tmp_path: Path) -> None:
    edit = Edit(
        "core/request_server.cpp", "header.dlpf_cfg = settings.dlpf_cfg;", "header.dlpf_cfg = sizeof(void*);"
    )
    with pytest.raises(Broken, match="another than the PC's"):
        compare(pc, build_for_m7(tmp_path, edits=[edit]), SHORT_SEEDS[0], 1)


def test_sampling_leaves_the_processor_to_the_card(tmp_path: Path) -> None:
    counted = count_instructions(build_for_m7(tmp_path, INSTRUCTIONS), 1000)
    assert counted.sample.count == 10_000
    # Not an empty loop, and no more than a quarter of the 0.2 ms that timing.h leaves beside the buses.
    assert 1_000 < counted.core.mean < counted.core.most < 30_000
    assert counted.share < 0.02
