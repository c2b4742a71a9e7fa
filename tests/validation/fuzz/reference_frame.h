// A second decoder of frames, straight from the specification and without regard to memory or speed:
// whole blocks at once. The firmware's receiver is judged by it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <vector>

// What a fuzz target demands of the code under test. A broken demand ends the process, which is how
// libFuzzer learns of a finding and keeps the input.
#define REQUIRE(condition)                                                         \
  do {                                                                             \
    if (!(condition)) {                                                            \
      std::fprintf(stderr, "%s:%d: broken: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                \
    }                                                                              \
  } while (false)

namespace tfsat_fuzz {

using Bytes = std::vector<uint8_t>;

struct Frame {
  uint8_t type;
  uint8_t sequence;
  Bytes payload;

  bool operator==(const Frame& other) const {
    return type == other.type && sequence == other.sequence && payload == other.payload;
  }
};

// CRC-16/IBM-3740 from its table; the firmware computes it without one.
inline uint16_t reference_crc16(const uint8_t* data, size_t size) {
  static const std::array<uint16_t, 256> table = [] {
    std::array<uint16_t, 256> remainders{};
    for (unsigned byte = 0; byte < remainders.size(); ++byte) {
      unsigned remainder = byte << 8;
      for (int bit = 0; bit < 8; ++bit) remainder = remainder << 1 ^ (remainder & 0x8000 ? 0x1021 : 0);
      remainders[byte] = static_cast<uint16_t>(remainder);
    }
    return remainders;
  }();
  uint16_t crc = 0xFFFF;
  for (size_t i = 0; i < size; ++i) crc = static_cast<uint16_t>(crc << 8 ^ table[crc >> 8 ^ data[i]]);
  return crc;
}

// `coded` is what stands between two zero bytes. Nothing, if it is no frame.
inline std::optional<Frame> reference_decode(const uint8_t* coded, size_t size, size_t max_payload_bytes) {
  Bytes plain;
  plain.reserve(size);
  for (size_t at = 0; at < size;) {
    const size_t code = coded[at];
    if (at + code > size) return std::nullopt;  // the last run ends too soon
    plain.insert(plain.end(), coded + at + 1, coded + at + code);
    at += code;
    if (code != 0xFF && at < size) plain.push_back(0);
  }
  if (plain.size() < 4 || plain.size() > max_payload_bytes + 4) return std::nullopt;
  const size_t body = plain.size() - 2;
  if (reference_crc16(plain.data(), body) != (plain[body] | plain[body + 1] << 8)) return std::nullopt;
  return Frame{plain[0], plain[1], Bytes(plain.data() + 2, plain.data() + body)};
}

}  // namespace tfsat_fuzz
