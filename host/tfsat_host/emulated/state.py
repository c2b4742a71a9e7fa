"""What an emulated robot keeps between two commands: the sequencer's EEPROM."""

from __future__ import annotations

import tempfile
from pathlib import Path

from tfsat_host.emulated.robot import EEPROM_BYTES
from tfsat_host.errors import TfsatError


def eeprom_path() -> Path:
    """Where the EEPROM of `--emulated` lives, in the user's state directory."""
    import platformdirs

    return Path(platformdirs.user_state_dir("tfsat")) / "emulated" / "sequencer.eeprom"


def load_eeprom(path: Path) -> bytes | None:
    """The stored image, or None before the first command.

    Raises:
        TfsatError: the file is not an EEPROM image.
    """
    try:
        image = path.read_bytes()
    except FileNotFoundError:
        return None
    if len(image) != EEPROM_BYTES:
        raise TfsatError(
            what=f"{path} has {len(image)} bytes; the sequencer's EEPROM has {EEPROM_BYTES}.",
            meaning="The emulated sequencer's memory is damaged; no real board is concerned.",
            next_step=f"Delete {path} and run the command again.",
        )
    return image


def save_eeprom(path: Path, image: bytes) -> None:
    """Replaces the stored image at once: a reader finds the old one or the new one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as file:
        file.write(image)
    Path(file.name).replace(path)
