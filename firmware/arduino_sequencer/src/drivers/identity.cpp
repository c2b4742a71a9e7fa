#include "identity.h"

#include <avr/boot.h>
#include <avr/pgmspace.h>
#include <util/atomic.h>

// Set by the linker: the byte after the last one of the HEX (code, then the values of .data).
extern "C" const uint8_t __data_load_end[];

namespace tfsat {
namespace sequencer {

namespace {

// Ten bytes of the signature row: lot, wafer and position on it. The datasheet documents the row's
// use only for the calibration byte; Atmel's and LUFA's code read the serial number here.
constexpr uint8_t kSerialAddress = 0x0E;
constexpr uint8_t kSerialBytes = 10;

constexpr uint8_t kPieceBytes = 128;

// The last two bytes, the position on the wafer, are folded over the first two.
void read_serial(uint8_t (&serial)[8]) {
  for (uint8_t i = 0; i < sizeof serial; ++i) serial[i] = 0;
  for (uint8_t i = 0; i < kSerialBytes; ++i) {
    uint8_t byte;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { byte = boot_signature_byte_get(kSerialAddress + i); }
    serial[i % sizeof serial] ^= byte;
  }
}

// The low three bits of the extended fuse: BODLEVEL (datasheet, table 28-3).
uint8_t read_brown_out_level() {
  uint8_t fuse;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { fuse = boot_lock_fuse_bits_get(GET_EXTENDED_FUSE_BITS); }
  return fuse & 7;
}

}  // namespace

bool ImageCrc::read_on(uint32_t& crc) {
  const uint16_t end = static_cast<uint16_t>(reinterpret_cast<uintptr_t>(__data_load_end));
  for (uint8_t i = 0; i < kPieceBytes && address_ != end; ++i) {
    crc_.update(pgm_read_byte(address_++));
  }
  crc = crc_.value();
  return address_ == end;
}

Identity read_identity(protocol::ResetCause cause) {
  Identity identity;
  read_serial(identity.board_serial);
  identity.reset_cause = cause;
  identity.brown_out_level = read_brown_out_level();
  return identity;
}

}  // namespace sequencer
}  // namespace tfsat
