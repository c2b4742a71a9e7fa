"""The archive: a ZIP whose bytes depend on nothing but its files' names and contents, and its unpacking.

ZIP is what every system has opened since 1989. Files are stored, not compressed: so the bytes do not hang on the
version of a compressor, a flipped bit spoils one file only, and what is large (calibration recordings) is compressed
already. An archive that comes from elsewhere is checked before a byte is written, and counted while it is.
"""

from __future__ import annotations

import hashlib
import io
import os
import re
import shlex
import shutil
import stat
import tempfile
import unicodedata
import zipfile
import zlib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, NoReturn

from tfsat_host.next_step import Advice, NextStep
from tfsat_host.run.bundle.manifest import (
    ENVIRONMENT,
    EVALUATION,
    MANIFEST,
    REPORT,
    BundleError,
    Manifest,
    parse_manifest,
)

MARKER = b"tfsat bundle, format 1"
"""The archive's comment: by it the command knows its own file."""
# The earliest time that ZIP knows, one mode and one system for all: the bytes depend on contents only.
_TIME = (1980, 1, 1, 0, 0, 0)
_MODE = stat.S_IFREG | 0o644
_UNIX = 3
_CHUNK_BYTES = 1 << 20
# Fixed part of a local file header (APPNOTE.TXT 4.3.7); name and extra field come after it.
_LOCAL_HEADER_BYTES = 30
# Bit 0 of the general purpose flags.
_ENCRYPTED = 0x1
_SHOWN = 8
_NOTHING = "Nothing was unpacked."
_TIGHT = "no bundle is packed so tightly"
# What zipfile and zlib raise where bytes were flipped or are missing.
_DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError)

PATH_CHARACTERS_MAX = 400
_PART_BYTES_MAX = 200
_FORBIDDEN = re.compile(r'[\x00-\x1f\x7f<>:"|?*\\]')
_UNSEEN = frozenset({"Cc", "Cf", "Zl", "Zp"})
"""Categories of Unicode: controls, marks that turn the direction of writing or have no width, and ends of lines."""
_DEVICE = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|com[0-9¹²³]|lpt[0-9¹²³])(\..*)?", re.IGNORECASE)
_SPECIAL = {
    stat.S_IFIFO: "is a pipe",
    stat.S_IFSOCK: "is a socket",
    stat.S_IFCHR: "is a device",
    stat.S_IFBLK: "is a device",
}


@dataclass(frozen=True, slots=True)
class Limits:
    """What no honest bundle exceeds.

    Attributes:
        files: Entries in the archive.
        bytes: Of all files, unpacked.
        ratio: Unpacked over packed, of each file above `free_bytes` and of all.
        free_bytes: Below, any ratio will do.
        manifest_bytes: Of the manifest, which is read into memory.
    """

    files: int = 10_000
    bytes: int = 16 << 30
    ratio: int = 200
    free_bytes: int = 1 << 20
    manifest_bytes: int = 16 << 20

    def is_bomb(self, size: int, packed: int) -> bool:
        """Return whether the unpacked and packed sizes in bytes suggest a decompression bomb."""
        return size > self.free_bytes and size > self.ratio * packed


LIMITS = Limits()


def trouble_with_name(name: str) -> str | None:
    """Why a file of that name must not be made, as the end of a sentence; None: it may be."""
    if not name or len(name) > PATH_CHARACTERS_MAX:
        return f"has {len(name)} characters"
    if name.startswith("/") or re.match(r"[A-Za-z]:", name):
        return "is absolute: it would be written outside of the folder"
    if _FORBIDDEN.search(name):
        return "holds a character that not every system allows in a name"
    # Invisible or direction-turning code points can make a name look like another.
    if any(unicodedata.category(character) in _UNSEEN for character in name):
        return "holds a character that cannot be seen"
    return next(filter(None, map(_trouble_with_part, name.split("/"))), None)


def _trouble_with_part(part: str) -> str | None:
    if part == "..":
        return "leads out of the folder by `..`"
    if part in ("", "."):
        return "has an empty part"
    # Windows drops dots and spaces at the end: two names would become one file.
    if part[-1] in ". " or part[0] == " ":
        return "has a part that ends in a dot or a space, or begins with one"
    # Reserved with any ending: CON.txt is the console.
    if _DEVICE.fullmatch(part):
        return "is a device on Windows"
    try:
        return "has a part that is too long" if len(part.encode()) > _PART_BYTES_MAX else None
    except UnicodeEncodeError:
        return "is no valid text"


def trouble_with_file(path: Path, root: Path) -> str | None:
    """Why what lies there must not be copied, as the end of a sentence; None: a file or a folder, and it may be.

    A link to a file in the same folder or below counts as that file. A link to a folder does not: it may lead round in
    a circle, and what it leads to is there without it.

    Args:
        path: In `root` or below.
        root: A person named it, so it may be a link itself.

    Raises:
        OSError: it cannot be looked at.
    """
    try:
        mode = path.stat().st_mode
    except OSError:
        if path.is_symlink():
            return "is a link that leads nowhere"
        raise
    # Compare real paths: any part of the path may be a link out of the folder.
    real = os.path.realpath(path)
    if not Path(real).is_relative_to(os.path.realpath(root)):
        return f"is a link that leads out of the folder, to {real}"
    if stat.S_ISDIR(mode):
        return "is a link to a folder" if path.is_symlink() else None
    return None if stat.S_ISREG(mode) else _SPECIAL.get(stat.S_IFMT(mode), "is no file")


def collision_among(names: Iterable[str]) -> tuple[str, str] | None:
    """Find two names that collide on some file system, or of which one is a folder of the other.

    Returns None if no names collide.
    """
    files: dict[str, str] = {}
    folders: dict[str, str] = {}
    for name in names:
        key = _fold_name(name)
        if key in files or key in folders:
            return files.get(key) or folders[key], name
        files[key] = name
        parts = name.split("/")
        for folder in ("/".join(parts[:depth]) for depth in range(1, len(parts))):
            key = _fold_name(folder)
            if key in files or folders.setdefault(key, folder) != folder:
                return files.get(key) or folders[key], name
    return None


def _fold_name(name: str) -> str:
    """Normalize a name as the least strict file system does: case-folded, in one Unicode normal form."""
    return unicodedata.normalize("NFC", unicodedata.normalize("NFKC", name).casefold())


def write_archive(path: Path, files: Mapping[str, Path]) -> None:
    """Writes the files by their names, sorted, all with one time and one mode. Raises OSError."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
        archive.comment = MARKER
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, _TIME)
            # The Unix mode is in the upper half of the external attributes.
            entry.create_system, entry.external_attr = _UNIX, _MODE << 16
            # Known beforehand, so that zipfile decides on ZIP64 before it writes the header.
            entry.file_size = files[name].stat().st_size
            with files[name].open("rb") as source, archive.open(entry, "w") as target:
                shutil.copyfileobj(source, target, _CHUNK_BYTES)


def unpack(archive: Path, folder: Path, limits: Limits = LIMITS) -> tuple[Manifest, str]:
    """Unpacks a bundle into a new folder, every file checked against the manifest; gives it, and its SHA-256.

    The folder appears whole or not at all.

    Raises:
        BundleError: the archive is no bundle, is not safe, or a file is not what the manifest says.
        OSError: something cannot be read or written.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise BundleError(
            what=f"{folder} exists and is not empty.",
            meaning=f"Files of two origins would mix. {_NOTHING}",
            next_step="Name a new folder with --out.",
        )
    try:
        with zipfile.ZipFile(archive) as opened:
            return _unpack(opened, archive, folder, limits)
    except (*_DAMAGE, NotImplementedError, ValueError, RuntimeError) as error:
        # zipfile raises NotImplementedError and RuntimeError for methods and encryption that it lacks.
        raise BundleError(
            what=f"{archive} is no ZIP archive, or it is damaged: {error}.",
            meaning=_NOTHING,
            next_step=Advice("Take the bundle from a copy; ", NextStep("bundle"), " makes one."),
        ) from error


def _unpack(opened: zipfile.ZipFile, archive: Path, folder: Path, limits: Limits) -> tuple[Manifest, str]:
    # The central directory first: names and sizes are judged before anything is unpacked.
    entries = _checked_entries(opened, archive, limits)
    if MANIFEST not in entries:
        _refuse(archive, f"has no {MANIFEST}: it is no bundle")
    # The manifest is read into memory: bound its size.
    if entries[MANIFEST].file_size > limits.manifest_bytes:
        _refuse(archive, f"has a {MANIFEST} of {entries[MANIFEST].file_size} bytes")
    buffer = io.BytesIO()
    manifest_sha256 = _extract(opened, entries[MANIFEST], buffer, archive)
    manifest = parse_manifest(buffer.getvalue(), str(archive))
    _check_listed(manifest, entries, archive)
    folder.parent.mkdir(parents=True, exist_ok=True)
    # Beside the target, so that the final rename stays on one file system.
    unpacked = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    try:
        (unpacked / MANIFEST).write_bytes(buffer.getvalue())
        # Check every file instead of stopping at the first: the error then names all the damage.
        wrong = [
            name
            for name, file in sorted(manifest.files.items())
            if not _is_extracted(opened, entries[name], unpacked / name, archive, file.sha256)
        ]
        if wrong:
            raise _damage_error(manifest, wrong, archive)
        with suppress(OSError):  # a file system without permissions keeps its own
            unpacked.chmod(0o755)
        if folder.exists():
            folder.rmdir()  # empty; Windows renames onto no folder
        unpacked.rename(folder)
    finally:
        shutil.rmtree(unpacked, ignore_errors=True)
    return manifest, manifest_sha256


def _is_extracted(
    opened: zipfile.ZipFile, entry: zipfile.ZipInfo, to: Path, archive: Path, sha256: str
) -> bool:
    """Extract a file and return whether its SHA-256 matches the manifest's.

    A damaged file gives False, so that the others are still checked.
    """
    to.parent.mkdir(parents=True, exist_ok=True)
    try:
        with to.open("xb") as target:
            return _extract(opened, entry, target, archive) == sha256
    except _DAMAGE:
        return False


def _extract(opened: zipfile.ZipFile, entry: zipfile.ZipInfo, target: BinaryIO, archive: Path) -> str:
    """Writes one file, never more than its stated size; gives the SHA-256 of what came."""
    digest, remaining_bytes = hashlib.sha256(), entry.file_size
    with opened.open(entry) as source:
        # One byte more than stated is asked for, so that a stream that goes on is caught and not written.
        while chunk := source.read(min(_CHUNK_BYTES, remaining_bytes + 1)):
            remaining_bytes -= len(chunk)
            if remaining_bytes < 0:
                _refuse(archive, f"holds {entry.filename!r}, which is longer than it says")
            digest.update(chunk)
            target.write(chunk)
    return digest.hexdigest()


def _damage_error(manifest: Manifest, wrong: list[str], archive: Path) -> BundleError:
    """Build the error that names the damaged files, those still intact, and how to recover them."""
    recording, count = manifest.evaluated.recording, len(manifest.files)
    is_single = len(wrong) == 1
    if recording in wrong:
        recording_text = (
            f"The raw log {recording} is damaged itself: decode uses every block of it that is whole."
        )
    else:
        recording_text = (
            f"The raw log {recording} is whole{', as is all else' if count > len(wrong) + 1 else ''}."
        )
    if set(wrong) <= {EVALUATION, REPORT, ENVIRONMENT}:
        recording_text += (
            f" What is damaged is no evidence: {'it' if is_single else 'they'} can be made again."
        )
    return BundleError(
        what=f"{len(wrong)} of {count} files in {archive} {'is' if is_single else 'are'} not what its manifest says: "
        f"{_list_names(wrong)}.",
        meaning=f"{'It was' if is_single else 'They were'} damaged or changed after the bundle was "
        f"made. {_NOTHING} {recording_text}",
        next_step=Advice(
            f"Take the bundle from a copy. Without one: unzip {shlex.quote(str(archive))} -d rescued gets the "
            "rest, and ",
            NextStep("bundle", ("rescued/run",)),
            " makes a new one of it.",
        ),
    )


def _checked_entries(opened: zipfile.ZipFile, archive: Path, limits: Limits) -> dict[str, zipfile.ZipInfo]:
    """Check the archive's entries against the limits and return its files by name.

    Folders are left out: they are created as needed.
    """
    listed = opened.infolist()
    if len(listed) > limits.files:
        _refuse(archive, f"holds {len(listed)} files; {limits.files} are allowed")
    for entry in listed:
        _check_entry(entry, archive, limits)
    entries = [entry for entry in listed if not entry.is_dir()]
    if collision := collision_among(entry.filename for entry in entries):
        first_name, two = collision
        _refuse(archive, f"holds {first_name!r} and {two!r}, which some system takes for one")
    # A bomb may be spread over many small entries: judge the sums as well.
    total, packed = sum(entry.file_size for entry in entries), sum(entry.compress_size for entry in entries)
    if total > limits.bytes:
        _refuse(archive, f"would unpack to {total} bytes; {limits.bytes} are allowed")
    if limits.is_bomb(total, packed):
        _refuse(archive, f"would unpack {packed} bytes to {total}: {_TIGHT}")
    # Files over each other unpack the same bytes many times (D. Fifield, A better zip bomb, 2019).
    end = 0
    for entry in sorted(entries, key=lambda entry: entry.header_offset):
        if entry.header_offset < end:
            _refuse(archive, f"holds {entry.filename!r}, which lies over another file")
        # A lower bound of the entry's extent: name and extra field are not counted.
        end = entry.header_offset + _LOCAL_HEADER_BYTES + entry.compress_size
    return {entry.filename: entry for entry in entries}


def _check_entry(entry: zipfile.ZipInfo, archive: Path, limits: Limits) -> None:
    name, size, packed = entry.orig_filename, entry.file_size, entry.compress_size
    trouble = trouble_with_name(name.removesuffix("/"))
    # zipfile cuts names at NUL and exchanges separators: what was checked must be what is written.
    if trouble is None and entry.filename != name:
        trouble = "is not written as it is read"
    if trouble:
        _refuse(archive, f"holds a file whose name {trouble}: {name[:200]!r}")
    # 0 where the archive has no Unix mode.
    kind = stat.S_IFMT(entry.external_attr >> 16)
    what = "a link" if kind == stat.S_IFLNK else "neither a file nor a folder"
    checks = (
        (kind not in (0, stat.S_IFDIR if entry.is_dir() else stat.S_IFREG), f"which is {what}"),
        (entry.is_dir() and size, "a folder with contents"),
        (entry.flag_bits & _ENCRYPTED, "which is encrypted"),
        (
            entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED),
            f"packed by method {entry.compress_type}; only 0 and 8 are read",
        ),
        (limits.is_bomb(size, packed), f"which would unpack {packed} bytes to {size}: {_TIGHT}"),
    )
    for wrong, words in checks:
        if wrong:
            _refuse(archive, f"holds {name!r}, {words}")


def _check_listed(manifest: Manifest, entries: dict[str, zipfile.ZipInfo], archive: Path) -> None:
    there, listed = entries.keys() - {MANIFEST}, manifest.files.keys()
    if there - listed:
        _refuse(
            archive, f"holds files that its manifest does not name: {_list_names(sorted(there - listed))}"
        )
    if listed - there:
        _refuse(archive, f"lacks files that its manifest names: {_list_names(sorted(listed - there))}")
    for name, file in manifest.files.items():
        if entries[name].file_size != file.bytes:
            says = f"{entries[name].file_size} bytes; its manifest says {file.bytes}"
            _refuse(archive, f"holds {name!r} with {says}")
    # What the evaluation is to be computed from must be in the bundle itself.
    for file_name in (manifest.evaluated.recording, *manifest.evaluated.files.values()):
        if file_name not in listed:
            _refuse(archive, f"was evaluated with {file_name!r}, which is not in it")


def _list_names(names: list[str]) -> str:
    listed_names = [name if name.isprintable() else repr(name) for name in names[:_SHOWN]]
    return ", ".join(listed_names) + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")


def _refuse(archive: Path, what: str) -> NoReturn:
    raise BundleError(
        what=f"{archive} {what}.",
        meaning=f"No tfsat-host made it so: it is damaged, or meant to do harm. {_NOTHING}",
        next_step="Ask whom you have it from for another copy, and for the manifest's SHA-256 from their logbook.",
    )
