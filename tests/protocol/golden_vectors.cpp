// The generated codecs and the link code against the golden vectors. Compiled once for each
// sketch's copy and each language standard.
#include <cstdlib>
#include <cstring>

#include "crc16.h"
#include "crc32.h"
#include "frame.h"
#include "messages.h"
#include "wire.h"
// They need the above.
#include "golden_blocks.h"
#include "golden_vectors.h"

#include "check.h"

using namespace tfsat;
using namespace tfsat::protocol;

namespace {

bool same(const uint8_t* a, const uint8_t* b, size_t size) {
  return size == 0 || std::memcmp(a, b, size) == 0;
}

// Memory of exactly `size` bytes, so that the address sanitizer sees a byte too many.
struct Exact {
  explicit Exact(size_t size) : bytes(new uint8_t[size]) {}
  ~Exact() { delete[] bytes; }
  Exact(const Exact&) = delete;
  Exact& operator=(const Exact&) = delete;
  uint8_t* bytes;
};

}  // namespace

TEST_CASE(crc_check_values) {
  const uint8_t digits[] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  CHECK(crc16(digits, sizeof digits) == 0x29B1);
  CHECK(crc32(digits, sizeof digits) == 0xCBF43926);
}

TEST_CASE(payloads_are_built_byte_for_byte) {
  for (const golden::Vector& vector : golden::kVectors) {
    Exact payload(vector.payload_size + 1);
    const size_t size = vector.build(payload.bytes);
    const bool right = size == vector.payload_size && same(payload.bytes, vector.payload, size);
    if (!CHECK(right)) std::puts(vector.name);
  }
}

TEST_CASE(payloads_are_read_back) {
  for (const golden::Vector& vector : golden::kVectors) {
    if (!CHECK(vector.matches(vector.payload, vector.payload_size))) std::puts(vector.name);
  }
}

TEST_CASE(a_payload_of_another_length_is_refused) {
  for (const golden::Vector& vector : golden::kVectors) {
    Exact longer(vector.payload_size + 1);
    if (vector.payload_size > 0) std::memcpy(longer.bytes, vector.payload, vector.payload_size);
    longer.bytes[vector.payload_size] = 0;
    CHECK(!vector.matches(longer.bytes, vector.payload_size + 1));
    if (vector.payload_size > 0) CHECK(!vector.matches(longer.bytes, vector.payload_size - 1));
  }
}

TEST_CASE(frames_are_encoded_byte_for_byte) {
  for (const golden::Vector& vector : golden::kVectors) {
    Exact frame(encoded_frame_bytes(vector.payload_size));
    const size_t size = encode_frame(vector.type, vector.sequence, vector.payload,
                                     vector.payload_size, frame.bytes);
    const bool right = size == vector.frame_size && same(frame.bytes, vector.frame, size);
    if (!CHECK(right)) std::puts(vector.name);
  }
}

TEST_CASE(frames_are_received) {
  FrameReceiver<kMaxPayloadBytes> receiver;
  for (const golden::Vector& vector : golden::kVectors) {
    size_t complete = 0;
    for (size_t i = 0; i < vector.frame_size; ++i) {
      complete += receiver.feed(vector.frame[i]) ? i + 1 : 0;
    }
    if (!CHECK(complete == vector.frame_size)) std::puts(vector.name);
    CHECK(receiver.type() == vector.type && receiver.sequence() == vector.sequence);
    CHECK(receiver.payload_bytes() == vector.payload_size &&
          same(receiver.payload(), vector.payload, vector.payload_size));
  }
  CHECK(receiver.rejected() == 0);
}

TEST_CASE(a_longest_frame_fills_its_buffers_and_one_more_byte_is_rejected) {
  FrameReceiver<kMaxPayloadBytes> receiver;
  for (size_t size = kMaxPayloadBytes; size <= kMaxPayloadBytes + 300; ++size) {
    Exact payload(size);
    std::memset(payload.bytes, 0x55, size);
    Exact frame(encoded_frame_bytes(size));
    const size_t length = encode_frame(1, 2, payload.bytes, size, frame.bytes);
    CHECK(length <= encoded_frame_bytes(size));
    bool complete = false;
    for (size_t i = 0; i < length; ++i) complete = receiver.feed(frame.bytes[i]);
    CHECK(complete == (size == kMaxPayloadBytes));
  }
}

// Noise of every kind into a receiver that the address sanitizer watches.
TEST_CASE(noise_never_leaves_the_buffer) {
  FrameReceiver<kMaxPayloadBytes> receiver;
  std::srand(1);
  for (size_t i = 0; i < 2000000; ++i) {
    const int kind = std::rand() % 16;
    const int chosen = kind == 0 ? 0 : kind < 4 ? 0xFF : kind < 6 ? 1 : std::rand();
    const uint8_t byte = static_cast<uint8_t>(chosen);
    if (receiver.feed(byte)) {
      CHECK(receiver.payload_bytes() <= kMaxPayloadBytes);
    }
  }
  CHECK(receiver.rejected() > 0);
}

TEST_CASE(a_frame_begun_before_the_cable_was_pulled_is_forgotten) {
  FrameReceiver<kMaxPayloadBytes> receiver;
  const golden::Vector& vector = golden::kVectors[1];
  for (size_t cut = 0; cut < vector.frame_size; ++cut) {
    for (size_t i = 0; i < cut; ++i) receiver.feed(vector.frame[i]);
    receiver.restart();
    bool complete = false;
    for (size_t i = 0; i < vector.frame_size; ++i) complete = receiver.feed(vector.frame[i]);
    CHECK(complete);
  }
}

TEST_CASE(blocks_carry_their_crc) {
  for (const golden::Block& block : golden::kBlocks) {
    Reader stored(block.bytes + kBlockBytes - 4);
    CHECK(crc32(block.bytes, kBlockBytes - 4) == stored.u32());
  }
}

// Read into the generated structs and written again: the same bytes.
TEST_CASE(blocks_are_read_and_written_byte_for_byte) {
  for (const golden::Block& block : golden::kBlocks) {
    Exact copy(kBlockBytes);
    std::memset(copy.bytes, 0, kBlockBytes);
    BlockHeader head;
    CHECK(head.decode(block.bytes, BlockHeader::kSize));
    CHECK(head.magic == kBlockMagic && head.version == kBlockVersion);
    CHECK(head.time_us == 4295000123u && head.first_sample == 36 && head.session == 0x5EED5EED);
    head.encode(copy.bytes);
    const uint8_t* in = block.bytes + BlockHeader::kSize;
    uint8_t* out = copy.bytes + BlockHeader::kSize;
    if (head.kind == BlockKind::kHeader) {
      LogHeader body;
      CHECK(body.decode(in, LogHeader::kSize));
      body.encode(out);
    } else if (head.kind == BlockKind::kFooter) {
      LogFooter body;
      CHECK(body.decode(in, LogFooter::kSize));
      body.encode(out);
    } else {
      CHECK(head.sample_count == kSamplesPerBlock && head.event_count == kEventsPerBlock);
      for (size_t i = 0; i < kSamplesPerBlock; ++i, in += Sample::kSize, out += Sample::kSize) {
        Sample sample;
        CHECK(sample.decode(in, Sample::kSize));
        sample.encode(out);
      }
      for (size_t i = 0; i < kEventsPerBlock; ++i, in += Event::kSize, out += Event::kSize) {
        Event event;
        CHECK(event.decode(in, Event::kSize));
        event.encode(out);
      }
    }
    Writer(copy.bytes + kBlockBytes - 4).u32(crc32(copy.bytes, kBlockBytes - 4));
    CHECK(same(copy.bytes, block.bytes, kBlockBytes));
  }
}

int main() { return tfsat_test::run_all(); }
