// The logger's sensors and inputs, register by register, and what goes wrong with them.
#pragma once

#include "../../../firmware/teensy_logger/src/core/ports.h"
#include "draw.h"
#include "scenario.h"
#include "truth.h"

namespace proof {

// One MPU-6050: as much of it as the logger uses.
class Imu {
 public:
  void power_up(const Scenario& scenario, uint32_t index);

  // A sampling instant begins: what it measures there.
  void measure(uint64_t t_us, uint32_t tick);
  bool answers(uint64_t t_us) const;
  bool hangs_bus(uint64_t t_us) const { return fails(t_us, ImuFault::kHang); }
  bool holds_bus(uint64_t t_us) const { return fails(t_us, ImuFault::kStuckBus); }
  void read(uint64_t t_us, uint8_t reg, uint8_t* data, uint8_t size) const;
  void write(uint8_t reg, uint8_t value);
  bool awake() const { return (registers_[kPower] & 0x40) == 0; }
  const int16_t* values() const { return values_; }

 private:
  static constexpr uint8_t kPower = 0x6B;
  static constexpr uint8_t kWhoAmI = 0x75;
  static constexpr uint8_t kBurst = 0x3B;
  static constexpr uint64_t kLandingLastsUs = 20000;

  bool fails(uint64_t t_us, ImuFault fault) const;

  const Scenario* scenario_ = nullptr;
  uint32_t index_ = 0;
  int16_t values_[7] = {};
  uint8_t registers_[128] = {};
};

// Two of them at one bus. A transfer is over when it is asked for the second time.
class Bus final : public tfsat::logger::I2cBus {
 public:
  void power_up(const Scenario& scenario, uint32_t first_imu);

  void measure(uint64_t t_us, uint32_t tick);
  // Bit 0, 1: the sensor gave a whole burst, awake, at this instant.
  uint8_t served() const { return served_; }
  const Imu& imu(uint32_t i) const { return imus_[i]; }

  void set_clock(uint16_t) override {}
  void start_read(uint8_t address, uint8_t reg, uint8_t* data, uint8_t size) override;
  void start_write(uint8_t address, uint8_t reg, uint8_t value) override;
  tfsat::logger::I2cResult poll() override;
  void recover() override { freed_ = true; }

 private:
  bool begin(uint8_t address);

  Imu imus_[2];
  uint64_t t_us_ = 0;
  tfsat::logger::I2cResult result_ = tfsat::logger::I2cResult::kDone;
  uint8_t served_ = 0;
  bool asked_ = false;
  bool freed_ = false;  // since the instant began
};

class Angles final : public tfsat::logger::Adc {
 public:
  void power_up(const Scenario& scenario) { scenario_ = &scenario; }
  void measure(uint64_t t_us, uint32_t tick);
  uint8_t read(uint16_t counts[tfsat::protocol::kAngleSensorCount]) override;

  uint8_t converted() const { return converted_; }
  const uint16_t* values() const { return values_; }

 private:
  const Scenario* scenario_ = nullptr;
  uint16_t values_[6] = {};
  uint8_t converted_ = 0;
};

// Release switches, with a little chatter and maybe a knock before, and the strokes of 59/70.
class Script final : public tfsat::logger::Inputs {
 public:
  void power_up(const Scenario& scenario, Truth& truth);
  void set_now(uint64_t t_us) { now_us_ = t_us; }

  bool take_edge(tfsat::logger::Edge& edge) override;
  uint8_t switches_open() override;

 private:
  static constexpr uint32_t kRoom = 32;
  void both(uint64_t t_us, uint64_t apart_us, bool open);
  void add(uint64_t t_us, tfsat::logger::Edge::Source source, uint8_t index, bool open);

  tfsat::logger::Edge edges_[kRoom] = {};
  uint32_t count_ = 0;
  uint32_t taken_ = 0;
  uint64_t now_us_ = 0;
};

}  // namespace proof
