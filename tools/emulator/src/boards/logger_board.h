// The logger as the emulated robot sees it: the firmware's core behind emulated ports.
//
// Its times are what the board's own clock has counted since power-up of the world: see
// board_clock.h. It samples at its timer's instants. Sensors show what their model was last given, so
// the world steps to next_sample_us(), brings the sensors there, then advances the board; and again
// to the time of each transfer on the buses, which a sampling instant is long.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "../../../../firmware/teensy_logger/src/core/logger.h"
#include "../card/block_device.h"
#include "../sensors/angle_sensor.h"
#include "../sensors/i2c_bus.h"
#include "logger_ports.h"

namespace tfsat {
namespace emulator {

struct LoggerBoardParameters {
  uint32_t loop_us = 500;             // time of one pass of the main loop, at least
  logger::Identity identity = {{'E', 'M', 'U', 'L', 'A', 'T', 'E', 'D'}, 0};  // what HELLO tells
};

class LoggerBoard {
 public:
  // `seed`: of the session ids.
  explicit LoggerBoard(uint64_t seed,
                       const LoggerBoardParameters& parameters = LoggerBoardParameters());
  ~LoggerBoard();

  // Wires the board up, once, before power. All parts stay the caller's. IMU 1 and 2 are on
  // buses[0] at 0x68 and 0x69, IMU 3 and 4 on buses[1]; angle sensors in the order of the log, two
  // a joint.
  void attach(std::array<I2cBus, 2>& buses, std::vector<AngleSensor>& angle_sensors,
              BlockDevice& card);
  // Who brings the IMUs to a time, in this clock, while the board samples; without one they stand.
  void set_world(std::function<void(uint64_t t_us)> bring) { bring_world_ = std::move(bring); }
  // The joint that angle sensor 0 to 5 looks at, as it is now and as it moves.
  void set_joint(int sensor, double angle_rad, double rate_rad_s);

  // Which angle sensor each pin is connected to; negative: none.
  void wire_angle_sensors(const AdcPort::Wires& wires) { angle_wires_ = wires; }

  // Off: RAM and the link are gone at once. What the card loses is the card's power_cut().
  void set_power(bool on);
  // Runs the board to this time; never runs it backwards.
  void advance_to(uint64_t t_us);
  // Time of the next sample; UINT64_MAX without power.
  uint64_t next_sample_us() const;

  // Release switch 0 or 1 changes at the present time; closed pulls the pin low.
  void set_switch(int index, bool closed) { set_switch(index, closed, now_us_); }
  // The same with its exact time, not before the last sample.
  void set_switch(int index, bool closed, uint64_t t_us);
  // The sequencer's stroke line rises.
  void stroke_edge(uint64_t t_us);

  // What outlasts the power: the stored settings.
  const std::vector<uint8_t>& memory() const { return memory_; }
  void set_memory(const std::vector<uint8_t>& bytes);

  // USB cable with a program that holds the port open. Pulling it drops what is under way.
  void set_cable(bool plugged);
  // Host -> board; returns how many bytes were taken. Board -> host; returns how many were given.
  size_t write(const uint8_t* data, size_t n);
  size_t read(uint8_t* data, size_t capacity);

 private:
  class Firmware;
  static constexpr size_t kMemoryBytes = 64;

  void sample(uint64_t t_us);
  uint64_t board_us(uint64_t t_us) const { return t_us - powered_us_; }

  std::array<I2cBus, 2>* buses_ = nullptr;
  std::vector<AngleSensor>* angle_sensors_ = nullptr;
  BlockDevice* card_ = nullptr;
  std::function<void(uint64_t)> bring_world_;
  AdcPort::Joints joints_{};
  AdcPort::Wires angle_wires_{{0, 1, 2, 3, 4, 5}};
  uint64_t seed_;
  LoggerBoardParameters parameters_;
  std::vector<logger::Block> ring_;
  std::vector<uint8_t> memory_;         // outlasts the power
  std::unique_ptr<Firmware> firmware_;  // present while there is power
  uint64_t now_us_ = 0;
  uint64_t powered_us_ = 0;
  uint64_t next_loop_us_ = 0;
  uint64_t work_until_us_ = 0;  // the processor is at the card's blocks or in the interrupt
  uint64_t boots_ = 0;
  bool switch_closed_[2] = {true, true};
  bool cable_ = false;
};

}  // namespace emulator
}  // namespace tfsat
