// The MPU-6050's digital low-pass for one channel: one real pole and a transport delay.
#pragma once

namespace tfsat {
namespace emulator {

// Order 1. The pole sits at the datasheet's bandwidth; the delay that the datasheet states beyond
// the pole's own is a pure transport delay. Where the pole alone would delay more than stated (10
// and 5 Hz: no single pole has 5 Hz and 18.6 ms at once) the pole is placed by the delay, because
// delay is what shifts data against data: the bandwidth is then 11.9 Hz (10 Hz) and 8.6 Hz (5 Hz).
// So the delay of slow signals is the datasheet's exactly, for every setting.
class LowPass {
 public:
  static constexpr double kTick_s = 125e-6;  // the 8 kHz at which the chip converts
  static constexpr double kMostLate_s = 0.01;

  // `delay_s` 0: nothing is filtered. `late_s`, at most kMostLate_s: the output comes so much later still.
  void configure(double bandwidth_hz, double delay_s, double late_s = 0.0);
  // All history becomes `value`.
  void reset(double value);
  // The next input, one tick after the last.
  void push(double input);
  double output() const;

 private:
  static constexpr int kDepth = 128;  // ticks: 15.9 ms; every setting needs less than 3.9 ms, and kMostLate_s

  void set_transport_delay(double delay_s);

  double pole_ = 0.0, from_old_ = 0.0, from_new_ = 1.0;  // y' = pole y + from_old u0 + from_new u1
  int delay_ticks_ = 0;
  double delay_fraction_ = 0.0;
  double input_ = 0.0;
  double history_[kDepth] = {};
  int newest_ = 0;
};

}  // namespace emulator
}  // namespace tfsat
