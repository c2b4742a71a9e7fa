// Settings in the Teensy's emulated EEPROM: a log of changed bytes in the last 256 KiB of the
// program's flash, which an upload of new firmware leaves alone.
//
// A byte that changes takes up to 3 ms with interrupts held, and every 2,000th of its sector erases
// 4 KiB, up to 400 ms (W25Q64JV datasheet, AC characteristics). Bytes that stay are not written.
#pragma once

#include <Arduino.h>
#include <avr/eeprom.h>

#include "../core/ports.h"

namespace tfsat {
namespace logger {

class FlashMemory final : public NonVolatile {
 public:
  void load(uint8_t* bytes, uint8_t size) override { eeprom_read_block(bytes, kStart, size); }
  void save(const uint8_t* bytes, uint8_t size) override {
    eeprom_write_block(bytes, kStart, size);
  }

 private:
  static constexpr uint8_t* kStart = nullptr;  // an offset: the first byte
};

}  // namespace logger
}  // namespace tfsat
