// Session ids from the processor's cycle counter at the moment a host asks.
#pragma once

#include <Arduino.h>

#include "../core/ports.h"

namespace tfsat {
namespace logger {

// The counter runs through all 32 bits in 7 s at 600 MHz, and nothing ties a host's request to it.
class CycleEntropy final : public Entropy {
 public:
  uint32_t next() override { return ARM_DWT_CYCCNT ^ HW_OCOTP_CFG0; }
};

}  // namespace logger
}  // namespace tfsat
