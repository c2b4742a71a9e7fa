#include "sampler.h"

namespace tfsat {
namespace logger {

using protocol::ErrorCode;
using protocol::EventCode;
using protocol::kAngleSensorCount;
using protocol::kImuCount;
using protocol::kSwitchCount;

Sampler::Sampler(I2cBus& bus_a, I2cBus& bus_b, Adc& adc, Inputs& inputs)
    : lanes_{Lane(bus_a), Lane(bus_b)}, adc_(adc), inputs_(inputs) {}

void Sampler::apply(const protocol::LoggerSettings& settings) {
  for (Lane& lane : lanes_) lane.apply(settings);
  for (Told& told : told_) told = {};
}

void Sampler::Lane::apply(const protocol::LoggerSettings& settings) {
  bus_.set_clock(settings.bus_khz);
  for (Mpu6050& imu : imus_) imu.apply(settings);
}

void Sampler::Lane::begin(uint64_t t_us) {
  next_ = 0;
  recovered_ = false;
  start_next(t_us);
}

bool Sampler::Lane::advance(uint64_t t_us) {
  if (transferring_) {
    const I2cResult result = bus_.poll();
    if (result == I2cResult::kBusy) return true;
    finish(result, t_us);
  }
  return start_next(t_us);
}

bool Sampler::Lane::start_next(uint64_t t_us) {
  while (next_ < kImusPerBus) {
    if (imus_[next_].start(bus_, t_us)) return transferring_ = true;
    ++next_;
  }
  return false;
}

// A bus that breaks down is clocked free once an instant, which is what timing.h has time for. At
// the second breakdown it is left alone until the next instant.
void Sampler::Lane::finish(I2cResult result, uint64_t t_us) {
  transferring_ = false;
  const bool broke_down = result == I2cResult::kTimeout || result == I2cResult::kStuck;
  if (broke_down && recovered_) {
    while (next_ < kImusPerBus) imus_[next_++].finish(result, t_us);
    return;
  }
  // On a stuck bus the addressed sensor is not to blame: its transfer is begun again.
  if (result != I2cResult::kStuck) imus_[next_++].finish(result, t_us);
  if (!broke_down) return;
  bus_.recover();
  recovered_ = true;
}

void Sampler::sample(uint64_t t_us, Instant& instant) {
  instant = Instant();
  instant.t_us = t_us;
  for (Lane& lane : lanes_) lane.begin(t_us);
  read_pins(instant.sample);
  finish_transfers(t_us);
  take_readings(instant);
}

void Sampler::read_pins(protocol::Sample& sample) {
  const uint8_t converted = adc_.read(sample.angle);
  for (uint8_t i = 0; i < kAngleSensorCount; ++i) {
    if (converted & (1u << i)) {
      sample.flags |= sample_flags::angle_valid(i);
    } else {
      sample.angle[i] = 0;
    }
  }
  const uint8_t open = inputs_.switches_open();
  for (uint8_t i = 0; i < kSwitchCount; ++i) {
    if (open & (1u << i)) sample.flags |= sample_flags::switch_open(i);
  }
}

void Sampler::finish_transfers(uint64_t t_us) {
  bool more;
  do {
    more = false;
    for (Lane& lane : lanes_) more |= lane.advance(t_us);
  } while (more);
}

void Sampler::take_readings(Instant& instant) {
  for (uint8_t i = 0; i < kImuCount; ++i) {
    note_change(i, instant);
    if (!imu(i).fresh()) continue;
    instant.sample.imu[i] = imu(i).reading();
    instant.sample.flags |= sample_flags::imu_valid(i);
    if (imu(i).clipped()) instant.sample.flags |= sample_flags::imu_clipped(i);
  }
}

// An event when a sensor stops, when the cause becomes another, and when it runs again.
void Sampler::note_change(uint8_t imu_index, Instant& instant) {
  const Mpu6050& sensor = imu(imu_index);
  Told& told = told_[imu_index];
  if (sensor.running() == told.running && sensor.error() == told.error) return;
  const bool was_running = told.running;
  told = {sensor.running(), sensor.error()};
  protocol::Event& event = instant.events[instant.event_count++];
  event.time_us = instant.t_us;
  event.code = told.running ? EventCode::kSensorRecovered : EventCode::kSensorFault;
  event.index = imu_index;
  event.arg = static_cast<uint16_t>(told.error);
  const bool froze = was_running && told.error == ErrorCode::kSensorFrozen;
  event.value = froze ? static_cast<int32_t>(sensor.still_us()) : 0;
}

uint8_t Sampler::imu_present() const {
  uint8_t present = 0;
  for (uint8_t i = 0; i < kImuCount; ++i) {
    if (imu(i).running()) present |= static_cast<uint8_t>(1u << i);
  }
  return present;
}

void Sampler::copy_who_am_i(uint8_t who_am_i[kImuCount]) const {
  for (uint8_t i = 0; i < kImuCount; ++i) who_am_i[i] = imu(i).who_am_i();
}

}  // namespace logger
}  // namespace tfsat
