// One LPI2C master of the i.MX RT1062, polled.
//
// Wire starts the clocks and sets pins and bit timing; transfers go to the registers directly,
// because Wire can wait 16 to 50 ms for a bus that is held low, and cannot work on two buses at
// once. Sources: i.MX RT1060 Processor Reference Manual rev. 3, chapter 47 (LPI2C); WireIMXRT.cpp
// of Teensyduino's Wire.
#pragma once

#include <Arduino.h>
#include <Wire.h>

#include "../core/ports.h"
#include "../core/timing.h"

namespace tfsat {
namespace logger {

class Lpi2cBus final : public I2cBus {
 public:
  // `wire` must be the object that owns `port` and the two pins.
  Lpi2cBus(TwoWire& wire, IMXRT_LPI2C_t& port, uint8_t sda_pin, uint8_t scl_pin)
      : wire_(wire), port_(port), sda_pin_(sda_pin), scl_pin_(scl_pin) {}

  void begin() { restart(); }

  void set_clock(uint16_t khz) override;
  void start_read(uint8_t address, uint8_t reg, uint8_t* data, uint8_t size) override;
  void start_write(uint8_t address, uint8_t reg, uint8_t value) override;
  I2cResult poll() override;
  void recover() override;

 private:
  static constexpr uint8_t kMaxCommands = 5;
  static constexpr uint16_t kFastKhz = 400;

  void begin_transfer(uint8_t* data, uint8_t size);
  void push(uint32_t command) { commands_[command_count_++] = static_cast<uint16_t>(command); }
  bool take_bus(uint32_t waited_us);
  void feed();
  void drain();
  I2cResult give_up(I2cResult result);
  I2cResult end(I2cResult result) { return result_ = result; }
  void restart();

  TwoWire& wire_;
  IMXRT_LPI2C_t& port_;
  uint8_t* data_ = nullptr;
  uint32_t began_us_ = 0;
  uint16_t commands_[kMaxCommands] = {};
  uint8_t command_count_ = 0;
  uint8_t commands_sent_ = 0;
  uint8_t size_ = 0;
  uint8_t received_ = 0;
  uint8_t sda_pin_;
  uint8_t scl_pin_;
  uint16_t khz_ = kFastKhz;
  I2cResult result_ = I2cResult::kStuck;
  bool bus_taken_ = false;
  bool nacked_ = false;
};

}  // namespace logger
}  // namespace tfsat
