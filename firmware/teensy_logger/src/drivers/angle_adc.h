// The six absolute angle sensors on the converter, 12 bit.
#pragma once

#include <Arduino.h>

#include "../core/ports.h"

namespace tfsat {
namespace logger {

class AngleAdc final : public Adc {
 public:
  explicit AngleAdc(const uint8_t (&pins)[protocol::kAngleSensorCount]) : pins_(pins) {}

  // No averaging: the mean of readings on both sides of 0/360 deg points the opposite way. The
  // first conversion of a pin also switches off its keeper, which would pull at the sensor.
  void begin() {
    analogReadResolution(12);
    analogReadAveraging(1);
    for (const uint8_t pin : pins_) analogRead(pin);
  }

  // About 5 us a channel (49 clocks of 10 MHz): the buses' first words take longer, so this costs
  // no time. analogRead() calls yield() while it waits: the sketch must have no serialEvent().
  uint8_t read(uint16_t counts[protocol::kAngleSensorCount]) override {
    for (uint8_t i = 0; i < protocol::kAngleSensorCount; ++i) {
      counts[i] = static_cast<uint16_t>(analogRead(pins_[i]));
    }
    return (1u << protocol::kAngleSensorCount) - 1;
  }

 private:
  const uint8_t (&pins_)[protocol::kAngleSensorCount];
};

}  // namespace logger
}  // namespace tfsat
