// The sampling timer: a channel of the chip's periodic interrupt timer.
//
// It counts the crystal's 24 MHz. The period is the nearest whole number of counts, so the rate is
// within 21 ppm of the one asked for (1 kHz is exact, 280 Hz comes 3 ppm fast), and samples carry
// the time that they were taken at in any case.
#pragma once

#include <Arduino.h>

#include "../core/ports.h"

namespace tfsat {
namespace logger {

class PeriodicTimer final : public SampleTimer {
 public:
  explicit PeriodicTimer(void (*on_tick)()) : on_tick_(on_tick) {}

  // Nothing else in the sketch uses one of the four channels, so there is always one to begin.
  void start(uint16_t rate_hz) override {
    timer_.priority(kPriority);
    timer_.begin(on_tick_, 1e6f / static_cast<float>(rate_hz));
  }

  // A tick in the middle of end() would find no function to call and never be acknowledged: the
  // interrupt would come for ever.
  void stop() override {
    noInterrupts();
    timer_.end();
    interrupts();
  }

 private:
  // Sampling takes up to 0.9 ms. It comes before the main loop and after everything that only takes
  // microseconds: the clock (32), edges (64), the card (96) and USB (128).
  static constexpr uint8_t kPriority = 192;

  IntervalTimer timer_;
  void (*on_tick_)();
};

}  // namespace logger
}  // namespace tfsat
