// Released and landed: by the sequencer's rule, by a shock at every range, by time, and not at all.
#include <vector>

#include "../../firmware/teensy_logger/src/core/drop_watch.h"
#include "check.h"

using namespace tfsat::logger;
using namespace tfsat::protocol;

namespace {

constexpr float kCountsPerG = 2048.0f;                  // +-16 g
constexpr uint64_t kStartUs = 0x100000000u - 4000000u;  // 32 bits wrap during each test

struct Bench {
  explicit Bench(uint32_t with_period_us = 1000, uint64_t start_us = kStartUs)
      : t_us(start_us), period_us(with_period_us) {
    watch.reset(kCountsPerG);
  }
  // The switch changes `after_us` after the last instant.
  void change(uint8_t index, bool now_open, uint64_t at_us) {
    watch.on_edge(Edge{at_us, Edge::Source::kSwitch, index, now_open, 0});
    const uint8_t bit = static_cast<uint8_t>(1u << index);
    open = static_cast<uint8_t>(now_open ? open | bit : open & ~bit);
  }
  void both(bool now_open) {
    change(0, now_open, t_us + 1);
    change(1, now_open, t_us + 2);
  }
  void tick(uint32_t counts = 0) {
    t_us += period_us;
    watch.poll(t_us, open, counts);
    Event event;
    while (watch.take_event(event)) events.push_back(event);
  }
  void run_ms(uint32_t ms, uint32_t counts = 0) {
    for (const uint64_t end_us = t_us + 1000u * ms; t_us < end_us;) tick(counts);
  }
  // Seated for half a second, then released; the release's time.
  uint64_t release(uint32_t seated_ms = 500) {
    run_ms(seated_ms);
    const uint64_t at_us = t_us + 2;
    both(true);
    run_ms(10 + period_us / 1000);
    CHECK(watch.phase() == DropPhase::kFalling);
    return at_us;
  }
  bool waiting() const { return watch.phase() == DropPhase::kWaiting; }

  DropWatch watch;
  std::vector<Event> events;
  uint64_t t_us;
  uint32_t period_us;
  uint8_t open = 0;
};

bool is(const Event& event, EventCode code, uint16_t arg, uint64_t time_us) {
  return event.code == code && event.arg == arg && event.time_us == time_us;
}

}  // namespace

TEST_CASE(a_release_counts_from_the_first_instant_at_which_both_were_open) {
  for (const uint32_t period_us : {1000u, 3571u, 100000u}) {
    Bench bench(period_us);
    bench.run_ms(500);
    const uint64_t t_us = bench.t_us;
    bench.change(1, true, t_us + 100);
    bench.change(0, true, t_us + 420);
    bench.change(0, false, t_us + 600);  // and they chatter
    bench.change(0, true, t_us + 650);
    if (period_us == 1000) {
      bench.run_ms(4);
      CHECK(bench.waiting() && bench.events.empty());
    }
    bench.run_ms(200);
    CHECK(bench.watch.phase() == DropPhase::kFalling && bench.events.size() == 1);
    CHECK(is(bench.events[0], EventCode::kRelease, 1, t_us + 420));
    CHECK(bench.watch.released_us(bench.t_us) == t_us + 420);
    CHECK(bench.watch.released_us(t_us) == t_us + 420);  // the main loop's clock may lag
  }
}

TEST_CASE(an_edge_that_was_lost_is_made_up_for_by_the_level) {
  Bench bench;
  bench.run_ms(500);
  bench.open = 3;
  bench.run_ms(20);
  CHECK(bench.watch.phase() == DropPhase::kFalling);
}

TEST_CASE(a_recording_that_begins_open_waits_for_the_robot_to_be_seated) {
  Bench bench;
  bench.open = 3;
  bench.run_ms(10000, 32767);
  CHECK(bench.waiting() && bench.events.empty());
  bench.both(false);
  bench.run_ms(kReleaseDebounceUs / 1000 - 1);  // too short to be seated
  bench.both(true);
  bench.run_ms(1000);
  CHECK(bench.waiting() && bench.events.empty());
  bench.both(false);
  bench.release();
  CHECK(bench.events.size() == 1);
}

TEST_CASE(a_release_right_after_the_recording_began_counts) {
  Bench bench;
  const uint64_t released_us = bench.release(kReleaseDebounceUs / 1000 + 2 * bench.period_us / 1000);
  CHECK(is(bench.events.back(), EventCode::kRelease, 1, released_us));
}

TEST_CASE(a_shock_lands_at_every_range_and_at_its_end) {
  struct Range {
    float counts_per_g;
    uint32_t lands, does_not;
  };
  // +-16 and +-8 g: 6 g; +-4 and +-2 g: the end of the range.
  const Range ranges[] = {{2048.0f, 12288, 12287},
                          {4096.0f, 24576, 24575},
                          {8192.0f, 32767, 32766},
                          {16384.0f, 32767, 32766}};
  for (const Range& range : ranges) {
    Bench bench;
    bench.watch.reset(range.counts_per_g);
    bench.release();
    bench.run_ms(2500, range.does_not);
    CHECK(bench.watch.phase() == DropPhase::kFalling && bench.events.size() == 1);
    bench.tick(range.lands);
    CHECK(bench.watch.phase() == DropPhase::kLanded && bench.events.size() == 2);
    CHECK(is(bench.events[1], EventCode::kLanding, 1, bench.t_us));
    CHECK(bench.events[1].value == static_cast<int>(range.lands * 1000.0f / range.counts_per_g));
    bench.run_ms(100, 32768);  // it rebounds
    CHECK(bench.events.size() == 2);
  }
}

TEST_CASE(the_jolt_of_the_release_is_no_landing) {
  Bench bench;
  const uint64_t released_us = bench.release();
  while (bench.t_us + 1000 < released_us + kLandingEarliestUs) bench.tick(32768);
  CHECK(bench.watch.phase() == DropPhase::kFalling);
  bench.tick(32768);
  CHECK(bench.watch.phase() == DropPhase::kLanded);
  CHECK(bench.events[1].time_us >= released_us + kLandingEarliestUs);
}

TEST_CASE(without_a_shock_time_lands) {
  Bench bench;
  const uint64_t released_us = bench.release();
  while (bench.t_us + 1000 < released_us + kLandingLatestUs) bench.tick(4000);
  CHECK(bench.watch.phase() == DropPhase::kFalling && bench.events.size() == 1);
  bench.tick(4000);
  CHECK(bench.watch.phase() == DropPhase::kLanded);
  CHECK(is(bench.events[1], EventCode::kLanding, 0, bench.t_us) && bench.events[1].value == 0);
}

TEST_CASE(a_release_that_closes_again_was_none) {
  Bench bench;
  const uint64_t released_us = bench.release();
  bench.both(false);
  bench.run_ms(kReleaseSeatedUs / 1000 - 1);
  bench.change(0, true, bench.t_us + 1);  // once more apart: the time begins anew
  bench.run_ms(2);
  bench.change(0, false, bench.t_us + 1);
  bench.run_ms(kReleaseSeatedUs / 1000);
  CHECK(!bench.waiting() && !bench.watch.seated());
  bench.run_ms(2);
  CHECK(bench.waiting() && bench.watch.seated() && bench.events.size() == 2);
  CHECK(is(bench.events.back(), EventCode::kRelease, 0, released_us));
  bench.run_ms(kLandingLatestUs / 1000, 20000);
  CHECK(bench.waiting());
  CHECK(bench.watch.releases() == 1);
  bench.release();
  CHECK(bench.watch.releases() == 2);
}

TEST_CASE(a_landing_is_one_whatever_the_robot_lies_on) {
  Bench bench;
  bench.release();
  bench.run_ms(2500, 20000);
  bench.both(false);
  bench.run_ms(60000);
  CHECK(bench.watch.phase() == DropPhase::kLanded && bench.watch.seated());
  CHECK(bench.events.size() == 2);
  bench.both(true);
  bench.run_ms(10);
  CHECK(bench.watch.phase() == DropPhase::kLanded && !bench.watch.seated());
}

TEST_CASE(a_robot_that_hangs_for_an_hour_is_released_like_any_other) {
  for (const uint32_t minutes : {17u, 18u, 20u, 35u, 36u, 71u}) {
    Bench bench(10000);
    bench.run_ms(minutes * 60000);
    const uint64_t released_us = bench.release();
    CHECK(is(bench.events.back(), EventCode::kRelease, 1, released_us));
  }
}

TEST_CASE(a_new_recording_forgets_the_drop_before) {
  Bench bench;
  bench.release();
  bench.watch.reset(kCountsPerG);
  CHECK(bench.waiting());
  bench.run_ms(6000, 32767);  // open all the time
  CHECK(bench.waiting() && bench.events.size() == 1);
}
