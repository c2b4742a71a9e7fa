#include "sampler.h"

namespace tfsat {
namespace logger {

using protocol::ErrorCode;
using protocol::EventCode;
using protocol::kAngleSensorCount;
using protocol::kImuCount;
using protocol::kSwitchCount;

namespace {

int32_t clamped(uint64_t us) { return us < INT32_MAX ? static_cast<int32_t>(us) : INT32_MAX; }

}  // namespace

Sampler::Sampler(I2cBus& bus_a, I2cBus& bus_b, Adc& adc, Inputs& inputs)
    : lanes_{Lane(bus_a, recovering_us_), Lane(bus_b, recovering_us_)}, adc_(adc), inputs_(inputs) {}

void Sampler::apply(const protocol::LoggerSettings& settings) {
  for (Lane& lane : lanes_) lane.apply(settings);
  for (Told& told : told_) told = {};
}

void Sampler::Lane::apply(const protocol::LoggerSettings& settings) {
  khz_ = settings.bus_khz;
  period_us_ = 1000000u / settings.rate_hz;
  used_us_ = kImusPerBus * imu_burst_max_us(khz_);
  check_first_ = !room_for_read(Mpu6050::kCheckBytes);
  bus_.set_clock(khz_);
  for (Mpu6050& imu : imus_) imu.apply(settings);
}

void Sampler::Lane::begin(uint64_t t_us) {
  next_ = next_check_ = 0;
  used_us_ = 0;
  recovered_ = passing_time_ = false;
  for (Mpu6050& imu : imus_) imu.begin();
  start_next(t_us);
}

bool Sampler::Lane::advance(uint64_t t_us) {
  if (transferring_) {
    const I2cResult result = bus_.poll();
    if (result == I2cResult::kBusy) return true;
    finish(result, t_us);
  }
  return start_next(t_us) || start_check(t_us);
}

bool Sampler::Lane::start_next(uint64_t t_us) {
  while (next_ < kImusPerBus) {
    Mpu6050& imu = imus_[next_];
    if (passing_time_) {
      imu.start_discarded(bus_);
      return transferring_ = true;
    }
    if (checked_first(imu)) {
      imu.start_check(bus_);
      return transferring_ = true;
    }
    if (imu.start(bus_, t_us)) return transferring_ = true;
    passing_time_ = ++next_ < kImusPerBus && imus_[next_].running() && !checked_first(imus_[next_]);
  }
  return false;
}

// Behind all bursts a sensor that missed one, now or at the instant before, shows its settings, and
// one that has long not shown any a part of them, if that ends before the next instant and no other
// needs the time more.
bool Sampler::Lane::start_check(uint64_t t_us) {
  while (next_check_ < kImusPerBus) {
    Mpu6050& imu = imus_[next_check_++];
    if (imu.doubted() && room_for_read(Mpu6050::kCheckBytes)) {
      imu.start_check(bus_);
      return transferring_ = true;
    }
    if (!any_doubted() && imu.proof_due(t_us) && room_for_read(Mpu6050::kProofBytes)) {
      imu.start_proof(bus_);
      return transferring_ = true;
    }
  }
  return false;
}

bool Sampler::Lane::any_doubted() const {
  for (const Mpu6050& imu : imus_) {
    if (imu.doubted()) return true;
  }
  return false;
}

bool Sampler::Lane::room_for_read(uint32_t bytes) const {
  return room_for(i2c_read_deadline_us(khz_, bytes));
}

void Sampler::Lane::recover() {
  bus_.recover();
  recovering_us_ += kI2cRecoveryUs;
}

uint32_t Sampler::Lane::longest_us(I2cResult result) const {
  switch (result) {
    case I2cResult::kNack:
      return i2c_nack_us(khz_);
    case I2cResult::kTimeout:
      return i2c_deadline_us(khz_);
    case I2cResult::kStuck:
      return kI2cStuckUs;
    case I2cResult::kBusy:
    case I2cResult::kDone:
      break;
  }
  return imu_burst_max_us(khz_);
}

// A bus that breaks down is clocked free once an instant, which is what timing.h has time for. At
// the second breakdown, or when both buses had to be freed and the rest could last too long, it is
// left alone until the next instant.
void Sampler::Lane::finish(I2cResult result, uint64_t t_us) {
  transferring_ = false;
  used_us_ += longest_us(result);
  const bool broke_down = result == I2cResult::kTimeout || result == I2cResult::kStuck;
  if (next_ == kImusPerBus) {
    imus_[next_check_ - 1].finish(result, t_us);
    if (broke_down && room_for(kI2cRecoveryUs)) recover();
    return;
  }
  if (broke_down && recovered_) return give_up(result, t_us);
  // On a stuck bus the addressed sensor is not to blame: its transfer is begun again.
  if (result != I2cResult::kStuck) {
    if (!passing_time_) imus_[next_++].finish(result, t_us);
    passing_time_ = false;
  }
  if (!broke_down) return;
  recover();
  recovered_ = true;
  const uint32_t left = static_cast<uint32_t>(kImusPerBus - next_) + passing_time_;
  if (!room_for(left * i2c_deadline_us(khz_))) give_up(result, t_us);
}

void Sampler::Lane::give_up(I2cResult result, uint64_t t_us) {
  passing_time_ = false;
  while (next_ < kImusPerBus) imus_[next_++].finish(result, t_us);
  next_check_ = kImusPerBus;
}

void Sampler::sample(uint64_t t_us, Instant& instant) {
  instant = Instant();
  instant.t_us = t_us;
  recovering_us_ = 0;
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

// An event when a sensor stops, when the cause becomes another, when it runs again, and when it
// misses an instant without any of that.
void Sampler::note_change(uint8_t imu_index, Instant& instant) {
  const Mpu6050& sensor = imu(imu_index);
  Told& told = told_[imu_index];
  if (sensor.running() == told.running && sensor.error() == told.error) {
    if (sensor.missed() == ErrorCode::kNone) return;
    protocol::Event& event = instant.events[instant.event_count++];
    event.time_us = instant.t_us;
    event.code = EventCode::kSensorMissed;
    event.index = imu_index;
    event.arg = static_cast<uint16_t>(sensor.missed());
    return;
  }
  const bool was_running = told.running;
  told = {sensor.running(), sensor.error()};
  protocol::Event& event = instant.events[instant.event_count++];
  event.time_us = instant.t_us;
  event.code = told.running ? EventCode::kSensorRecovered : EventCode::kSensorFault;
  event.index = imu_index;
  event.arg = static_cast<uint16_t>(told.error);
  if (told.running || told.error == ErrorCode::kSensorForeign) {
    event.value = sensor.who_am_i();
    return;
  }
  if (!was_running) return;
  const bool frozen = told.error == ErrorCode::kSensorFrozen;
  const uint64_t still_us = frozen ? sensor.still_us() : 0;
  event.value = clamped(sensor.suspect_us() > still_us ? sensor.suspect_us() : still_us);
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
