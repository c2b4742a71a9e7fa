#include "sampler.h"

namespace tfsat {
namespace logger {

using protocol::EventCode;
using protocol::kAngleSensorCount;
using protocol::kImuCount;
using protocol::kSwitchCount;

Sampler::Sampler(I2cBus& bus_a, I2cBus& bus_b, Adc& adc, Inputs& inputs)
    : lanes_{Lane(bus_a), Lane(bus_b)}, adc_(adc), inputs_(inputs) {}

bool Sampler::Lane::advance(uint64_t t_us) {
  if (transferring_) {
    const I2cResult result = bus_.poll();
    if (result == I2cResult::kBusy) return true;
    finish(result, t_us);
  }
  while (next_ < kImusPerBus) {
    if (imus_[next_].start(bus_, t_us)) {
      transferring_ = true;
      return true;
    }
    ++next_;
  }
  return false;
}

void Sampler::Lane::finish(I2cResult result, uint64_t t_us) {
  transferring_ = false;
  imus_[next_++].finish(result, t_us);
  if (result == I2cResult::kTimeout || result == I2cResult::kStuck) bus_.recover();
}

void Sampler::sample(uint64_t t_us, Instant& instant) {
  instant = Instant();
  instant.t_us = t_us;

  uint16_t& flags = instant.sample.flags;
  const uint8_t converted = adc_.read(instant.sample.angle);
  for (uint8_t i = 0; i < kAngleSensorCount; ++i) {
    if (converted & (1u << i)) {
      flags |= sample_flags::angle_valid(i);
    } else {
      instant.sample.angle[i] = 0;
    }
  }
  const uint8_t open = inputs_.switches_open();
  for (uint8_t i = 0; i < kSwitchCount; ++i) {
    if (open & (1u << i)) flags |= sample_flags::switch_open(i);
  }
  read_imus(instant);
}

void Sampler::read_imus(Instant& instant) {
  bool was_running[kImuCount];
  for (uint8_t i = 0; i < kImuCount; ++i) was_running[i] = imu(i).running();

  for (Lane& lane : lanes_) lane.begin();
  bool more;
  do {
    more = false;
    for (Lane& lane : lanes_) more |= lane.advance(instant.t_us);
  } while (more);

  for (uint8_t i = 0; i < kImuCount; ++i) {
    note_change(i, was_running[i], instant);
    if (!imu(i).fresh()) continue;
    instant.sample.imu[i] = imu(i).reading();
    instant.sample.flags |= sample_flags::imu_valid(i);
    if (imu(i).clipped()) instant.sample.flags |= sample_flags::imu_clipped(i);
  }
}

void Sampler::note_change(uint8_t imu_index, bool was_running, Instant& instant) const {
  const Mpu6050& sensor = imu(imu_index);
  if (sensor.running() == was_running) return;
  protocol::Event& event = instant.events[instant.event_count++];
  event.time_us = instant.t_us;
  event.code = was_running ? EventCode::kSensorFault : EventCode::kSensorRecovered;
  event.index = imu_index;
  event.arg = static_cast<uint16_t>(sensor.error());
  event.value = 0;
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
