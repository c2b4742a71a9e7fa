// One life of the logger: powered up, hung up, started over its cable, dropped, and cut off or
// closed.
#pragma once

#include "../../../firmware/teensy_logger/src/core/logger.h"
#include "cable.h"
#include "card.h"
#include "clock.h"
#include "robot.h"

namespace proof {

// The sampling timer: when its next tick comes.
class Timer final : public tfsat::logger::SampleTimer {
 public:
  Timer(const Clock& clock, const Scenario& scenario)
      : clock_(clock), scenario_(scenario), misses_(scenario.seed, 9) {}
  void start(uint16_t rate_hz) override {
    rate_hz_ = rate_hz;
    started_us_ = clock_.now_us();
    ticks_ = 0;
  }
  void stop() override { rate_hz_ = 0; }
  uint64_t next_us() const {
    if (rate_hz_ == 0) return kNever;
    const uint32_t late_us = drawn_at(scenario_.seed, static_cast<uint32_t>(ticks_), 80);
    return started_us_ + (ticks_ + 1) * 1000000u / rate_hz_ + late_us % (scenario_.jitter_us + 1);
  }
  void advance() {
    ++ticks_;
    if (scenario_.missed_one_in != 0 && misses_.one_in(scenario_.missed_one_in)) {
      ticks_ += misses_.between(1, 4);
    }
  }

 private:
  const Clock& clock_;
  const Scenario& scenario_;
  Draw misses_;
  uint64_t started_us_ = 0;
  uint64_t ticks_ = 0;
  uint16_t rate_hz_ = 0;
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
  World(const Scenario& scenario, Medium& medium, Ram& ram, tfsat::logger::Block* ring,
        Truth& truth);

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
  bool over();
  void tell_truth();

  const Scenario& scenario_;
  Truth& truth_;
  Medium& medium_;
  Draw loop_;
  uint64_t now_us_ = 0;
  uint64_t cut_us_;
  uint64_t closed_us_ = 0;  // since when nothing is open; 0: something is
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
