// Copied from protocol/cpp/wire.h by tools/generate_protocol.py.
// Little-endian bytes, one at a time, so that no alignment and no byte order of a processor matters.
#ifndef TFSAT_PROTOCOL_WIRE_H
#define TFSAT_PROTOCOL_WIRE_H

#include <stdint.h>
#include <string.h>

// The AVR is little endian and has no alignment: there a structure in memory is its wire form, and a
// copy saves a quarter of the sequencer's flash. The emulated board's tests speak with the real image, so that
// both ways are held against the same host.
#ifdef __AVR__
#define TFSAT_WIRE_FORM_IN_MEMORY
#endif

namespace tfsat {
namespace protocol {

class Writer {
 public:
  explicit Writer(uint8_t* out) : out_(out) {}

  void u8(uint8_t value) { *out_++ = value; }
  void u16(uint16_t value) {
    u8(static_cast<uint8_t>(value));
    u8(static_cast<uint8_t>(value >> 8));
  }
  void u32(uint32_t value) {
    u16(static_cast<uint16_t>(value));
    u16(static_cast<uint16_t>(value >> 16));
  }
  void u64(uint64_t value) {
    u32(static_cast<uint32_t>(value));
    u32(static_cast<uint32_t>(value >> 32));
  }
  void i16(int16_t value) { u16(static_cast<uint16_t>(value)); }
  void i32(int32_t value) { u32(static_cast<uint32_t>(value)); }
  void f32(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    u32(bits);
  }

 private:
  uint8_t* out_;
};

class Reader {
 public:
  explicit Reader(const uint8_t* in) : in_(in) {}

  uint8_t u8() { return *in_++; }
  uint16_t u16() {
    const uint16_t low = u8();
    return static_cast<uint16_t>(low | (static_cast<uint16_t>(u8()) << 8));
  }
  uint32_t u32() {
    const uint32_t low = u16();
    return low | (static_cast<uint32_t>(u16()) << 16);
  }
  uint64_t u64() {
    const uint64_t low = u32();
    return low | (static_cast<uint64_t>(u32()) << 32);
  }
  int16_t i16() { return static_cast<int16_t>(u16()); }
  int32_t i32() { return static_cast<int32_t>(u32()); }
  float f32() {
    const uint32_t bits = u32();
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
  }

 private:
  const uint8_t* in_;
};

}  // namespace protocol
}  // namespace tfsat

#endif
