// One life of the logger: powered up, hung up, started over its cable, dropped, and cut off or
// closed.
#pragma once

#include "../../../firmware/teensy_logger/src/core/logger.h"
#include "card.h"
#include "clock.h"
#include "robot.h"

namespace proof {

// The sampling timer: when its next tick comes.
class Timer final : public tfsat::logger::SampleTimer {
 public:
  explicit Timer(const Clock& clock) : clock_(clock) {}
  void start(uint16_t rate_hz) override {
    rate_hz_ = rate_hz;
    started_us_ = clock_.now_us();
    ticks_ = 0;
  }
  void stop() override { rate_hz_ = 0; }
  uint64_t next_us() const {
    return rate_hz_ == 0 ? kNever : started_us_ + (ticks_ + 1) * 1000000u / rate_hz_;
  }
  void advance() { ++ticks_; }

 private:
  const Clock& clock_;
  uint64_t started_us_ = 0;
  uint64_t ticks_ = 0;
  uint16_t rate_hz_ = 0;
};

// The cable, with a host that only talks.
class Cable final : public tfsat::protocol::ByteStream {
 public:
  void send(uint8_t type, const uint8_t* payload, size_t size) {
    size_ += tfsat::protocol::encode_frame(type, sequence_++, payload, size, bytes_ + size_);
    connected_ = true;
  }
  void pull() { connected_ = false; }

  bool connected() override { return connected_; }
  int read() override { return read_ < size_ ? bytes_[read_++] : -1; }
  size_t write(const uint8_t*, size_t size) override { return size; }

 private:
  uint8_t bytes_[256];
  size_t size_ = 0;
  size_t read_ = 0;
  uint8_t sequence_ = 1;
  bool connected_ = false;
};

class Memory final : public tfsat::logger::NonVolatile {
 public:
  void load(uint8_t* bytes, uint8_t size) override { memcpy(bytes, bytes_, size); }
  void save(const uint8_t* bytes, uint8_t size) override { memcpy(bytes_, bytes, size); }

 private:
  uint8_t bytes_[64] = {};
};

class SessionIds final : public tfsat::logger::Entropy {
 public:
  explicit SessionIds(uint32_t seed) : draw_(seed, 6) {}
  uint32_t next() override { return draw_.next(); }

 private:
  Draw draw_;
};

class World final : private Clock {
 public:
  World(const Scenario& scenario, Medium& medium, tfsat::logger::Block* ring, Truth& truth);

  void live();

 private:
  uint64_t now_us() const override { return now_us_; }
  void pass(uint64_t us) override;
  bool dead() const override { return dead_; }
  void closing() override;

  uint64_t next_event_us() const;
  void happen();
  void tick();
  void talk();
  bool over() const;
  void tell_truth();

  const Scenario& scenario_;
  Truth& truth_;
  Medium& medium_;
  Draw loop_;
  uint64_t now_us_ = 0;
  uint64_t cut_us_;
  uint32_t ticks_ = 0;
  uint32_t pull_ = 0;
  uint8_t told_ = 0;
  bool gone_ = false;
  bool dead_ = false;

  Bus bus_a_, bus_b_;
  Angles angles_;
  Script script_;
  Timer timer_;
  Card card_;
  Memory memory_;
  Cable cable_;
  SessionIds ids_;
  tfsat::logger::Logger logger_;
};

}  // namespace proof
