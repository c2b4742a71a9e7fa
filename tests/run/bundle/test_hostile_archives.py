"""Archives that anybody may have made: refused with words, and nothing is written outside of the folder, or at all."""

from __future__ import annotations

import hashlib
import io
import json
import re
import stat
import struct
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.run.bundle.commands import command
from tfsat_host.run.bundle.bundle_archive import LIMITS, Limits, collision_among, trouble_with_name, unpack
from tfsat_host.run.bundle.manifest import (
    BundledFile,
    BundleError,
    EvaluationInputs,
    Manifest,
    format_manifest,
    parse_manifest,
)

# 600 bytes: below every limit but those that a test sets.
RAW = b"raw" * 200
GOOD = {"run/SD.bin": RAW, "robot/drop_tower.toml": b"robot", "run/maneuver.toml": b"maneuver"}


def manifest_of(files: dict[str, bytes]) -> bytes:
    listed = {name: BundledFile(hashlib.sha256(data).hexdigest(), len(data)) for name, data in files.items()}
    return format_manifest(Manifest("test", "run", EvaluationInputs("run/SD.bin"), files=listed)).encode()


def pack_archive(
    files: dict[str, bytes],
    manifest: bytes | None = None,
    *,
    entry: Callable[[zipfile.ZipInfo], None] = lambda _: None,
    method: int = zipfile.ZIP_STORED,
) -> bytes:
    """Pack an archive; `entry` changes each file's entry before it is written."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as archive:
        archive.writestr("manifest.json", manifest_of(files) if manifest is None else manifest)
        for name, data in files.items():
            info = zipfile.ZipInfo("x")
            info.filename = info.orig_filename = name  # as it is: ZipInfo would mend it
            info.compress_type = method
            entry(info)
            archive.writestr(info, data)
    return buffer.getvalue()


def unpack_archive(folder: Path, data: bytes, limits: Limits = LIMITS) -> dict[str, bytes]:
    """Unpack the archive and return its files, asserting that nothing was written next to them."""
    (folder / "a.zip").write_bytes(data)
    try:
        unpack(folder / "a.zip", folder / "out", limits)
    finally:
        # The staging folder goes after success and after refusal.
        assert {path.name for path in folder.iterdir()} <= {"a.zip", "out"}
    out = folder / "out"
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in out.rglob("*") if path.is_file()}


def expect_refusal(folder: Path, data: bytes, limits: Limits = LIMITS) -> str:
    with pytest.raises(BundleError) as caught:
        unpack_archive(folder, data, limits)
    assert not (folder / "out").exists()
    assert "Nothing was unpacked." in caught.value.meaning or "nothing was unpacked" in caught.value.meaning
    assert caught.value.next_step
    return caught.value.what


@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_a_good_bundle_is_unpacked(tmp_path: Path, method: int) -> None:
    """Also when a person packed it again with another tool."""
    files = unpack_archive(tmp_path, pack_archive(GOOD, method=method))
    assert files.pop("manifest.json") == manifest_of(GOOD)
    assert files == GOOD


@pytest.mark.parametrize(
    ("name", "why"),
    [
        # Absolute on Unix and on Windows.
        ("/etc/cron.d/tfsat", "absolute"),
        ("C:/Windows/x", "absolute"),
        # Up and out: plainly, from within a folder, and with the separator of Windows.
        ("../outside", r"`\.\.`"),
        ("run/../../outside", r"`\.\.`"),
        ("run\\..\\..\\outside", "character"),
        # zipfile cuts a name at NUL: what is checked would not be what is written.
        ("run/SD.bin\0.txt", "character"),
        # Two spellings of one path.
        ("run//SD.csv", "empty part"),
        ("./run", "empty part"),
        # Device names of Windows, with any ending; dots and spaces at the end, which it drops; a stream.
        ("run/CON", "device"),
        ("run/nul.txt", "device"),
        ("run/name. ", "dot or a space"),
        ("run/a:stream", "character"),
        # More than 200 bytes in a part, more than 400 characters in all.
        ("run/" + "a" * 300, "too long"),
        ("a/" * 300 + "a", "characters"),
        ("run/line\nfeed", "character"),
    ],
)
def test_names_that_lead_elsewhere_are_refused(tmp_path: Path, name: str, why: str) -> None:
    folder = tmp_path / "deep" / "er"
    folder.mkdir(parents=True)
    message = expect_refusal(folder, pack_archive(GOOD | {name: b"x"}))
    assert re.search(why, message), message
    assert [path.name for path in tmp_path.iterdir()] == ["deep"]


@pytest.mark.parametrize(
    ("kind", "why"),
    [
        (stat.S_IFLNK, "a link"),
        (stat.S_IFCHR, "neither a file nor a folder"),
        (stat.S_IFBLK, "neither"),
        (stat.S_IFIFO, "neither"),
        (stat.S_IFSOCK, "neither"),
        (stat.S_IFDIR, "neither"),
    ],
)
def test_what_is_no_file_is_refused(tmp_path: Path, kind: int, why: str) -> None:
    def as_kind(info: zipfile.ZipInfo) -> None:
        if info.filename == "run/maneuver.toml":
            # 3: made on Unix, where the upper half of the attributes is the mode.
            info.create_system, info.external_attr = 3, (kind | 0o777) << 16

    assert why in expect_refusal(tmp_path, pack_archive(GOOD, entry=as_kind))


# Equal but for case (Windows, macOS), or a file where the archive has a folder.
@pytest.mark.parametrize(
    "other", ["run/sd.bin", "RUN/SD.bin", "run/SD.BIN", "Run/other", "run/SD.bin/inside", "run", "robot"]
)
def test_names_that_some_system_takes_for_one_are_refused(tmp_path: Path, other: str) -> None:
    assert "takes for one" in expect_refusal(tmp_path, pack_archive(GOOD | {other: b"x"}))


def test_umlauts_in_two_forms_are_one_name() -> None:
    # Composed and decomposed: macOS takes both for one file.
    assert collision_among(["run/\u00fc.txt", "run/u\u0308.txt"]) is not None
    assert collision_among(["run/ü.txt", "run/o.txt", "ü/ü.txt"]) is None


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_the_same_name_twice_is_refused(tmp_path: Path) -> None:
    buffer = io.BytesIO(pack_archive(GOOD))
    with zipfile.ZipFile(buffer, "a") as archive:
        archive.writestr("run/SD.bin", RAW)
    assert "takes for one" in expect_refusal(tmp_path, buffer.getvalue())


def test_bombs_are_refused_by_what_they_say(tmp_path: Path) -> None:
    # 3 MiB: above the free 1 MiB, and zeros shrink by more than the ratio of 200.
    zeros = {"run/SD.bin": bytes(3 << 20)}
    assert "packed so tightly" in expect_refusal(tmp_path, pack_archive(zeros, method=zipfile.ZIP_DEFLATED))
    assert unpack_archive(tmp_path, pack_archive(zeros))["run/SD.bin"] == bytes(3 << 20), (
        "stored, it is no bomb"
    )


def test_many_small_bombs_count_as_one(tmp_path: Path) -> None:
    # Each is just within the free 1 MiB; their sum is not.
    zeros = {f"run/{number}": bytes(1 << 20) for number in range(4)} | {"run/SD.bin": RAW}
    assert "packed so tightly" in expect_refusal(tmp_path, pack_archive(zeros, method=zipfile.ZIP_DEFLATED))


def test_too_many_and_too_much_are_refused(tmp_path: Path) -> None:
    assert "holds 4 files; 3 are allowed" in expect_refusal(tmp_path, pack_archive(GOOD), Limits(files=3))
    assert "700 are allowed" in expect_refusal(tmp_path, pack_archive(GOOD), Limits(bytes=700))
    assert "manifest.json of" in expect_refusal(tmp_path, pack_archive(GOOD), Limits(manifest_bytes=100))


def with_size_in_the_directory(data: bytes, name: str, size: int) -> bytes:
    """Change a file's size as stated in the central directory."""
    edited = bytearray(data)
    # The fixed part of a central entry has 46 bytes; the size is at byte 24 (APPNOTE.TXT 4.3.12).
    place = data.rindex(name.encode()) - 46
    assert edited[place : place + 4] == b"PK\x01\x02"
    struct.pack_into("<I", edited, place + 24, size)
    return bytes(edited)


def test_a_bomb_that_lies_about_its_size_is_cut_off(tmp_path: Path) -> None:
    files = {"run/SD.bin": bytes(200_000)}
    # Manifest and directory agree on 10 bytes; the stream unpacks to 200,000.
    lying_archive = pack_archive(files, manifest_of({"run/SD.bin": bytes(10)}), method=zipfile.ZIP_DEFLATED)
    assert expect_refusal(tmp_path, with_size_in_the_directory(lying_archive, "run/SD.bin", 10))


def test_files_over_each_other_are_refused(tmp_path: Path) -> None:
    data = bytearray(pack_archive({"run/SD.bin": RAW, "run/SE.bin": RAW}))
    # Byte 42: offset of the local header. Both entries now unpack the same bytes.
    first, second = (data.rindex(name) - 46 for name in (b"run/SD.bin", b"run/SE.bin"))
    data[second + 42 : second + 46] = data[first + 42 : first + 46]
    assert "lies over another file" in expect_refusal(tmp_path, bytes(data))


def test_encrypted_and_oddly_packed_files_are_refused(tmp_path: Path) -> None:
    data = bytearray(pack_archive(GOOD))
    place = data.rindex(b"run/SD.bin") - 46
    # Bit 0 of the flags: encrypted.
    data[place + 8] |= 1
    assert "encrypted" in expect_refusal(tmp_path, bytes(data))
    # bzip2: a valid ZIP, but no bundle is packed by it.
    assert "packed by method 12" in expect_refusal(tmp_path, pack_archive(GOOD, method=zipfile.ZIP_BZIP2))


def test_the_manifest_must_name_exactly_what_is_there(tmp_path: Path) -> None:
    surplus_files, incomplete_files = GOOD | {"run/more": b"x"}, {"run/SD.bin": RAW}
    assert "does not name: run/more" in expect_refusal(
        tmp_path, pack_archive(surplus_files, manifest_of(GOOD))
    )
    message = expect_refusal(tmp_path, pack_archive(incomplete_files, manifest_of(GOOD)))
    assert "lacks files that its manifest names: robot/drop_tower.toml, run/maneuver.toml" in message
    longer = pack_archive(GOOD | {"run/SD.bin": RAW + b"x"}, manifest_of(GOOD))
    assert "601 bytes; its manifest says 600" in expect_refusal(tmp_path, longer)
    # An ordinary ZIP of the same files is no bundle: nothing vouches for them.
    assert "has no manifest.json" in expect_refusal(tmp_path, zip_of([("run/SD.bin", RAW)]))
    assert "'run/SD.bin', which is not in it" in expect_refusal(tmp_path, pack_archive({"other": b"x"}))


def test_a_changed_file_is_named(tmp_path: Path) -> None:
    # The same bytes backwards: size and name agree, only the hash tells.
    changed = GOOD | {"run/SD.bin": RAW[::-1]}
    message = expect_refusal(tmp_path, pack_archive(changed, manifest_of(GOOD)))
    assert "1 of 3 files" in message and message.endswith("run/SD.bin.")


def zip_of(files: Iterable[tuple[str, bytes]]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, data in files:
            archive.writestr(name, data)
    return buffer.getvalue()


# Empty; text; an archive without entries; local headers without a directory.
@pytest.mark.parametrize("data", [b"", b"no archive", b"PK\x05\x06" + bytes(18), b"PK\x03\x04" * 100])
def test_what_is_no_archive_is_refused(tmp_path: Path, data: bytes) -> None:
    expect_refusal(tmp_path, data)


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.text(),
        lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    )
)
def test_no_manifest_breaks_its_reader(value: object) -> None:
    with pytest.raises(BundleError):
        parse_manifest(json.dumps(value).encode(), "a.zip")


@given(data=st.data())
def test_no_value_in_a_manifest_breaks_its_reader(data: st.DataObject) -> None:
    values = json.loads(manifest_of(GOOD))
    table = data.draw(st.sampled_from([values, values["evaluated"], values["files"]["run/SD.bin"]]))
    key = data.draw(st.sampled_from(sorted(table)))
    table[key] = data.draw(st.none() | st.booleans() | st.integers() | st.text() | st.lists(st.integers()))
    # Some drawn values are valid: what counts is that no other error comes out.
    try:
        parse_manifest(json.dumps(values).encode(), "a.zip")
    except BundleError as error:
        assert error.next_step


@settings(max_examples=200)
@given(data=st.data())
def test_any_damage_is_refused_or_harmless(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """Bytes of a good archive are changed, cut or repeated: whatever is unpacked is what was packed."""
    archive = pack_archive(
        GOOD, method=data.draw(st.sampled_from([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED]))
    )
    edited = bytearray(archive)
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(edited) - 1))
        kind = data.draw(st.sampled_from(["byte", "cut", "repeat"]))
        if kind == "byte":
            edited[place] = data.draw(st.integers(0, 255))
        elif kind == "cut":
            del edited[place : place + data.draw(st.integers(1, 50))]
        else:
            edited[place:place] = edited[place : place + data.draw(st.integers(1, 50))]
        if not edited:
            return
    # All of it refused, or every byte as it was packed: nothing in between.
    folder = tmp_path_factory.mktemp("damaged")
    try:
        files = unpack_archive(folder, bytes(edited))
    except BundleError:
        assert not (folder / "out").exists()
        return
    manifest = parse_manifest(files.pop("manifest.json"), "a.zip")
    assert {name: hashlib.sha256(content).hexdigest() for name, content in files.items()} == {
        name: file.sha256 for name, file in manifest.files.items()
    }


# The small alphabet makes dots, separators, a drive's colon and NUL frequent.
@given(st.text(max_size=60) | st.text("./\\ aA:\0~", max_size=12))
def test_a_name_that_passes_stays_in_the_folder(name: str) -> None:
    if trouble_with_name(name) is None:
        below = Path("/folder") / name
        assert below.is_relative_to("/folder") and ".." not in below.parts
        assert below.as_posix() == f"/folder/{name}"


def test_the_command_refuses_with_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.zip").write_bytes(pack_archive(GOOD | {"../outside": b"x"}))
    output = command("reproduce", "a.zip", expect=1)
    assert "`..`" in output.err and "Nothing was unpacked." in output.err
    assert command("reproduce", "gone.zip", expect=1).err
    assert [path.name for path in tmp_path.iterdir()] == ["a.zip"]


@pytest.mark.parametrize("sign", ["\u202e", "\u200b", "\ufeff", "\u00ad", "\u2066", "\u0085", "\u2028"])
def test_characters_that_nobody_sees_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sign: str
) -> None:
    """Refuse invisible characters in names.

    A name can read `exe.txt` and end otherwise (bidirectional), or look like another (zero width).
    """
    monkeypatch.chdir(tmp_path)
    Path("a.zip").write_bytes(pack_archive(GOOD | {f"run/gnp{sign}.txt": b"x"}))
    output = command("reproduce", "a.zip", expect=1)
    assert (
        "a character that cannot be seen" in output.words + " ".join(output.err.split())
        and sign not in output.err
    )


def test_the_name_of_a_drop_is_no_novel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    values = json.loads(manifest_of(GOOD))
    # The name becomes a file's name: 200 leaves room for the endings within 255 bytes.
    values["name"] = "n" * 200
    assert parse_manifest(json.dumps(values).encode(), "a.zip").name == values["name"]
    values["name"] = "n" * 201
    Path("a.zip").write_bytes(pack_archive(GOOD, json.dumps(values).encode()))
    assert "its name has 201 characters" in " ".join(command("reproduce", "a.zip", expect=1).err.split())
