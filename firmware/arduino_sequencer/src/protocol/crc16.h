// Copied from protocol/cpp/crc16.h by tools/generate_protocol.py.
// CRC-16/IBM-3740: polynomial 0x1021, initial value 0xFFFF, not reflected, no final xor.
#ifndef TFSAT_PROTOCOL_CRC16_H
#define TFSAT_PROTOCOL_CRC16_H

#include <stddef.h>
#include <stdint.h>

namespace tfsat {
namespace protocol {

constexpr uint16_t kCrc16Initial = 0xFFFF;

// One byte further, without a table: flash is scarcer than time on the sequencer.
inline uint16_t crc16_update(uint16_t crc, uint8_t byte) {
  crc = static_cast<uint16_t>((crc >> 8) | (crc << 8));
  crc = static_cast<uint16_t>(crc ^ byte);
  crc = static_cast<uint16_t>(crc ^ ((crc & 0xFF) >> 4));
  crc = static_cast<uint16_t>(crc ^ (crc << 12));
  return static_cast<uint16_t>(crc ^ ((crc & 0xFF) << 5));
}

inline uint16_t crc16(const uint8_t* data, size_t size, uint16_t crc = kCrc16Initial) {
  for (size_t i = 0; i < size; ++i) crc = crc16_update(crc, data[i]);
  return crc;
}

}  // namespace protocol
}  // namespace tfsat

#endif
