// A board's crystal or ceramic resonator: what the board counts while virtual time passes, from time
// 0 on. Both directions are exact in integers, so that a clock that is not off changes nothing. Its
// error may change: what was counted by then stays counted.
//
// What the board's own peripherals take (a block on the card, a byte of EEPROM, a poll of its USB) is
// counted with it; bodies, servos, sensors and what a person does are in virtual time.
#pragma once

#include <cmath>
#include <cstdint>

namespace tfsat {
namespace emulator {

class BoardClock {
 public:
  // A crystal is off by tens of ppm; the ceramic resonator of some copies of an Arduino by 5000.
  static constexpr double kMostPpm = 20000.0;
  static bool takes(double ppm) { return std::abs(ppm) <= kMostPpm; }

  // Positive: the board is fast. To a thousandth of a ppm.
  explicit BoardClock(double ppm) : rate_(rate_of(ppm)) {}

  // From this virtual time on, which is not before the last change.
  void set_ppm(uint64_t virtual_us, double ppm) {
    const uint64_t now_ns = virtual_us * 1000;
    board_origin_ns_ = board_ns(now_ns);
    virtual_origin_ns_ = now_ns;
    rate_ = rate_of(ppm);
  }

  // What the board has counted by then, whole units only. Not of times before the last change.
  uint64_t board_ns(uint64_t virtual_ns) const {
    const uint64_t since = virtual_ns - virtual_origin_ns_;
    return board_origin_ns_ + since / kUnit * rate_ + since % kUnit * rate_ / kUnit;
  }
  uint64_t board_us(uint64_t virtual_us) const { return board_ns(virtual_us * 1000) / 1000; }

  // The first virtual time by which the board has counted so far; never stays never. What it had
  // counted before the last change is told as of then.
  uint64_t virtual_ns(uint64_t board_ns) const {
    if (board_ns < board_origin_ns_) return virtual_origin_ns_;
    const uint64_t since = board_ns - board_origin_ns_;
    return virtual_origin_ns_ + since / rate_ * kUnit + rounded_up(since % rate_ * kUnit, rate_);
  }
  uint64_t virtual_us(uint64_t board_us) const {
    return board_us == kNever ? kNever : rounded_up(virtual_ns(board_us * 1000), 1000);
  }

 private:
  static constexpr uint64_t kUnit = 1000000000;
  static constexpr uint64_t kNever = UINT64_MAX;

  static uint64_t rounded_up(uint64_t a, uint64_t b) { return (a + b - 1) / b; }
  static uint64_t rate_of(double ppm) { return static_cast<uint64_t>(kUnit + std::llround(ppm * 1000.0)); }

  uint64_t rate_;  // of the board's time, for kUnit of virtual time
  uint64_t virtual_origin_ns_ = 0;
  uint64_t board_origin_ns_ = 0;
};

}  // namespace emulator
}  // namespace tfsat
