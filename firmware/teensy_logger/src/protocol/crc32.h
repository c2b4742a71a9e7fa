// Copied from protocol/cpp/crc32.h by tools/generate_protocol.py.
// CRC-32/ISO-HDLC: reflected polynomial 0xEDB88320, initial value and final xor 0xFFFFFFFF.
#ifndef TFSAT_PROTOCOL_CRC32_H
#define TFSAT_PROTOCOL_CRC32_H

#include <stddef.h>
#include <stdint.h>

namespace tfsat {
namespace protocol {

// Feed bytes, then read value(). Works a nibble at a time, with sixteen constants; on the AVR, which has
// neither flash nor RAM for them, bit by bit.
class Crc32 {
 public:
  void update(uint8_t byte) {
    register_ ^= byte;
#ifdef __AVR__
    for (uint8_t bit = 0; bit < 8; ++bit) {
      register_ = (register_ & 1) != 0 ? register_ >> 1 ^ 0xEDB88320 : register_ >> 1;
    }
#else
    register_ = step(step(register_));
#endif
  }

  void update(const uint8_t* data, size_t size) {
    for (size_t i = 0; i < size; ++i) update(data[i]);
  }

  uint32_t value() const { return ~register_; }

 private:
#ifndef __AVR__
  static uint32_t step(uint32_t value) {
    static const uint32_t kTable[16] = {
        0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4,
        0x4DB26158, 0x5005713C, 0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C,
        0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C};
    return (value >> 4) ^ kTable[value & 0x0F];
  }
#endif

  uint32_t register_ = 0xFFFFFFFF;
};

inline uint32_t crc32(const uint8_t* data, size_t size) {
  Crc32 crc;
  crc.update(data, size);
  return crc.value();
}

}  // namespace protocol
}  // namespace tfsat

#endif
