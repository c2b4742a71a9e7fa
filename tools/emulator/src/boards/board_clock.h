// A board's crystal or ceramic resonator: what the board counts while virtual time passes, from time
// 0 on. Both directions are exact in integers, so that a clock that is not off changes nothing.
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
  explicit BoardClock(double ppm) : rate_(static_cast<uint64_t>(kUnit + std::llround(ppm * 1000.0))) {}

  // What the board has counted by then, whole units only.
  uint64_t board_ns(uint64_t virtual_ns) const {
    return virtual_ns / kUnit * rate_ + virtual_ns % kUnit * rate_ / kUnit;
  }
  uint64_t board_us(uint64_t virtual_us) const { return board_ns(virtual_us * 1000) / 1000; }

  // The first virtual time by which the board has counted so far; never stays never.
  uint64_t virtual_ns(uint64_t board_ns) const {
    return board_ns / rate_ * kUnit + rounded_up(board_ns % rate_ * kUnit, rate_);
  }
  uint64_t virtual_us(uint64_t board_us) const {
    return board_us == kNever ? kNever : rounded_up(virtual_ns(board_us * 1000), 1000);
  }

 private:
  static constexpr uint64_t kUnit = 1000000000;
  static constexpr uint64_t kNever = UINT64_MAX;

  static uint64_t rounded_up(uint64_t a, uint64_t b) { return (a + b - 1) / b; }

  uint64_t rate_;  // of the board's time, for kUnit of virtual time
};

}  // namespace emulator
}  // namespace tfsat
