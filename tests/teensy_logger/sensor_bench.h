// Four emulated IMUs on two buses, read by the logger's sampler in virtual time.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "../../firmware/teensy_logger/src/core/sampler.h"
#include "../../firmware/teensy_logger/src/core/settings.h"
#include "boards/logger_bus_port.h"
#include "check.h"
#include "sensors/i2c_bus.h"
#include "sensors/mpu6050.h"

namespace tfsat_test {

using namespace tfsat;

constexpr double kG_m_s2 = 9.80665;
constexpr double kRad = 57.29577951308232;  // deg

// The emulated bus, with its calls counted, and with faults that hit a proof of settings alone.
class CountingPort final : public logger::I2cBus {
 public:
  enum class ProofFault : uint8_t { kNone, kNack, kTimeout };
  struct Burst {
    uint8_t address;
    uint64_t us;  // of the interrupt's clock, at its start
  };

  CountingPort(emulator::I2cBus& bus, emulator::InterruptClock& clock)
      : port_(bus, clock), bus_(bus), clock_(clock) {}
  void set_clock(uint16_t khz) override { port_.set_clock(khz); }
  void start_read(uint8_t address, uint8_t reg, uint8_t* data, uint8_t size) override {
    ++transfers;
    if (size == protocol::ImuReading::kSize) bursts.push_back({address, clock_.us});
    const bool proof = size == logger::Mpu6050::kProofBytes && reg < emulator::mpu6050::kIntEnable;
    const ProofFault fault = proof ? proof_fault : ProofFault::kNone;
    if (fault == ProofFault::kNack) bus_.glitch(address);
    if (fault == ProofFault::kTimeout) bus_.set_hanging(address, true);
    port_.start_read(address, reg, data, size);
    if (fault == ProofFault::kTimeout) bus_.set_hanging(address, false);
    proofs += proof;
    if (fault != ProofFault::kNone) proof_fault = ProofFault::kNone;
  }
  void start_write(uint8_t address, uint8_t reg, uint8_t value) override {
    ++transfers;
    port_.start_write(address, reg, value);
  }
  logger::I2cResult poll() override { return port_.poll(); }
  void recover() override {
    ++recoveries;
    port_.recover();
  }
  int transfers = 0, recoveries = 0, proofs = 0;
  ProofFault proof_fault = ProofFault::kNone;  // of the next one
  std::vector<Burst> bursts;  // of the last instant

 private:
  emulator::BusPort port_;
  emulator::I2cBus& bus_;
  emulator::InterruptClock& clock_;
};

class Angles final : public logger::Adc {
 public:
  explicit Angles(emulator::InterruptClock& clock) : clock_(clock) {}
  uint8_t read(uint16_t counts[protocol::kAngleSensorCount]) override {
    clock_.us += 30;
    for (uint16_t i = 0; i < protocol::kAngleSensorCount; ++i) {
      counts[i] = static_cast<uint16_t>(1000 + i);
    }
    return converted;
  }
  uint8_t converted = 0x3F;

 private:
  emulator::InterruptClock& clock_;
};

class Switches final : public logger::Inputs {
 public:
  bool take_edge(logger::Edge&) override { return false; }
  uint8_t switches_open() override { return open; }
  uint8_t open = 0;
};

// 280 Hz and the factory's ranges, unless `settings` say otherwise. IMU i turns at `rate_rad_s`
// about x and 0.1 i rad/s about y.
struct SensorBench {
  explicit SensorBench(const protocol::LoggerSettings& with = logger::factory_settings(),
                       emulator::Mpu6050Parameters parameters = {})
      : imus(4) {
    for (size_t i = 0; i < 4; ++i) {
      parameters.seed = i + 1;
      imus[i] = emulator::Mpu6050(parameters);
      buses[i / 2].attach(address(static_cast<int>(i)), imus[i]);
    }
    // The slowest bus that docs/wiring.md permits.
    for (emulator::I2cBus& bus : buses) bus.set_rise_ns(logger::kI2cRiseNs);
    apply(with);
  }

  static uint8_t address(int imu) { return static_cast<uint8_t>(0x68 + imu % 2); }
  emulator::I2cBus& bus_of(int imu) { return buses[static_cast<size_t>(imu / 2)]; }
  emulator::Mpu6050& imu(int i) { return imus[static_cast<size_t>(i)]; }

  void apply(const protocol::LoggerSettings& with) {
    settings = with;
    sampler.apply(with);
  }
  uint32_t period_us() const { return 1000000u / settings.rate_hz; }

  // The world goes on to this time.
  void move_to(uint64_t to_us) {
    for (size_t i = 0; i < 4; ++i) {
      const double pitch_rad_s = lateral_rad_s + 0.1 * static_cast<double>(i);
      imus[i].sample(to_us, {rate_rad_s, pitch_rad_s, lateral_rad_s},
                     {lateral_m_s2, lateral_m_s2, force_m_s2}, 25.0);
    }
  }
  void tick() {
    t_us = ++ticks * 1000000u / settings.rate_hz + start_us;
    move_to(t_us);
    before_us = clock.us;
    for (CountingPort* port : {&port_a, &port_b}) port->bursts.clear();
    sampler.sample(t_us, instant);
    interrupt_us = clock.us - before_us;
    longest_us = std::max(longest_us, interrupt_us);
    for (uint8_t e = 0; e < instant.event_count; ++e) events.push_back(instant.events[e]);
  }
  void run_ms(uint32_t ms) {
    for (const uint64_t end_us = t_us + 1000u * ms; t_us < end_us;) tick();
  }
  bool valid(int i) const { return (instant.sample.flags >> i) & 1; }
  // Runs and counts the instants in which an IMU other than `except` was not valid.
  int lost_by_others(uint32_t ms, int except) {
    int lost = 0;
    for (const uint64_t end_us = t_us + 1000u * ms; t_us < end_us;) {
      tick();
      for (int i = 0; i < 4; ++i) lost += i != except && !valid(i);
    }
    return lost;
  }

  protocol::LoggerSettings settings = {};
  emulator::InterruptClock clock;
  std::array<emulator::I2cBus, 2> buses;
  CountingPort port_a{buses[0], clock}, port_b{buses[1], clock};
  Angles angles{clock};
  Switches switches;
  std::vector<emulator::Mpu6050> imus;
  logger::Sampler sampler{port_a, port_b, angles, switches};
  logger::Instant instant = {};
  std::vector<protocol::Event> events;
  uint64_t t_us = 0, start_us = 0, ticks = 0;
  uint64_t before_us = 0, interrupt_us = 0, longest_us = 0;
  double rate_rad_s = 1.0, lateral_rad_s = 0.0;
  double force_m_s2 = kG_m_s2, lateral_m_s2 = 0.0;
};

}  // namespace tfsat_test
