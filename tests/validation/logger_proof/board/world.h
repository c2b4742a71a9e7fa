// One life of the logger: powered up, hung up, started over its cable, dropped, and cut off or
// closed.
#pragma once

#include "../../../../firmware/teensy_logger/src/core/logger.h"
#include "cable.h"
#include "card.h"
#include "robot.h"

namespace proof {

using tfsat::logger::Ports;
using tfsat::protocol::LoggerState;

constexpr uint64_t kUnplugUs = 400000;
constexpr uint64_t kNextFileUs = 500000;
constexpr tfsat::logger::Identity kIdentity = {{1, 2, 3, 4, 5, 6, 7, 8}, 0x12345678};

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
  World(const Scenario& scenario, Medium& medium, Ram& ram, tfsat::logger::Block* ring, Truth& truth)
      : scenario_(scenario),
        truth_(truth),
        medium_(medium),
        loop_(scenario.seed, 7),
        cut_us_(scenario.cut_us),
        timer_(*this, scenario),
        card_(medium, scenario, *this, truth),
        cable_(ram),
        ids_(scenario.seed),
        logger_(Ports{bus_a_, bus_b_, angles_, script_, timer_, card_, card_, memory_, cable_, ids_},
                kIdentity, ring, scenario.ring_blocks) {}

  void live() {
    bus_a_.power_up(scenario_, 0);
    bus_b_.power_up(scenario_, 2);
    angles_.power_up(scenario_);
    script_.power_up(scenario_, truth_);
    logger_.begin();
    while (!dead_ && !over()) {
      talk();
      logger_.poll(now_us_);
      pass(loop_.between(100, 400));
    }
    if (!dead_ && !card_.closed()) card_.lose_supply();
    if (scenario_.kind == Kind::kSpoiled) truth_.head.spoiled_blocks = card_.spoil();
    card_.settle_truth();
    tell_truth();
  }

 private:
  uint64_t now_us() const override { return now_us_; }
  void pass(uint64_t us) override {
    const uint64_t end_us = now_us_ + us;
    while (!dead_ && next_event_us() <= end_us) {
      if (next_event_us() > now_us_) now_us_ = next_event_us();
      happen();
    }
    if (!dead_ && end_us > now_us_) now_us_ = end_us;
  }
  bool dead() const override { return dead_; }
  void closing() override {
    if (scenario_.cut_in_close_us != 0) cut_us_ = now_us_ + scenario_.cut_in_close_us;
  }

  uint64_t next_event_us() const {
    uint64_t next = cut_us_;
    if (pull_ < 2) {
      const uint64_t card = gone_ ? scenario_.back_us[pull_] : scenario_.pulled_us[pull_];
      if (card < next) next = card;
    }
    return timer_.next_us() < next ? timer_.next_us() : next;
  }
  void happen() {
    if (cut_us_ <= now_us_) {
      card_.lose_supply();
      dead_ = true;
    } else if (timer_.next_us() <= now_us_) {
      tick();
    } else if (gone_) {
      card_.put_back();
      gone_ = false;
      ++pull_;
    } else {
      card_.pull();
      gone_ = true;
      TroubleTruth& trouble = truth_.troubles.add();
      trouble.from_us = now_us_;
      const uint64_t back_us = scenario_.back_us[pull_];
      trouble.to_us = back_us < scenario_.life_us ? back_us : scenario_.life_us;
      trouble.pulled = 1;
    }
  }
  void tick() {
    timer_.advance();
    ++ticks_;
    const uint32_t captured = logger_.state() == LoggerState::kRecording ? card_.files() : 0;
    bus_a_.measure(now_us_, ticks_);
    bus_b_.measure(now_us_, ticks_);
    angles_.measure(now_us_, ticks_);
    script_.set_now(now_us_);
    logger_.sample(now_us_);
    TickTruth& truth = truth_.ticks.add();
    truth.t_us = now_us_;
    for (uint32_t i = 0; i < 4; ++i) {
      const Bus& bus = i < 2 ? bus_a_ : bus_b_;
      memcpy(truth.imu[i], bus.imu(i % 2).values(), sizeof truth.imu[i]);
    }
    memcpy(truth.angle, angles_.values(), sizeof truth.angle);
    truth.served = static_cast<uint8_t>(bus_a_.served() | bus_b_.served() << 2);
    truth.switches_open = script_.switches_open();
    truth.angles = angles_.converted();
    truth.captured = static_cast<uint8_t>(captured);
  }
  // What a host does before a drop: settings, start, cable off.
  void talk() {
    if (told_ == 0 && now_us_ >= kSettingsUs) {
      tfsat::protocol::LoggerSettingsWriteRequest request;
      request.settings = tfsat::logger::factory_settings();
      request.settings.rate_hz = scenario_.rate_hz;
      request.settings.after_landing_s = kAfterLandingS;
      request.settings.file_mib = scenario_.file_mib;
      cable_.send(request);
      told_ = 1;
    } else if (told_ == 1 && now_us_ >= kStartUs) {
      tfsat::protocol::RecordStartRequest request = {};
      request.number = 1;
      request.unix_us = scenario_.unix_us;
      truth_.head.unix_at_zero_us = scenario_.unix_us - now_us_;
      cable_.send(request);
      told_ = 2;
    } else if (told_ == 2 && now_us_ >= kUnplugUs) {
      cable_.pull();
      told_ = 3;
    }
  }
  // Another recording may follow one that was closed. From a logger that has failed, a host fetches
  // what its RAM holds.
  bool over() {
    const bool failed = told_ == 3 && logger_.state() == LoggerState::kFailed;
    if (!card_.closed()) {
      closed_us_ = 0;
    } else if (closed_us_ == 0) {
      closed_us_ = now_us_;
    }
    const bool closed = closed_us_ != 0 && now_us_ - closed_us_ >= kNextFileUs;
    return closed || now_us_ >= scenario_.life_us || (failed && cable_.fetch_ram(now_us_));
  }
  void tell_truth() {
    TruthHead& head = truth_.head;
    memcpy(head.magic, "TFSATRUN", sizeof head.magic);
    head.seed = scenario_.seed;
    head.kind = static_cast<uint8_t>(scenario_.kind);
    head.holds_older = scenario_.holds_older;
    head.state = static_cast<uint8_t>(logger_.state());
    head.rate_hz = scenario_.rate_hz;
    head.stall_one_in = static_cast<uint16_t>(scenario_.stall_one_in);
    head.ring_blocks = scenario_.ring_blocks;
    head.image_blocks = medium_.blocks;
    head.tick_count = truth_.ticks.count;
    head.write_count = truth_.writes.count;
    head.trouble_count = truth_.troubles.count;
    head.edge_count = truth_.edges.count;
    head.end_us = now_us_;
    head.release_us = scenario_.release_us;
    head.landing_us = scenario_.landing_us;
    for (uint32_t i = 0; i < 4; ++i) {
      const bool own = scenario_.fault[i] != ImuFault::kNone;
      const ImuFault mate = scenario_.fault[i ^ 1];
      const bool by_bus = mate == ImuFault::kHang || mate == ImuFault::kStuckBus;
      if (own || by_bus) head.faulty |= static_cast<uint8_t>(1u << i);
    }
    head.landing_felt = scenario_.landing_felt;
    head.pulled = pull_ > 0 || gone_;
    head.lost_for_good = gone_ && scenario_.back_us[pull_] == kNever;
    head.ram_blocks = cable_.ram_blocks();
    head.cache_blocks = scenario_.cache_blocks;
  }

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
