// How regularly samples were taken.
#pragma once

#include <math.h>
#include <stdint.h>

namespace tfsat {
namespace logger {

// Whole numbers only, so that every processor gets the same result.
class IntervalStats {
 public:
  void reset(float rate_hz) { *this = IntervalStats(static_cast<uint32_t>(1e9f / rate_hz)); }
  explicit IntervalStats(uint32_t nominal_ns = 1) : nominal_ns_(nominal_ns) {}

  // The next sample's time. True when at least one tick passed without a sample: it came more than
  // one and a half nominal intervals after the one before.
  bool add(uint64_t t_us) {
    const bool first = count_++ == 0;
    const uint64_t interval_us = t_us - last_us_;
    last_us_ = t_us;
    if (first) return false;
    last_interval_us_ = interval_us < UINT32_MAX ? static_cast<uint32_t>(interval_us) : UINT32_MAX;
    if (count_ == 2 || last_interval_us_ < min_us_) min_us_ = last_interval_us_;
    if (last_interval_us_ > max_us_) max_us_ = last_interval_us_;
    const int64_t off_ns = static_cast<int64_t>(last_interval_us_) * 1000 - nominal_ns_;
    if (off_ns > nominal_ns_ / 2) {
      ++late_;
      return true;
    }
    sum_squares_ns2_ += static_cast<uint64_t>(off_ns * off_ns);  // 1e16 at most, at 10 Hz
    ++on_time_;
    if (sum_squares_ns2_ >> 63 != 0) {  // half of both has the same mean
      sum_squares_ns2_ /= 2;
      on_time_ /= 2;
    }
    return false;
  }

  uint32_t last_interval_us() const { return last_interval_us_; }
  uint32_t min_us() const { return min_us_; }
  uint32_t max_us() const { return max_us_; }
  uint32_t late() const { return late_; }
  // Of the intervals that were on time, from the nominal one; late ones are counted, not averaged.
  float rms_us() const {
    if (on_time_ == 0) return 0.0f;
    return sqrtf(static_cast<float>(sum_squares_ns2_ / on_time_)) / 1000.0f;
  }

 private:
  int64_t nominal_ns_;
  uint64_t last_us_ = 0;
  uint64_t sum_squares_ns2_ = 0;
  uint32_t count_ = 0;
  uint32_t on_time_ = 0;  // intervals in the sum
  uint32_t last_interval_us_ = 0;
  uint32_t min_us_ = 0;
  uint32_t max_us_ = 0;
  uint32_t late_ = 0;
};

}  // namespace logger
}  // namespace tfsat
