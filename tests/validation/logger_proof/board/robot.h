// The logger's sensors and inputs, register by register, and what goes wrong with them.
#pragma once

#include <string.h>

#include "../../../../firmware/teensy_logger/src/core/ports.h"
#include "scenario.h"
#include "truth.h"

namespace proof {

using tfsat::logger::Edge;
using tfsat::logger::I2cResult;

constexpr uint8_t kAsleep = 0x40;
constexpr int16_t kOneG = 2048;

inline int16_t signed_of(uint32_t bits) { return static_cast<int16_t>(static_cast<uint16_t>(bits)); }

// One MPU-6050: as much of it as the logger uses.
class Imu {
 public:
  void power_up(const Scenario& scenario, uint32_t index) {
    scenario_ = &scenario;
    index_ = index;
    memset(registers_, 0, sizeof registers_);
    memset(values_, 0, sizeof values_);
    registers_[kPower] = kAsleep;
  }

  // A sampling instant begins: what it measures there.
  // A fall between rest and a blow. Gyros show anything at all.
  void measure(uint64_t t_us, uint32_t tick) {
    if (!awake()) {
      memset(values_, 0, sizeof values_);
      return;
    }
    if (fails(t_us, ImuFault::kFrozen)) return;
    const bool falls = t_us >= scenario_->release_us && t_us < scenario_->landing_us;
    const bool lands = scenario_->landing_felt && t_us >= scenario_->landing_us &&
                       t_us < scenario_->landing_us + kLandingLastsUs;
    for (uint32_t channel = 0; channel < 7; ++channel) {
      const uint32_t bits = drawn_at(scenario_->seed, tick, 8 * index_ + channel);
      if (channel < 3 && !lands) {
        const int16_t rest = channel == 2 && !falls ? kOneG : 0;
        values_[channel] = static_cast<int16_t>(rest + static_cast<int16_t>(bits % 128) - 64);
      } else {
        values_[channel] = signed_of(bits);
      }
    }
    if (lands) values_[0] = INT16_MAX;
  }
  // What comes back foreign was away for longer than a glitch.
  bool answers(uint64_t t_us) const {
    if (fails(t_us, ImuFault::kNack)) return false;
    const bool changes = fails(t_us, ImuFault::kForeign);
    return !changes || t_us >= scenario_->fault_from_us[index_] + 40000;
  }
  bool hangs_bus(uint64_t t_us) const { return fails(t_us, ImuFault::kHang); }
  bool holds_bus(uint64_t t_us) const { return fails(t_us, ImuFault::kStuckBus); }
  void read(uint64_t t_us, uint8_t reg, uint8_t* data, uint8_t size) const {
    if (reg == kBurst && size == 14) {
      for (uint32_t i = 0; i < 7; ++i) {
        const uint16_t bits = static_cast<uint16_t>(values_[i]);
        data[2 * i] = static_cast<uint8_t>(bits >> 8);
        data[2 * i + 1] = static_cast<uint8_t>(bits);
      }
      return;
    }
    memcpy(data, registers_ + reg, size);
    if (reg == kWhoAmI) data[0] = fails(t_us, ImuFault::kForeign) ? 0x12 : 0x68;
  }
  void write(uint8_t reg, uint8_t value) {
    if (reg == kPower && (value & 0x80) != 0) {
      memset(registers_, 0, sizeof registers_);
      registers_[kPower] = kAsleep;
      return;
    }
    registers_[reg] = value;
  }
  bool awake() const { return (registers_[kPower] & 0x40) == 0; }
  const int16_t* values() const { return values_; }

 private:
  static constexpr uint8_t kPower = 0x6B;
  static constexpr uint8_t kWhoAmI = 0x75;
  static constexpr uint8_t kBurst = 0x3B;
  static constexpr uint64_t kLandingLastsUs = 20000;

  bool fails(uint64_t t_us, ImuFault fault) const {
    return scenario_->fault[index_] == fault && t_us >= scenario_->fault_from_us[index_] &&
           t_us < scenario_->fault_to_us[index_];
  }

  const Scenario* scenario_ = nullptr;
  uint32_t index_ = 0;
  int16_t values_[7] = {};
  uint8_t registers_[128] = {};
};

// Two of them at one bus. A transfer is over when it is asked for the second time.
class Bus final : public tfsat::logger::I2cBus {
 public:
  void power_up(const Scenario& scenario, uint32_t first_imu) {
    for (uint32_t i = 0; i < 2; ++i) imus_[i].power_up(scenario, first_imu + i);
    served_ = 0;
  }

  void measure(uint64_t t_us, uint32_t tick) {
    t_us_ = t_us;
    served_ = 0;
    freed_ = false;
    for (Imu& imu : imus_) imu.measure(t_us, tick);
  }
  // Bit 0, 1: the sensor gave a whole burst, awake, at this instant.
  uint8_t served() const { return served_; }
  const Imu& imu(uint32_t i) const { return imus_[i]; }

  void set_clock(uint16_t) override {}
  void start_read(uint8_t address, uint8_t reg, uint8_t* data, uint8_t size) override {
    if (!begin(address)) return;
    const Imu& imu = imus_[address & 1];
    imu.read(t_us_, reg, data, size);
    if (size == 14 && imu.awake()) served_ |= static_cast<uint8_t>(1u << (address & 1));
  }
  void start_write(uint8_t address, uint8_t reg, uint8_t value) override {
    if (begin(address)) imus_[address & 1].write(reg, value);
  }
  I2cResult poll() override {
    if (asked_) return result_;
    asked_ = true;
    return I2cResult::kBusy;
  }
  void recover() override { freed_ = true; }

 private:
  // False when nothing is transferred.
  bool begin(uint8_t address) {
    asked_ = false;
    const uint32_t i = address & 1;
    result_ = I2cResult::kDone;
    if (!freed_ && (imus_[0].holds_bus(t_us_) || imus_[1].holds_bus(t_us_))) {
      result_ = I2cResult::kStuck;
    } else if (imus_[i].hangs_bus(t_us_)) {
      result_ = I2cResult::kTimeout;
    } else if (!imus_[i].answers(t_us_)) {
      result_ = I2cResult::kNack;
    }
    return result_ == I2cResult::kDone;
  }

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
  void measure(uint64_t t_us, uint32_t tick) {
    converted_ = 0x3F;
    if (scenario_->dead_angle < 6 && t_us >= scenario_->fault_from_us[0]) {
      converted_ ^= static_cast<uint8_t>(1u << scenario_->dead_angle);
    }
    for (uint32_t i = 0; i < 6; ++i) {
      const bool dead = (converted_ & (1u << i)) == 0;
      values_[i] = dead ? 0 : drawn_at(scenario_->seed, tick, 64 + i) % 4096;
    }
  }
  // A channel that was not converted leaves anything.
  uint8_t read(uint16_t counts[tfsat::protocol::kAngleSensorCount]) override {
    for (uint32_t i = 0; i < 6; ++i) counts[i] = (converted_ & (1u << i)) != 0 ? values_[i] : 0x0BAD;
    return converted_;
  }

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
  void power_up(const Scenario& scenario, Truth& truth) {
    constexpr uint32_t kStrokesUs[] = {700000, 1050000, 1470000, 1820000};
    count_ = taken_ = 0;
    Draw draw(scenario.seed, 5);
    const uint64_t release_us = scenario.release_us;
    if (scenario.knock_us != kNever) {
      both(scenario.knock_us, scenario.second_switch_us, true);
      both(scenario.knock_ends_us, scenario.second_switch_us, false);
    }
    if (draw.one_in(2)) {  // chatter of the switch that opens first; both have been open by then once
      const uint64_t gap_us = draw.between(20, 400);
      add(release_us - 2 * gap_us, Edge::Source::kSwitch, 0, true);
      add(release_us - gap_us, Edge::Source::kSwitch, 0, false);
    }
    both(release_us, scenario.second_switch_us, true);
    for (const uint32_t after_us : kStrokesUs) {
      add(release_us + scenario.second_switch_us + after_us, Edge::Source::kStroke, 0, true);
    }
    edges_[count_ - 1].lost = static_cast<uint16_t>(draw.between(0, 4));
    if (scenario.reclosed_us != kNever) {
      both(scenario.reclosed_us, scenario.second_switch_us, false);
    }
    for (uint32_t i = 0; i < count_; ++i) {
      EdgeTruth& edge = truth.edges.add();
      edge.t_us = edges_[i].t_us;
      edge.source = edges_[i].source == Edge::Source::kStroke;
      edge.index = edges_[i].index;
      edge.open = edges_[i].open;
      edge.lost = static_cast<uint8_t>(edges_[i].lost);
    }
  }
  void set_now(uint64_t t_us) { now_us_ = t_us; }

  bool take_edge(Edge& edge) override {
    if (taken_ == count_ || edges_[taken_].t_us > now_us_) return false;
    edge = edges_[taken_++];
    return true;
  }
  uint8_t switches_open() override {
    uint8_t open = 0;
    for (uint32_t i = 0; i < count_ && edges_[i].t_us <= now_us_; ++i) {
      if (edges_[i].source != Edge::Source::kSwitch) continue;
      const uint8_t bit = static_cast<uint8_t>(1u << edges_[i].index);
      open = static_cast<uint8_t>(edges_[i].open ? open | bit : open & ~bit);
    }
    return open;
  }

 private:
  static constexpr uint32_t kRoom = 32;
  void both(uint64_t t_us, uint64_t apart_us, bool open) {
    add(t_us, Edge::Source::kSwitch, 0, open);
    add(t_us + apart_us, Edge::Source::kSwitch, 1, open);
  }
  void add(uint64_t t_us, Edge::Source source, uint8_t index, bool open) {
    edges_[count_++] = Edge{t_us, source, index, open, 0};
  }

  tfsat::logger::Edge edges_[kRoom] = {};
  uint32_t count_ = 0;
  uint32_t taken_ = 0;
  uint64_t now_us_ = 0;
};

}  // namespace proof
