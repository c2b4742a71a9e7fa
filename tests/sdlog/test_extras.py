"""A format whose library is not installed says what to install, before anything is written."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sdlog.encoder import recording
from tests.sdlog.test_values import write
from tfsat_host.run.decoded import FORMATS, write_decoded
from tfsat_host.sdlog import errors as extras
from tfsat_host.sdlog import load
from tfsat_host.sdlog.errors import MissingExtraError


@pytest.mark.parametrize("name", ["parquet", "mcap"])
def test_missing_extra(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(extras.MODULES, name, ("a_module_that_nobody_has",))
    log = load(write(tmp_path / "SD.bin", recording(2).image()))
    with pytest.raises(MissingExtraError) as caught:
        write_decoded(log, tmp_path / "SD", ("csv", name), force=False)
    assert caught.value.next_step == f"In tfsat's folder: python -m pip install '.[{name}]'"
    assert [path.name for path in tmp_path.iterdir()] == ["SD.bin"]
    # Formats that need nothing can be written, and looking for what stands there needs no extra either.
    write_decoded(log, tmp_path / "SD", [other for other in FORMATS if other != name], force=False)


def test_every_module_of_an_extra_is_installed_here() -> None:
    for name in extras.MODULES:
        extras.check_extra(name)
