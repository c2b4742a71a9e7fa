#include "boards/board_clock.h"

#include <cmath>
#include <initializer_list>
#include <limits>

#include "check.h"

using tfsat::emulator::BoardClock;

namespace {

constexpr uint64_t kDay_ns = 86400000000000;
constexpr double kPpm[] = {-20000.0, -123.456, -0.001, 0.0, 0.001, 50.0, 20000.0};
constexpr uint64_t kTimes[] = {0, 1, 999, 999999999, 1000000000, 1000000001, 123456789012345, 365 * kDay_ns};

}  // namespace

TEST_CASE(an_exact_clock_counts_virtual_time) {
  const BoardClock exact(0.0);
  for (const uint64_t t : kTimes) {
    CHECK(exact.board_ns(t) == t);
    CHECK(exact.virtual_ns(t) == t);
    CHECK(exact.board_us(t / 1000) == t / 1000);
    CHECK(exact.virtual_us(t / 1000) == t / 1000);
  }
}

TEST_CASE(a_clock_gains_its_ppm) {
  CHECK(BoardClock(10000.0).board_us(1000000) == 1010000);
  CHECK(BoardClock(-10000.0).board_us(1000000) == 990000);
  CHECK(BoardClock(0.001).board_ns(kDay_ns) == kDay_ns + kDay_ns / 1000000000);
  CHECK(BoardClock(10000.0).virtual_us(700000) == 693070);  // 0.70 s / 1.01, rounded up
  CHECK(BoardClock(-20000.0).virtual_ns(980000000) == 1000000000);
}

TEST_CASE(a_time_and_the_first_time_by_which_the_board_has_counted_it) {
  for (const double ppm : kPpm) {
    const BoardClock clock(ppm);
    for (const uint64_t t : kTimes) {
      CHECK(clock.board_ns(clock.virtual_ns(t)) >= t);
      CHECK(t == 0 || clock.board_ns(clock.virtual_ns(t) - 1) < t);
      const uint64_t t_us = t / 1000;
      CHECK(clock.board_us(clock.virtual_us(t_us)) >= t_us);
      CHECK(t_us == 0 || clock.board_us(clock.virtual_us(t_us) - 1) < t_us);
      CHECK(clock.virtual_ns(clock.board_ns(t)) <= t);
    }
  }
}

TEST_CASE(never_stays_never) {
  for (const double ppm : kPpm) CHECK(BoardClock(ppm).virtual_us(UINT64_MAX) == UINT64_MAX);
}

TEST_CASE(only_clocks_that_boards_have_are_taken) {
  for (const double ppm : kPpm) CHECK(BoardClock::takes(ppm));
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double ppm : {20000.1, -20000.1, 1e30, infinite, -infinite, std::nan("")}) CHECK(!BoardClock::takes(ppm));
}

TEST_CASE(a_clock_that_goes_wrong_keeps_what_it_has_counted) {
  BoardClock clock(0.0);
  CHECK(clock.board_us(1000000) == 1000000);
  clock.set_ppm(1000000, 10000.0);
  CHECK(clock.board_us(1000000) == 1000000);
  CHECK(clock.board_us(3000000) == 3020000);
  CHECK(clock.virtual_us(3020000) == 3000000);
  clock.set_ppm(3000000, -10000.0);
  CHECK(clock.board_us(4000000) == 4010000);
  CHECK(clock.virtual_us(4010000) == 4000000);
  CHECK(clock.virtual_us(3000000) == 3000000);  // counted before the change
  CHECK(clock.virtual_us(UINT64_MAX) == UINT64_MAX);
  for (uint64_t t_us = 3000000; t_us < 3010000; t_us += 7) CHECK(clock.board_us(clock.virtual_us(t_us + 20000)) >= t_us + 20000);
}
