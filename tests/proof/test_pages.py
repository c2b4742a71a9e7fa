"""Each proof page is of what is here, and a campaign that fails leaves its page as it was."""

from __future__ import annotations

import pytest

from tests.proof.pages import PROVED, SEQUENCER_HEX, stale


@pytest.mark.parametrize("page", PROVED)
def test_the_page_is_of_what_is_here(page: str) -> None:
    assert SEQUENCER_HEX.exists(), "make firmware"
    assert not stale(page), f"docs/{page}.md proves other code than this. Run: make prove"
