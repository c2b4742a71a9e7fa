// The ATmega32U4's EEPROM, a byte at a time (3.4 ms a write, datasheet table 5-3), never waiting.
#pragma once

#include "../core/ports.h"

namespace tfsat {
namespace sequencer {

class EepromMemory : public NonVolatile {
 public:
  // A write that a reset interrupted goes on after it: gives it 10 ms to end. Only at start-up.
  void begin();

  uint8_t read(uint16_t address) override;
  bool busy() override;
  void write(uint16_t address, uint8_t value) override;
};

}  // namespace sequencer
}  // namespace tfsat
