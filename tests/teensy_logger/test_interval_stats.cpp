// Times between samples: their extremes and their jitter, exact for known patterns, however long.
#include <initializer_list>
#include <limits>

#include "../../firmware/teensy_logger/src/core/interval_stats.h"
#include "check.h"

using tfsat::logger::IntervalStats;

namespace {

// Samples at these intervals, over and over.
template <size_t kCount>
IntervalStats pattern(float rate_hz, const uint64_t (&intervals_us)[kCount], uint32_t samples) {
  IntervalStats stats;
  stats.reset(rate_hz);
  uint64_t t_us = 5000000000u;
  stats.add(t_us);
  for (uint32_t i = 0; i < samples; ++i) stats.add(t_us += intervals_us[i % kCount]);
  return stats;
}

}  // namespace

TEST_CASE(no_interval_has_no_jitter) {
  IntervalStats stats;
  stats.reset(280.0f);
  CHECK(stats.rms_us() == 0.0f && stats.min_us() == 0 && stats.max_us() == 0);
  CHECK(!stats.add(77));
  CHECK(stats.rms_us() == 0.0f && stats.max_us() == 0 && stats.late() == 0);
}

TEST_CASE(jitter_is_the_rms_from_the_nominal_interval) {
  const uint64_t exact[] = {1000};
  CHECK(pattern(1000.0f, exact, 100).rms_us() == 0.0f);
  const uint64_t alternating[] = {990, 1010};
  CHECK(pattern(1000.0f, alternating, 100).rms_us() == 10.0f);
  const uint64_t slow[] = {1030};  // a clock that is off, not only one that shakes
  CHECK(pattern(1000.0f, slow, 7).rms_us() == 30.0f);
  const uint64_t mixed[] = {1003, 996, 1004, 997};
  CHECK_NEAR(pattern(1000.0f, mixed, 400).rms_us(), std::sqrt(12.5), 1e-4);
  const uint64_t timer[] = {3571, 3571, 3572, 3571, 3572, 3571, 3572};  // 280 Hz in whole us
  CHECK_NEAR(pattern(280.0f, timer, 7000).rms_us(), std::sqrt(12.0) / 7.0, 2e-3);
}

TEST_CASE(a_tick_without_a_sample_is_late_and_no_jitter) {
  IntervalStats stats;
  stats.reset(1000.0f);
  stats.add(0);
  CHECK(!stats.add(1000) && !stats.add(2500));  // one and a half are still on time
  CHECK(stats.rms_us() > 353.0f && stats.rms_us() < 354.0f);
  CHECK(stats.add(4001) && stats.last_interval_us() == 1501);
  CHECK(stats.add(14001) && !stats.add(15001));
  CHECK(stats.late() == 2 && stats.min_us() == 1000 && stats.max_us() == 10000);
  CHECK(stats.rms_us() > 288.0f && stats.rms_us() < 289.0f);
}

TEST_CASE(an_interval_of_hours_is_capped_and_late) {
  IntervalStats stats;
  stats.reset(10.0f);
  stats.add(0);
  CHECK(stats.add(7200000000u) && stats.late() == 1);
  CHECK(stats.max_us() == std::numeric_limits<uint32_t>::max());
}

TEST_CASE(the_worst_jitter_at_the_lowest_rate_overflows_nothing) {
  const uint64_t worst[] = {50000, 150000};
  for (const uint32_t samples : {7000u, 8000u, 100000u, 3000000u}) {
    CHECK_NEAR(pattern(10.0f, worst, samples).rms_us(), 50000.0, 5.0);
  }
  const uint64_t bursts[] = {0, 150000, 150000};
  CHECK_NEAR(pattern(10.0f, bursts, 300000).rms_us(), 100000.0 * std::sqrt(0.5), 10.0);
}

TEST_CASE(reset_begins_anew) {
  IntervalStats stats;
  stats.reset(1000.0f);
  stats.add(0);
  stats.add(9000);
  stats.reset(280.0f);
  stats.add(20000);
  CHECK(stats.late() == 0 && stats.max_us() == 0);
  stats.add(23571);
  CHECK(stats.min_us() == 3571 && stats.max_us() == 3571 && stats.late() == 0);
}
