"""Framing in Python and C++: round trips, noise, resynchronisation, agreement of the two."""

from __future__ import annotations

import ctypes
import json
from contextlib import suppress
from pathlib import Path

import pytest
from cobs import cobs
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.fixtures.cpp.compiling import SKETCHES, build_shared
from tests.paths import REPOSITORY
from tfsat_host.protocol.framing import Frame, FrameReceiver, encode_frame
from tfsat_host.protocol.limits import MAX_PAYLOAD_BYTES

HERE = Path(__file__).parent
MAX_FRAME_BYTES = MAX_PAYLOAD_BYTES + 6

payloads = st.binary(max_size=MAX_PAYLOAD_BYTES)
frames = st.builds(Frame, st.integers(0, 255), st.integers(0, 255), payloads)
# Many zeros, ones and 0xFF: where COBS and the end of a frame are decided.
noisy_bytes = st.one_of(st.sampled_from([0, 1, 2, 0xFF]), st.integers(0, 255))
noise = st.lists(noisy_bytes, max_size=400).map(bytes)


class CppFraming:
    """The sketches' framing through its bridge."""

    def __init__(self, path: Path) -> None:
        library = ctypes.CDLL(str(path))
        for name in ("bridge_encode", "bridge_cobs", "bridge_receive"):
            getattr(library, name).restype = ctypes.c_size_t
        self._library = library

    def encode(self, frame: Frame) -> bytes:
        out = ctypes.create_string_buffer(2 * len(frame.payload) + 16)
        size = self._library.bridge_encode(
            ctypes.c_uint8(frame.type),
            ctypes.c_uint8(frame.sequence),
            frame.payload,
            ctypes.c_size_t(len(frame.payload)),
            out,
        )
        return out.raw[:size]

    def cobs(self, data: bytes) -> bytes:
        out = ctypes.create_string_buffer(2 * len(data) + 16)
        size = self._library.bridge_cobs(data, ctypes.c_size_t(len(data)), out)
        assert out.raw[size - 1] == 0
        return out.raw[: size - 1]

    def receive(self, stream: bytes) -> tuple[list[Frame], int]:
        out = ctypes.create_string_buffer(len(stream) + 16)
        rejected = ctypes.c_uint16()
        size = self._library.bridge_receive(stream, ctypes.c_size_t(len(stream)), out, ctypes.byref(rejected))
        listing, accepted = out.raw[:size], []
        while listing:
            length = listing[0]
            accepted.append(Frame(listing[1], listing[2], listing[3 : 3 + length]))
            listing = listing[3 + length :]
        return accepted, rejected.value


@pytest.fixture(scope="module", params=SKETCHES)
def cpp(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> CppFraming:
    folder = tmp_path_factory.mktemp("framing")
    includes = [REPOSITORY / "firmware" / request.param / "src" / "protocol"]
    return CppFraming(build_shared([HERE / "framing_bridge.cpp"], folder / "framing.so", includes, "c++11"))


def receive(stream: bytes) -> tuple[list[Frame], int]:
    receiver = FrameReceiver()
    accepted = list(receiver.feed(stream))
    return accepted, receiver.rejected


@given(frames)
def test_round_trip(frame: Frame) -> None:
    encoded = encode_frame(frame)
    assert encoded.index(0) == len(encoded) - 1
    assert receive(encoded) == ([frame], 0)


@given(st.binary(max_size=1200))
def test_cobs_round_trip(data: bytes) -> None:
    encoded = cobs.encode(data)
    assert 0 not in encoded
    assert cobs.decode(encoded) == data
    assert len(encoded) <= len(data) + len(data) // 254 + 1


@pytest.mark.parametrize("length", [0, 1, 253, 254, 255, 256, 507, 508, 509, 1016])
def test_cobs_at_the_ends_of_its_runs(cpp: CppFraming, length: int) -> None:
    for data in (b"\x11" * length, b"\x11" * length + b"\0", b"\0" + b"\x11" * length):
        assert cobs.decode(cpp.cobs(data)) == data


@given(noise)
def test_cobs_decoding_refuses_or_undoes_some_encoding(data: bytes) -> None:
    with suppress(cobs.DecodeError):
        decoded = cobs.decode(data)
        assert cobs.decode(cobs.encode(decoded)) == decoded


@given(st.lists(noise, max_size=6), frames)
def test_resynchronises_at_the_next_zero(pieces: list[bytes], frame: Frame) -> None:
    receiver = FrameReceiver()
    for piece in pieces:
        list(receiver.feed(piece))
    assert list(receiver.feed(b"\0" + encode_frame(frame)))[-1] == frame


@given(st.integers(2000, 8000), st.integers(1, 255), frames)
def test_an_endless_run_without_a_zero_is_no_burden(length: int, byte: int, frame: Frame) -> None:
    receiver = FrameReceiver()
    for _ in range(length // 64):
        assert list(receiver.feed(bytes([byte]) * 64)) == []
    assert receiver.rejected == length // 64 * 64 // 1088  # given up 1024 bytes at a time, not kept
    assert list(receiver.feed(b"\0" + encode_frame(frame))) == [frame]
    assert receiver.rejected > 0


@given(st.lists(frames, min_size=1, max_size=5), st.lists(st.integers(1, 40), min_size=1, max_size=20))
def test_the_size_of_the_pieces_does_not_matter(sent: list[Frame], sizes: list[int]) -> None:
    stream = b"".join(map(encode_frame, sent))
    receiver, received = FrameReceiver(), []
    for number in range(len(stream)):
        size = sizes[number % len(sizes)]
        received += list(receiver.feed(stream[:size]))
        stream = stream[size:]
    assert received == sent


@settings(max_examples=150)
@given(st.data())
def test_cpp_encodes_the_same(cpp: CppFraming, data: st.DataObject) -> None:
    frame = data.draw(frames)
    assert cpp.encode(frame) == encode_frame(frame)
    # More than any frame has: behind a run of 254 bytes the package leaves out an empty one, the sketches do not.
    raw = data.draw(st.one_of(st.binary(max_size=700), noise))
    assert 0 not in cpp.cobs(raw)
    assert cobs.decode(cpp.cobs(raw)) == raw


@settings(max_examples=250)
@given(st.data())
def test_cpp_receives_the_same(cpp: CppFraming, data: st.DataObject) -> None:
    """Frames and noise in any order, damaged or not: both accept the same frames and count the same damage."""
    pieces = data.draw(st.lists(st.one_of(noise, frames.map(encode_frame)), max_size=8))
    stream = bytearray(b"".join(pieces))
    for at in data.draw(st.lists(st.integers(0, max(0, len(stream) - 1)), max_size=4)) if stream else []:
        stream[at] = data.draw(noisy_bytes)
    assert cpp.receive(bytes(stream)) == receive(bytes(stream))


@given(st.data())
def test_cpp_resynchronises_at_the_next_zero(cpp: CppFraming, data: st.DataObject) -> None:
    frame = data.draw(frames)
    stream = data.draw(st.binary(max_size=600)) + b"\0" + encode_frame(frame)
    accepted, _ = cpp.receive(stream)
    assert accepted[-1] == frame


def test_the_board_rejects_what_it_cannot_hold(cpp: CppFraming) -> None:
    longest = Frame(1, 2, b"\x07" * MAX_PAYLOAD_BYTES)
    too_long = Frame(1, 2, b"\x07" * (MAX_PAYLOAD_BYTES + 1))
    assert cpp.receive(encode_frame(longest)) == ([longest], 0)
    assert cpp.receive(encode_frame(too_long) + encode_frame(longest)) == ([longest], 1)
    assert len(encode_frame(longest)) <= MAX_FRAME_BYTES
    frame = cobs.decode(encode_frame(longest)[:-1])
    assert cpp.receive(cobs.encode(frame + b"more") + b"\0") == ([], 1)  # its beginning is no frame


def test_an_empty_piece_is_no_damage(cpp: CppFraming) -> None:
    frame = Frame(3, 4, b"")
    stream = b"\0\0\0" + encode_frame(frame) + b"\0\0"
    assert cpp.receive(stream) == receive(stream) == ([frame], 0)


def flips(stream: bytes) -> list[bytes]:
    return [
        stream[:at] + bytes([stream[at] ^ (1 << bit)]) + stream[at + 1 :]
        for at in range(len(stream))
        for bit in range(8)
    ]


def golden_frames() -> list[bytes]:
    vectors = json.loads((REPOSITORY / "protocol" / "golden_vectors.json").read_text())["frames"]
    return [bytes.fromhex(vector["frame"]) for vector in vectors]


def test_a_flipped_bit_never_makes_another_frame(cpp: CppFraming) -> None:
    """Flip bits in every frame of the protocol, followed by another frame.

    A flip that makes or breaks a zero byte counts too.
    """
    follower = Frame(0x20, 9, b"\x01\x02")
    tail = encode_frame(follower)
    for stream in golden_frames():
        (original,), _ = receive(stream)
        for damaged in flips(stream):
            for accepted in (receive(damaged + tail)[0], cpp.receive(damaged + tail)[0]):
                assert accepted in ([], [follower]), damaged.hex()
                assert original not in accepted


@settings(max_examples=30)
@given(frames)
def test_a_flipped_bit_of_any_frame_is_found(frame: Frame) -> None:
    for damaged in flips(encode_frame(frame)):
        assert receive(damaged)[0] == []
