// The bench in the hands of a fuzzer: whatever is done to it, what is required here must hold.
#pragma once

#include <memory>
#include <utility>

#include "../../fixtures/sequencer/bench.h"

namespace tfsat_fuzz {

using namespace tfsat::protocol;
using tfsat::sequencer::kTicksPerUs;
using tfsat::sequencer::Sequencer;
using tfsat_test::Bench;
using tfsat_test::Bytes;
using tfsat_test::Frame;

// A full link of requests is served by then, 64 bytes a turn.
constexpr int kBacklogLoops = 200;
constexpr uint32_t kLoopUs = 50;

class JudgedBench {
 public:
  // One turn of the main loop, `later_us` after the last.
  void loop(uint32_t later_us) {
    bench_->pass(later_us * kTicksPerUs);
    SequencerState before = core().state();
    const bool pulses_begun = bench_->run_servos();
    REQUIRE(!pulses_begun || before != SequencerState::kSafe || armed_before_reset_);

    const uint32_t writes = bench_->eeprom.writes();
    core().poll(bench_->now());
    require_transition(before);
    before = core().state();
    bench_->serve_host();
    if (bench_->witness.take_disarmed()) armed_before_reset_ = false;
    if (!plugged_) {
      REQUIRE(core().state() == (before == SequencerState::kJogging ? SequencerState::kSafe : before));
    }
    if (before == SequencerState::kArmed || before == SequencerState::kRunning) {
      REQUIRE(bench_->eeprom.writes() == writes);
    }
    require_valid();
    take_replies();
  }
  void set_switch(int index, bool open) {
    if (is_open(index) != open) switched_at_ = bench_->now();
    opened_since_start_ = opened_since_start_ || open;
    bench_->switches.set(index, open, bench_->now());
  }
  void set_cable(bool plugged) {
    if (!plugged) {
      reply_.clear();
      reply_torn_ = true;
    }
    plugged_ = plugged;
    bench_->stream.set_plugged(plugged);
  }
  // While the host does not read, replies pile up until the link is full.
  void set_host_reads(bool reads) { bench_->host_reads = reads; }
  void write(const Bytes& bytes) { bench_->write(bytes); }
  void send(uint8_t type, const Bytes& payload) {
    bench_->send(type, payload, static_cast<uint8_t>(type + payload.size()));
  }
  // A stored record outlives it whole; one that was being stored is there or is not.
  void reset(ResetCause cause) {
    const SequencerState before = core().state();
    const bool maneuver_settled = !core().maneuvers().writing();
    const bool settings_settled = !core().settings().writing();
    const bool begun = maneuver_settled && core().maneuvers().defect() == ErrorCode::kUploadInterrupted;
    const Contents old = contents();
    restart(cause);
    if (cause == ResetCause::kPowerOn) {
      armed_before_reset_ = false;
    } else if (before != SequencerState::kSafe) {
      armed_before_reset_ = before == SequencerState::kArmed;
    }
    require_start(cause, before);
    REQUIRE(!begun || core().maneuvers().defect() == ErrorCode::kUploadInterrupted);
    const Contents now = contents();
    REQUIRE(now.maneuver_generation - old.maneuver_generation <= (maneuver_settled ? 0 : 1));
    REQUIRE(now.settings_generation - old.settings_generation <= (settings_settled ? 0 : 1));
    REQUIRE(now.maneuver_generation != old.maneuver_generation || now.maneuver == old.maneuver);
    REQUIRE(now.settings_generation != old.settings_generation || now.settings == old.settings);
  }
  void cut_power() {
    bench_->eeprom.power_cut();
    bench_->retained.crc = static_cast<uint16_t>(~bench_->retained.crc);  // RAM is gone
    reset(ResetCause::kPowerOn);
  }

  uint16_t arm_token() { return core().arm_token(); }
  // Whatever came before, a DISARM that is sent through a plugged cable is obeyed and answered.
  void require_disarm() {
    set_cable(true);
    set_host_reads(true);
    int loops = 0;
    do loop(kLoopUs);
    while (!bench_->stream.drained() && ++loops < kBacklogLoops);
    REQUIRE(bench_->stream.drained());
    last_reply_ = {};
    write(Bytes{0});
    send(DisarmRequest::kType, {});
    for (int i = 0; i < 3; ++i) loop(kLoopUs);
    REQUIRE(core().state() == SequencerState::kSafe);
    REQUIRE(last_reply_.type == DisarmReply::kType && last_reply_.sequence == DisarmRequest::kType);
    REQUIRE(last_reply_.payload == Bytes{static_cast<uint8_t>(SequencerState::kSafe)});
  }

 private:
  Sequencer& core() { return bench_->core; }
  bool is_open(int index) { return bench_->switches.is_open(index); }

  // What the board says that it has stored.
  struct Contents {
    Bytes maneuver;
    Bytes settings;
    uint32_t maneuver_generation;
    uint32_t settings_generation;
  };

  void restart(ResetCause cause) {
    const bool host_reads = bench_->host_reads;
    bench_ = std::make_unique<Bench>(*bench_, cause);
    bench_->host_reads = host_reads;
    bench_->stream.set_plugged(plugged_);
    opened_since_start_ = is_open(0) || is_open(1);
    reply_.clear();
    reply_torn_ = false;
    require_valid();
  }
  void require_start(ResetCause cause, SequencerState before) {
    const bool holds = before == SequencerState::kRunning || before == SequencerState::kFault;
    const bool faulty = cause != ResetCause::kPowerOn && holds;
    REQUIRE(core().state() == (faulty ? SequencerState::kFault : SequencerState::kSafe));
  }
  // What the board may do by itself.
  void require_transition(SequencerState before) {
    const SequencerState after = core().state();
    if (after == before) return;
    const bool both_open = is_open(0) && is_open(1);
    const uint32_t undisturbed_us = tfsat::sequencer::us_from_ticks(bench_->now() - switched_at_);
    switch (before) {
      case SequencerState::kSafe:
        REQUIRE(std::exchange(armed_before_reset_, false));
        if (after == SequencerState::kArmed) {
          REQUIRE(!opened_since_start_);
        } else {
          REQUIRE(after == SequencerState::kFault && opened_since_start_);
        }
        break;
      case SequencerState::kArmed:
        REQUIRE(after == SequencerState::kRunning && both_open && undisturbed_us >= kReleaseDebounceUs);
        break;
      case SequencerState::kRunning:
        if (after == SequencerState::kArmed || core().fault() == ErrorCode::kClosedWhileRunning) {
          REQUIRE(!is_open(0) && !is_open(1) && undisturbed_us >= kReleaseSeatedUs);
          REQUIRE(after != SequencerState::kArmed || core().strokes_started() == 0);
        } else {
          REQUIRE(after == SequencerState::kDone || after == SequencerState::kFault);
        }
        break;
      case SequencerState::kJogging:
        REQUIRE(after == SequencerState::kSafe);
        break;
      default:
        REQUIRE(after == before);  // DONE and FAULT wait for the host
    }
  }
  void require_valid() {
    REQUIRE(core().maneuvers().current().valid());
    REQUIRE(core().settings().current().valid());
    // No cut or reset looks like damage.
    for (const ErrorCode defect : {core().maneuvers().defect(), core().settings().defect()}) {
      REQUIRE(defect == ErrorCode::kNone || defect == ErrorCode::kUploadInterrupted);
    }
  }
  Bytes ask(uint8_t type) {
    Bytes reply(kMaxPayloadBytes);
    const Reply result = bench_->server.handle(type, nullptr, 0, reply.data());
    REQUIRE(result.error == ErrorCode::kNone);
    reply.resize(result.size);
    return reply;
  }
  Contents contents() {
    return Contents{ask(ManeuverInfoRequest::kType), ask(SettingsReadRequest::kType), core().maneuvers().generation(),
                    core().settings().generation()};
  }
  // Every reply is a whole frame, but for one that a pulled cable has torn.
  void take_replies() {
    for (const uint8_t byte : std::exchange(bench_->received, {})) {
      if (byte != 0) {
        reply_.push_back(byte);
        continue;
      }
      const auto frame = tfsat_test::reference_decode(reply_.data(), reply_.size(), kMaxPayloadBytes);
      reply_.clear();
      REQUIRE(frame.has_value() || reply_torn_);
      reply_torn_ = false;
      if (!frame) continue;
      REQUIRE((frame->type & kReplyBit) != 0);
      last_reply_ = *frame;
    }
  }

  std::unique_ptr<Bench> bench_ = std::make_unique<Bench>();
  tfsat::sequencer::tick_t switched_at_ = 0;  // last change of a switch
  bool opened_since_start_ = false;
  bool plugged_ = true;
  bool armed_before_reset_ = false;  // and nothing has been decided since
  bool reply_torn_ = false;          // by a pulled cable
  Bytes reply_;
  Frame last_reply_ = {};
};

}  // namespace tfsat_fuzz
