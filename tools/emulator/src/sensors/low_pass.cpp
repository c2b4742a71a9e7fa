#include "low_pass.h"

#include <cmath>

namespace tfsat {
namespace emulator {

void LowPass::configure(double bandwidth_hz, double delay_s, double late_s) {
  constexpr double kTwoPi = 6.283185307179586477;
  pole_ = from_old_ = 0.0;
  from_new_ = 1.0;
  delay_ticks_ = 0;
  delay_fraction_ = 0.0;
  if (!(delay_s > 0.0)) {
    set_transport_delay(late_s);
    return;
  }
  const double time_constant = std::fmin(1.0 / (kTwoPi * bandwidth_hz), delay_s);
  // Exact for an input that is linear between two ticks.
  pole_ = std::exp(-kTick_s / time_constant);
  const double mean = (1.0 - pole_) * time_constant / kTick_s;
  from_old_ = mean - pole_;
  from_new_ = 1.0 - mean;
  set_transport_delay(delay_s - time_constant + late_s);
}

void LowPass::set_transport_delay(double delay_s) {
  const double ticks = delay_s / kTick_s;
  delay_ticks_ = static_cast<int>(std::fmin(std::floor(ticks), kDepth - 2));
  delay_fraction_ = std::fmin(ticks - delay_ticks_, 1.0);
}

void LowPass::reset(double value) {
  input_ = value;
  for (double& h : history_) h = value;
}

void LowPass::push(double input) {
  const double filtered = pole_ * history_[newest_] + from_old_ * input_ + from_new_ * input;
  input_ = input;
  newest_ = (newest_ + 1) % kDepth;
  history_[newest_] = filtered;
}

double LowPass::output() const {
  const double near = history_[(newest_ + kDepth - delay_ticks_) % kDepth];
  const double far = history_[(newest_ + kDepth - delay_ticks_ - 1) % kDepth];
  return near + delay_fraction_ * (far - near);
}

}  // namespace emulator
}  // namespace tfsat
