// The logger's port to an emulated I2C bus. Transfers take virtual time, so that the length of a
// sampling interrupt can be measured whatever fails.
#pragma once

#include <functional>

#include "../../../../firmware/teensy_logger/src/core/ports.h"
#include "../../../../firmware/teensy_logger/src/core/timing.h"
#include "../sensors/i2c_bus.h"

namespace tfsat {
namespace emulator {

// Virtual time that the sampling interrupt has taken since power-up: what it waits for moves it on.
struct InterruptClock {
  uint64_t us = 0;
  // Brings what the sensors see to the present time; empty: the world stands still meanwhile.
  std::function<void()> bring_world;
};

class BusPort final : public logger::I2cBus {
 public:
  BusPort(emulator::I2cBus& bus, InterruptClock& clock) : bus_(bus), clock_(clock) {}

  void set_clock(uint16_t khz) override { khz_ = khz; }
  void start_read(uint8_t address, uint8_t reg, uint8_t* data, uint8_t size) override {
    if (broken(address, size)) return;
    if (clock_.bring_world) clock_.bring_world();
    const bool acknowledged = bus_.read(address, reg, data, size);
    transfer(acknowledged, bus_.read_duration_us(size, clock_hz()), size);
  }
  void start_write(uint8_t address, uint8_t reg, uint8_t value) override {
    if (broken(address, 0)) return;
    const bool acknowledged = bus_.write(address, reg, &value, 1);
    transfer(acknowledged, bus_.write_duration_us(1, clock_hz()), 0);
  }
  logger::I2cResult poll() override {
    if (clock_.us >= ends_us_) return result_;
    clock_.us += kPollUs;
    return logger::I2cResult::kBusy;
  }
  void recover() override {
    clock_.us += logger::kI2cRecoveryUs;
    bus_.clock_free();
  }

 private:
  static constexpr uint64_t kPollUs = 1;

  uint32_t clock_hz() const { return khz_ * 1000u; }
  void end(logger::I2cResult result, uint64_t after_us) {
    result_ = result;
    ends_us_ = clock_.us + after_us;
  }
  bool broken(uint8_t address, uint8_t read_bytes) {
    if (bus_.stuck()) {
      end(logger::I2cResult::kStuck, logger::kI2cStuckUs);
      return true;
    }
    if (!bus_.hangs(address)) return false;
    bus_.set_stuck(true);
    end(logger::I2cResult::kTimeout, logger::i2c_read_deadline_us(khz_, read_bytes));
    return true;
  }
  void transfer(bool acknowledged, uint64_t duration_us, uint8_t read_bytes) {
    const uint64_t deadline_us = logger::i2c_read_deadline_us(khz_, read_bytes);
    if (!acknowledged) {
      end(logger::I2cResult::kNack, bus_.nack_duration_us(clock_hz()));
    } else if (duration_us > deadline_us) {
      end(logger::I2cResult::kTimeout, deadline_us);
    } else {
      end(logger::I2cResult::kDone, duration_us);
    }
  }

  emulator::I2cBus& bus_;
  InterruptClock& clock_;
  uint64_t ends_us_ = 0;
  uint16_t khz_ = 400;
  logger::I2cResult result_ = logger::I2cResult::kDone;
};

}  // namespace emulator
}  // namespace tfsat
