// What an I2C bus carries: how long transfers take, and how often all sensors can be read.
//
// A bus reads its two IMUs one after the other while the other bus does the same. Whatever fails,
// the next sampling instant must not wait for it.
#pragma once

#include <stdint.h>

#include "../protocol/messages.h"

namespace tfsat {
namespace logger {

// One 14-byte burst: 390 us at 400 kHz.
constexpr uint32_t imu_burst_us(uint16_t bus_khz) {
  return (protocol::kImuBurstBits * 1000u + bus_khz - 1) / bus_khz;
}

// From a sample's time to the moment of an IMU's reading: the chip holds what it shows from the
// start of the burst on (mpu6050.h), and the second of a bus waits for the first.
constexpr uint16_t imu_offset_us(uint16_t bus_khz, uint32_t imu) {
  return static_cast<uint16_t>(imu % protocol::kImusPerBus * imu_burst_us(bus_khz));
}
// The same of an angle sensor: one converter takes them in turn, 49 clocks of 10 MHz each
// (drivers/angle_adc.h).
constexpr uint32_t kAngleConversionUs = 5;
constexpr uint16_t angle_offset_us(uint32_t sensor) {
  return static_cast<uint16_t>(sensor * kAngleConversionUs);
}
// Both into a message or a header that has them.
template <typename Message>
void put_offsets(uint16_t bus_khz, Message& message) {
  for (uint32_t i = 0; i < protocol::kImuCount; ++i) {
    message.imu_offset_us[i] = imu_offset_us(bus_khz, i);
  }
  for (uint32_t i = 0; i < protocol::kAngleSensorCount; ++i) {
    message.angle_offset_us[i] = angle_offset_us(i);
  }
}

// A transfer that takes longer than its bits and a little is broken. The little: before a start the
// master waits until the bus is idle, 8 us, and then for each rise of the clock, 0.3 us at most
// (UM10204 rev. 7, table 10, fast mode), 47 us a burst. Slower lines need stronger pull-ups.
constexpr uint32_t kI2cIdleUs = 8;
constexpr uint32_t kI2cSlackUs = kI2cIdleUs + 47;
constexpr uint32_t i2c_deadline_us(uint16_t bus_khz) { return imu_burst_us(bus_khz) + kI2cSlackUs; }
// The same for a read of `bytes`: 9 bits for each, for both addresses and the register, 3 for
// start, restart and stop.
constexpr uint32_t i2c_read_deadline_us(uint16_t bus_khz, uint32_t bytes) {
  const uint32_t bits = 9u * (3u + bytes) + 3u;
  return (bits * 1000u + bus_khz - 1) / bus_khz + kI2cIdleUs + (bits * 3u + 9u) / 10u;
}
static_assert(i2c_read_deadline_us(400, 14) == i2c_deadline_us(400), "a burst is such a read");

// One setting of an IMU, which shows behind the bursts that it was not lost (mpu6050.h).
constexpr uint32_t proof_us(uint16_t bus_khz) {
  return (protocol::kImuProofBits * 1000u + bus_khz - 1) / bus_khz + protocol::kImuProofSlackUs;
}
static_assert(i2c_read_deadline_us(100, 1) <= proof_us(100) &&
                  i2c_read_deadline_us(400, 1) <= proof_us(400),
              "it is a read of one byte");

// Lines that are not idle this long after a transfer was begun are held low.
constexpr uint32_t kI2cStuckUs = 30;

// Nine clocks of 4 us, a stop and a new start of the master.
constexpr uint32_t kI2cRecoveryUs = 60;

// Nobody acknowledges: start, address and stop, and as much again for what went before.
constexpr uint32_t i2c_nack_us(uint16_t bus_khz) { return 22u * 1000u / bus_khz; }

// The worst that can happen to a bus at one instant (sampler.cpp): it is found stuck, clocked free,
// and then both transfers run into their deadlines.
static_assert(kI2cStuckUs + kI2cRecoveryUs + protocol::kImusPerBus * kI2cSlackUs <=
                  protocol::kSamplingMarginUs,
              "no fault may delay the next instant");

// The highest sampling rate that the buses carry at this clock: bursts, and behind them what a
// fault takes or one proof of the settings.
constexpr uint16_t max_rate_hz(uint16_t bus_khz) {
  const uint32_t margin_us = proof_us(bus_khz) > protocol::kSamplingMarginUs
                                 ? proof_us(bus_khz)
                                 : protocol::kSamplingMarginUs;
  const uint32_t period_us = protocol::kImusPerBus * imu_burst_us(bus_khz) + margin_us;
  const uint32_t rate_hz = 1000000u / period_us;
  return static_cast<uint16_t>(rate_hz < protocol::kSampleRateMaxHz ? rate_hz
                                                                    : protocol::kSampleRateMaxHz);
}

static_assert(max_rate_hz(400) == protocol::kSampleRateMaxHz, "1 kHz at 400 kHz");

}  // namespace logger
}  // namespace tfsat
