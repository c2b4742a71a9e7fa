// From a joint angle to the width of a servo pulse.
#pragma once

#include "../protocol/messages.h"
#include "ticks.h"

namespace tfsat {
namespace sequencer {

// Linear between the pulse widths at 0 and 90 deg, never outside what a servo takes.
inline uint16_t pulse_ticks(int16_t angle_cdeg) {
  using namespace protocol;
  constexpr int32_t span_ticks =
      static_cast<int32_t>(kServoPulseAt90DegUs - kServoPulseAt0DegUs) * static_cast<int32_t>(kTicksPerUs);
  constexpr int32_t least = kServoPulseMinUs * kTicksPerUs;
  constexpr int32_t most = kServoPulseMaxUs * kTicksPerUs;
  const int32_t ticks = static_cast<int32_t>(kServoPulseAt0DegUs * kTicksPerUs) +
                        (static_cast<int32_t>(angle_cdeg) * span_ticks + (angle_cdeg < 0 ? -4500 : 4500)) / 9000;
  return static_cast<uint16_t>(ticks < least ? least : ticks > most ? most : ticks);
}

}  // namespace sequencer
}  // namespace tfsat
