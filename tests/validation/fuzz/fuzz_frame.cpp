// The frame receiver and encoder alone, against the reference.
//
// The input is taken in three ways: as bytes from the wire, as type, sequence and payload of a frame to send, and as
// what a false frame holds. Its last byte says when the cable is pulled: 0, the end of a frame, before everything.
#include <algorithm>

#include "../../../firmware/arduino_sequencer/src/protocol/frame.h"
#include "../../../firmware/arduino_sequencer/src/protocol/messages.h"
#include "../../fixtures/sequencer/reference_frame.h"
#include "check.h"

using namespace tfsat::protocol;
using tfsat_test::Bytes;
using tfsat_test::Frame;
using tfsat_test::reference_decode;

namespace {

// Inputs of more than this go to a receiver for payloads longer than any message's: frames of several COBS runs.
constexpr size_t kShortInputBytes = 255;
constexpr size_t kLongPayloadBytes = 600;

// On the heap and exactly as large as promised, so that the address sanitizer sees a byte too many.
Bytes encode(const Frame& frame) {
  Bytes out(encoded_frame_bytes(frame.payload.size()));
  out.resize(encode_frame(frame.type, frame.sequence, frame.payload.data(), frame.payload.size(), out.data()));
  return out;
}

template <size_t kMaxBytes>
Frame received(const FrameReceiver<kMaxBytes>& receiver) {
  REQUIRE(receiver.payload_bytes() <= kMaxBytes);
  const uint8_t* payload = receiver.payload();
  return Frame{receiver.type(), receiver.sequence(), Bytes(payload, payload + receiver.payload_bytes())};
}

// A frame that was sent is the frame that arrives, whatever came before it and was ended by a zero.
template <size_t kMaxBytes>
Bytes require_round_trip(const Frame& frame, FrameReceiver<kMaxBytes>& receiver) {
  const Bytes wire = encode(frame);
  REQUIRE(wire.back() == 0);
  REQUIRE(std::count(wire.begin(), wire.end(), 0) == 1);
  REQUIRE(reference_decode(wire.data(), wire.size() - 1, kMaxBytes) == frame);
  receiver.feed(0);
  for (size_t i = 0; i < wire.size(); ++i) REQUIRE(receiver.feed(wire[i]) == (i + 1 == wire.size()));
  REQUIRE(received(receiver) == frame);
  return wire;
}

// Feeds what came over the wire; the cable is pulled once, before byte `pulled_at`. At each byte the receiver
// accepts what the reference accepts, and nothing else.
template <size_t kMaxBytes>
FrameReceiver<kMaxBytes> require_same_frames(const uint8_t* data, size_t size, size_t pulled_at) {
  FrameReceiver<kMaxBytes> receiver;
  size_t begin = 0;
  uint16_t rejected = 0;
  for (size_t i = 0; i < size; ++i) {
    if (i == pulled_at) {
      receiver.restart();
      begin = i;
    }
    const bool accepted = receiver.feed(data[i]);
    if (data[i] != 0) {
      REQUIRE(!accepted);
      continue;
    }
    const auto expected = reference_decode(data + begin, i - begin, kMaxBytes);
    REQUIRE(accepted == expected.has_value());
    if (!accepted && i > begin) ++rejected;
    REQUIRE(receiver.rejected() == rejected);
    if (accepted) {
      const Frame frame = received(receiver);
      REQUIRE(frame == *expected);
      FrameReceiver<kMaxBytes> other;
      require_round_trip(frame, other);
    }
    begin = i + 1;
  }
  return receiver;
}

// Too little or too much for a frame, with a CRC that is right where a careless receiver would look for it.
Bytes sealed(const uint8_t* data, size_t size, size_t crc_at) {
  const uint16_t crc = tfsat_test::reference_crc16(data, std::min(size, crc_at));
  Bytes out(encoded_frame_bytes(size));
  CobsEncoder cobs(out.data());
  for (size_t i = 0; i <= size; ++i) {
    if (i == std::min(size, crc_at)) {
      cobs.put(static_cast<uint8_t>(crc));
      cobs.put(static_cast<uint8_t>(crc >> 8));
    }
    if (i < size) cobs.put(data[i]);
  }
  out.resize(cobs.finish());
  return out;
}

template <size_t kMaxBytes>
void require_same_frames(const Bytes& wire) {
  require_same_frames<kMaxBytes>(wire.data(), wire.size(), 0);
}

template <size_t kMaxBytes>
void require_link(const uint8_t* data, size_t size) {
  auto receiver = require_same_frames<kMaxBytes>(data, size, data[size - 1]);
  require_same_frames<kMaxBytes>(sealed(data, size, kMaxBytes + 2));
  if (size < 2) return;
  const size_t payload_bytes = std::min(size - 2, kMaxBytes);
  const Frame frame{data[0], data[1], Bytes(data + 2, data + 2 + payload_bytes)};

  // Then one bit of it wrong, chosen by what it says.
  Bytes damaged = require_round_trip(frame, receiver);
  const size_t bit = static_cast<size_t>(data[0] | data[1] << 8) % (8 * damaged.size());
  damaged[bit / 8] = static_cast<uint8_t>(damaged[bit / 8] ^ 1 << bit % 8);
  require_same_frames<kMaxBytes>(damaged);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  if (size <= kShortInputBytes) {
    require_link<kMaxPayloadBytes>(data, size);
  } else {
    require_link<kLongPayloadBytes>(data, size);
  }
  return 0;
}
