// The logger's clock: microseconds since power-up, in 64 bits.
#pragma once

#include <Arduino.h>

namespace tfsat {
namespace logger {

// micros() wraps after 71 minutes, millis() after 49 days: the one is extended by the other.
// Without any state of its own it may be called from the main loop and from every interrupt.
inline uint64_t now_us() {
  const uint64_t about_us = static_cast<uint64_t>(millis()) * 1000;
  const uint32_t exact_low_us = micros();
  return about_us + static_cast<uint64_t>(
                        static_cast<int64_t>(static_cast<int32_t>(
                            exact_low_us - static_cast<uint32_t>(about_us))));
}

}  // namespace logger
}  // namespace tfsat
