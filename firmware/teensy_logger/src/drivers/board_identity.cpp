#include "board_identity.h"

#include <Arduino.h>

#include "../protocol/crc32.h"

// Length of the flash image, set by the linker script as an address.
extern "C" unsigned long _flashimagelen;

namespace tfsat {
namespace logger {

namespace {

// i.MX RT1060 Reference Manual rev. 3, system memory map: FlexSPI flash.
constexpr uintptr_t kFlashBase = 0x60000000;

}  // namespace

Identity read_identity() {
  Identity identity;
  // OCOTP_CFG0 and CFG1: the chip's 64-bit unique id (Reference Manual, on-chip OTP controller).
  protocol::Writer serial(identity.board_serial);
  serial.u32(HW_OCOTP_CFG0);
  serial.u32(HW_OCOTP_CFG1);
  identity.image_crc = protocol::crc32(reinterpret_cast<const uint8_t*>(kFlashBase),
                                       reinterpret_cast<uintptr_t>(&_flashimagelen));
  return identity;
}

}  // namespace logger
}  // namespace tfsat
