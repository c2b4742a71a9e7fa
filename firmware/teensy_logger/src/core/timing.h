// What an I2C bus carries: how long transfers take, and how often all sensors can be read.
//
// A bus reads its two IMUs one after the other while the other bus does the same. Whatever fails,
// the next sampling instant must not wait for it.
#pragma once

#include <stdint.h>

#include "../protocol/messages.h"

namespace tfsat {
namespace logger {

// One 14-byte burst: 390 us at 400 kHz, on lines that rise at once.
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

// Before a start the master waits until the bus is idle.
constexpr uint32_t kI2cIdleUs = 8;
// At 400 kHz a bit is 2.5 us and the time that the clock line takes to rise to the master's threshold,
// 0.7 of the supply: on a bus that docs/wiring.md permits this at most (docs/wiring.toml, i2c_bit_rise_s
// and i2c_margin_s; a test compares them). At 100 kHz Wire's own bit, 9.9 us, leaves time for that.
constexpr uint32_t kI2cRiseNs = 230;
// A bit that takes so much longer still is of a broken transfer.
constexpr uint32_t kI2cMarginNs = 45;

constexpr uint32_t i2c_slack_us(uint32_t bits) {
  return kI2cIdleUs + (bits * (kI2cRiseNs + kI2cMarginNs) + 999) / 1000;
}
// A read of `bytes`: 9 bits for each, for both addresses and the register, 3 for start, restart and
// stop.
constexpr uint32_t i2c_read_bits(uint32_t bytes) { return 9u * (3u + bytes) + 3u; }
// A transfer that takes longer is broken.
constexpr uint32_t i2c_read_deadline_us(uint16_t bus_khz, uint32_t bytes) {
  return (i2c_read_bits(bytes) * 1000u + bus_khz - 1) / bus_khz + i2c_slack_us(i2c_read_bits(bytes));
}
constexpr uint32_t i2c_deadline_us(uint16_t bus_khz) {
  return i2c_read_deadline_us(bus_khz, protocol::ImuReading::kSize);
}
static_assert(i2c_deadline_us(400) ==
                  imu_burst_us(400) + i2c_slack_us(protocol::kImuBurstBits),
              "a burst is such a read");
// What a burst takes at most on a sound bus.
constexpr uint32_t imu_burst_max_us(uint16_t bus_khz) {
  const uint32_t rise_ns = bus_khz < 400 ? 0 : kI2cRiseNs;
  return imu_burst_us(bus_khz) + (protocol::kImuBurstBits * rise_ns + 999) / 1000;
}

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
static_assert(kI2cStuckUs + kI2cRecoveryUs +
                      protocol::kImusPerBus * i2c_slack_us(protocol::kImuBurstBits) <=
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
