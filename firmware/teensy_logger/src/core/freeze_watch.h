// Tells a chip that repeats itself from one that measures.
//
// At rest an MPU-6050's noise alone moves some axis in every independent reading: 400 ug/sqrt(Hz)
// and 0.005 deg/s/sqrt(Hz) (PS-MPU-6000A-00 rev. 3.4, 6.1 and 6.2) are 6.6 and 2.7 counts at the
// factory's settings, 2.3 and 0.2 behind the narrowest filter and at the widest ranges. There
// kFrozenUs holds three independent readings, so kFrozenReadings of slow sampling are asked for
// too. An output rate of 1 kHz read at 1 kHz repeats a reading now and then.
#pragma once

#include <string.h>

#include "../protocol/messages.h"

namespace tfsat {
namespace logger {

class FreezeWatch {
 public:
  static constexpr uint8_t kFrozenReadings = 5;

  // Forgets all readings.
  void restart() {
    count_ = 0;
    moved_ = false;
  }

  // The next burst. `saturated`: all axes stand at the ends of their ranges, as in a hard landing;
  // then there is no noise to be seen, and a standstill says nothing.
  void take(const uint8_t* burst, bool saturated, uint64_t t_us) {
    const bool same = count_ > 0 && memcmp(burst, last_, sizeof last_) == 0;
    moved_ |= count_ > 0 && !same;
    if (same && !saturated) {
      if (count_ < kFrozenReadings) ++count_;
      still_us_ = t_us - since_us_;
      return;
    }
    memcpy(last_, burst, sizeof last_);
    count_ = 1;
    since_us_ = t_us;
    still_us_ = 0;
  }

  // Two readings since restart() differed.
  bool moved() const { return moved_; }
  bool frozen() const { return count_ == kFrozenReadings && still_us_ >= protocol::kFrozenUs; }
  // From the first reading of the present standstill to the last.
  uint64_t still_us() const { return still_us_; }

 private:
  uint8_t last_[protocol::ImuReading::kSize] = {};
  uint64_t since_us_ = 0;
  uint64_t still_us_ = 0;
  uint8_t count_ = 0;
  bool moved_ = false;
};

}  // namespace logger
}  // namespace tfsat
