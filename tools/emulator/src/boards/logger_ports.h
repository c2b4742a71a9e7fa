// The emulated hardware behind the smaller ports of the logger's core.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "../../../../firmware/teensy_logger/src/core/ports.h"
#include "../../../../firmware/teensy_logger/src/core/timing.h"
#include "../../../../firmware/teensy_logger/src/protocol/link.h"
#include "../sensors/angle_sensor.h"

namespace tfsat {
namespace emulator {

class AdcPort final : public logger::Adc {
 public:
  // What each sensor looks at, at the sampling instant.
  struct Joint {
    double angle_rad, rate_rad_s;
  };
  using Joints = std::array<Joint, protocol::kAngleSensorCount>;
  // Which sensor each pin is connected to; negative: none, and the pull-down reads 0.
  using Wires = std::array<int, protocol::kAngleSensorCount>;

  AdcPort(std::vector<AngleSensor>& sensors, const Joints& joints, const Wires& wires)
      : sensors_(sensors), joints_(joints), wires_(wires) {}

  uint8_t read(uint16_t counts[protocol::kAngleSensorCount]) override {
    uint8_t converted = 0;
    for (size_t i = 0; i < sensors_.size() && i < joints_.size(); ++i) {
      const double late_s = 1e-6 * logger::angle_offset_us(static_cast<uint32_t>(i));
      counts[i] = wires_[i] < 0 ? 0 : convert(static_cast<size_t>(wires_[i]), late_s);
      converted |= static_cast<uint8_t>(1u << i);
    }
    return converted;
  }

 private:
  uint16_t convert(size_t sensor, double late_s) {
    return sensors_[sensor].convert(joints_[sensor].angle_rad + late_s * joints_[sensor].rate_rad_s);
  }

  std::vector<AngleSensor>& sensors_;
  const Joints& joints_;
  const Wires& wires_;
};

class InputsPort final : public logger::Inputs {
 public:
  bool take_edge(logger::Edge& edge) override {
    if (edges_.empty() || edges_.front().t_us > now_us_) return false;
    edge = edges_.front();
    edges_.pop_front();
    return true;
  }
  uint8_t switches_open() override { return open_; }

  // An edge is there for the board once its time has come.
  void set_now(uint64_t t_us) { now_us_ = t_us; }
  void set_switch(int index, bool open, uint64_t t_us) {
    const uint8_t bit = static_cast<uint8_t>(1u << index);
    if (((open_ & bit) != 0) == open) return;
    open_ ^= bit;
    edges_.push_back({t_us, logger::Edge::Source::kSwitch, static_cast<uint8_t>(index), open, 0});
  }
  void stroke(uint64_t t_us) {
    edges_.push_back({t_us, logger::Edge::Source::kStroke, 0, true, 0});
  }
  void preset(int index, bool open) {
    const uint8_t bit = static_cast<uint8_t>(1u << index);
    open_ = static_cast<uint8_t>(open ? open_ | bit : open_ & ~bit);
  }

 private:
  std::deque<logger::Edge> edges_;
  uint64_t now_us_ = 0;
  uint8_t open_ = 0;
};

class StreamPort final : public protocol::ByteStream {
 public:
  bool connected() override { return connected_; }
  int read() override {
    if (to_board_.empty()) return -1;
    const uint8_t byte = to_board_.front();
    to_board_.pop_front();
    return byte;
  }
  size_t write(const uint8_t* data, size_t size) override { return push(to_host_, data, size); }

  void set_connected(bool connected) {
    connected_ = connected;
    to_board_.clear();
    to_host_.clear();
  }
  size_t host_write(const uint8_t* data, size_t n) {
    return connected_ ? push(to_board_, data, n) : 0;
  }
  size_t host_read(uint8_t* data, size_t capacity) {
    const size_t n = std::min(capacity, to_host_.size());
    std::copy_n(to_host_.begin(), n, data);
    to_host_.erase(to_host_.begin(), to_host_.begin() + static_cast<std::ptrdiff_t>(n));
    return n;
  }

 private:
  static constexpr size_t kLinkBytes = 8192;  // each way; USB buffers on board and host

  static size_t push(std::deque<uint8_t>& queue, const uint8_t* data, size_t n) {
    const size_t taken = std::min(n, kLinkBytes - queue.size());
    queue.insert(queue.end(), data, data + taken);
    return taken;
  }

  std::deque<uint8_t> to_board_;
  std::deque<uint8_t> to_host_;
  bool connected_ = false;
};

// The sampling timer: the board asks it when the next tick comes.
class TimerPort final : public logger::SampleTimer {
 public:
  void start(uint16_t rate_hz) override {
    rate_hz_ = rate_hz;
    started_us_ = now_us_;
    ticks_ = 0;
  }
  void stop() override { rate_hz_ = 0; }

  void set_now(uint64_t t_us) { now_us_ = t_us; }
  // UINT64_MAX while it is stopped.
  uint64_t next_us() const {
    return rate_hz_ == 0 ? UINT64_MAX : started_us_ + (ticks_ + 1) * 1000000u / rate_hz_;
  }
  void pass() { ++ticks_; }

 private:
  uint64_t now_us_ = 0;
  uint64_t started_us_ = 0;
  uint64_t ticks_ = 0;
  uint16_t rate_hz_ = 0;
};

// What outlasts the power, in memory that is the board's.
class MemoryPort final : public logger::NonVolatile {
 public:
  explicit MemoryPort(std::vector<uint8_t>& bytes) : bytes_(bytes) {}

  void load(uint8_t* bytes, uint8_t size) override { std::copy_n(bytes_.begin(), size, bytes); }
  void save(const uint8_t* bytes, uint8_t size) override {
    std::copy_n(bytes, size, bytes_.begin());
  }

 private:
  std::vector<uint8_t>& bytes_;
};

// splitmix64 (Steele, Lea & Flood, OOPSLA 2014).
class SeededEntropy final : public logger::Entropy {
 public:
  explicit SeededEntropy(uint64_t seed) : state_(seed) {}
  uint32_t next() override {
    uint64_t z = state_ += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return static_cast<uint32_t>((z ^ (z >> 31)) >> 32);
  }

 private:
  uint64_t state_;
};

}  // namespace emulator
}  // namespace tfsat
