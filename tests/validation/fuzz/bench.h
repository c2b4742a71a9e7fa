// The sequencer on a bench: wired as the emulator's native board is, with a witness at each joint, and with the
// factory's maneuver uploaded. Whatever is done to it, what the bench requires must hold.
#pragma once

#include <array>
#include <cstring>
#include <memory>
#include <utility>

#include "witness.h"

namespace tfsat_fuzz {

using namespace tfsat::protocol;
using tfsat::emulator::NativeEeprom;
using tfsat::sequencer::Maneuver;
using tfsat::sequencer::tick_t;

// A full link of requests is served by then, 64 bytes a turn.
constexpr int kBacklogLoops = 200;
constexpr uint32_t kLoopUs = 50;

// An EEPROM into which the factory's maneuver has been uploaded: without one, no script would ever arm.
inline const std::array<uint8_t, NativeEeprom::kBytes>& uploaded_image() {
  static const auto image = [] {
    NativeEeprom eeprom;
    tfsat::sequencer::Stored<Maneuver> store(eeprom, Sequencer::kManeuverAddress);
    const Maneuver maneuver = Maneuver::factory();
    std::memcpy(store.staged(), &maneuver, Maneuver::kSize);
    store.commit();
    for (uint64_t now_us = 0; store.writing(); now_us += kLoopUs) {
      eeprom.set_now(now_us);
      store.poll();
    }
    REQUIRE(!store.failed());
    return eeprom.image();
  }();
  return image;
}

class Bench {
 public:
  Bench() {
    eeprom_.image() = uploaded_image();
    retained_.clear();
    start(ResetCause::kPowerOn);
  }

  // One turn of the main loop, `later_us` after the last.
  void loop(uint32_t later_us) {
    now_us_ += later_us;
    Board& board = *board_;
    eeprom_.set_now(now_us_);
    board.servos.advance_to((now_us_ - started_us_) * 1000, 0, edges_);
    SequencerState before = board.core.state();
    const bool pulses_begun = board.pulses.take(edges_);
    REQUIRE(!pulses_begun || before != SequencerState::kSafe || armed_before_reset_);

    const uint32_t writes = eeprom_.writes();
    board.core.poll(ticks());
    require_transition(before);
    board.server.update(ticks(), board.link.rejected_frames());
    before = board.core.state();
    if (!board.stream.connected()) board.core.host_gone();
    REQUIRE(board.core.state() == (before == SequencerState::kJogging && !plugged_ ? SequencerState::kSafe : before));
    board.link.poll();
    if (board.request_witness.take_disarmed()) armed_before_reset_ = false;
    if (before == SequencerState::kArmed || before == SequencerState::kRunning) REQUIRE(eeprom_.writes() == writes);
    require_valid();
    if (host_reads_) host_reads();
  }
  void set_switch(int index, bool open) {
    if (open_[index] != open) switched_us_ = now_us_;
    open_[index] = open;
    opened_since_start_ = opened_since_start_ || open;
    board_->switches.set(index, open, ticks());
  }
  void set_cable(bool plugged) {
    if (!plugged) {
      reply_.clear();
      reply_torn_ = true;
    }
    plugged_ = plugged;
    board_->stream.set_plugged(plugged);
  }
  // While the host does not read, replies pile up until the link is full.
  void set_host_reads(bool reads) { host_reads_ = reads; }
  void write(const Bytes& data) { board_->stream.host_write(data.data(), data.size()); }
  void send(uint8_t type, const uint8_t* payload, size_t size) {
    Bytes frame(encoded_frame_bytes(size));
    frame.resize(encode_frame(type, static_cast<uint8_t>(type + size), payload, size, frame.data()));
    write(frame);
  }
  void reset(ResetCause cause) { restart(cause); }
  void cut_power() {
    eeprom_.power_cut();
    retained_.crc = static_cast<uint16_t>(~retained_.crc);  // RAM is gone
    restart(ResetCause::kPowerOn);
  }

  uint16_t arm_token() const { return board_->core.arm_token(); }
  // Whatever came before, a DISARM that is sent through a plugged cable is obeyed and answered.
  void require_disarm() {
    set_cable(true);
    set_host_reads(true);
    int loops = 0;
    do loop(kLoopUs);
    while (!board_->stream_witness.drained() && ++loops < kBacklogLoops);
    REQUIRE(board_->stream_witness.drained());
    last_reply_ = {};
    write(Bytes{0});
    send(DisarmRequest::kType, nullptr, 0);
    for (int i = 0; i < 3; ++i) loop(kLoopUs);
    REQUIRE(board_->core.state() == SequencerState::kSafe);
    REQUIRE(last_reply_.type == DisarmReply::kType && last_reply_.sequence == DisarmRequest::kType);
    REQUIRE(last_reply_.payload == Bytes{static_cast<uint8_t>(SequencerState::kSafe)});
  }

 private:
  // Everything that dies with a reset.
  struct Board {
    Board(tfsat::emulator::NativeEeprom& eeprom, tfsat::sequencer::RetainedState& retained, ResetCause cause)
        : servos(retained.begun), identity{{}, 0, cause, 0}, memory(eeprom), core(switches, servos, memory, retained) {}

    tfsat::emulator::NativeSwitches switches;
    tfsat::emulator::NativeServos servos;
    tfsat::emulator::NativeHealth health;
    NativeStream stream;
    tfsat::sequencer::Identity identity;
    MemoryWitness memory;
    Sequencer core;
    RequestServer server{core, identity, health};
    StreamWitness stream_witness{stream};
    RequestWitness request_witness{stream_witness, core, server};
    tfsat::protocol::Link link{stream_witness, request_witness};
    PulseWitness pulses;
  };

  // What the board says that it has stored.
  struct Contents {
    Bytes maneuver;
    Bytes settings;
    uint32_t maneuver_generation;
    uint32_t settings_generation;
  };

  void start(ResetCause cause) {
    // A reset leaves a write going; the EEPROM's driver waits for its end before anything else.
    for (; eeprom_.busy(); now_us_ += kLoopUs) eeprom_.set_now(now_us_);
    started_us_ = now_us_;
    board_ = std::make_unique<Board>(eeprom_, retained_, cause);
    board_->stream.set_plugged(plugged_);
    for (int i = 0; i < 2; ++i) board_->switches.set(i, open_[i], 0);
    eeprom_.set_now(now_us_);
    board_->core.start(0, cause);
    opened_since_start_ = open_[0] || open_[1];
    reply_.clear();
    require_valid();
  }
  // A stored record outlives it whole; one that was being stored is there or is not.
  void restart(ResetCause cause) {
    const SequencerState before = board_->core.state();
    const bool maneuver_settled = !board_->core.maneuvers().writing();
    const bool settings_settled = !board_->core.settings().writing();
    const bool begun = maneuver_settled && board_->core.maneuvers().defect() == ErrorCode::kUploadInterrupted;
    const Contents old = contents();
    start(cause);
    reply_torn_ = false;
    if (cause == ResetCause::kPowerOn) {
      armed_before_reset_ = false;
    } else if (before != SequencerState::kSafe) {
      armed_before_reset_ = before == SequencerState::kArmed;
    }
    require_start(cause, before);
    REQUIRE(!begun || board_->core.maneuvers().defect() == ErrorCode::kUploadInterrupted);
    const Contents now = contents();
    REQUIRE(now.maneuver_generation - old.maneuver_generation <= (maneuver_settled ? 0 : 1));
    REQUIRE(now.settings_generation - old.settings_generation <= (settings_settled ? 0 : 1));
    REQUIRE(now.maneuver_generation != old.maneuver_generation || now.maneuver == old.maneuver);
    REQUIRE(now.settings_generation != old.settings_generation || now.settings == old.settings);
  }
  void require_start(ResetCause cause, SequencerState before) const {
    const bool holds = before == SequencerState::kRunning || before == SequencerState::kFault;
    const bool faulty = cause != ResetCause::kPowerOn && holds;
    REQUIRE(board_->core.state() == (faulty ? SequencerState::kFault : SequencerState::kSafe));
  }
  // What the board may do by itself.
  void require_transition(SequencerState before) {
    const SequencerState after = board_->core.state();
    if (after == before) return;
    const bool stood = now_us_ - switched_us_ >= kReleaseDebounceUs;
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
        REQUIRE(after == SequencerState::kRunning && open_[0] && open_[1] && stood);
        break;
      case SequencerState::kRunning:
        if (after == SequencerState::kArmed || board_->core.fault() == ErrorCode::kClosedWhileRunning) {
          REQUIRE(!open_[0] && !open_[1] && now_us_ - switched_us_ >= kReleaseSeatedUs);
          REQUIRE(after != SequencerState::kArmed || board_->core.strokes_started() == 0);
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
    REQUIRE(board_->core.maneuvers().current().valid());
    REQUIRE(board_->core.settings().current().valid());
    // No cut or reset looks like damage.
    for (const ErrorCode defect : {board_->core.maneuvers().defect(), board_->core.settings().defect()}) {
      REQUIRE(defect == ErrorCode::kNone || defect == ErrorCode::kUploadInterrupted);
    }
  }
  Bytes ask(uint8_t type) {
    Bytes reply(kMaxPayloadBytes);
    const Reply result = board_->server.handle(type, nullptr, 0, reply.data());
    REQUIRE(result.error == ErrorCode::kNone);
    reply.resize(result.size);
    return reply;
  }
  Contents contents() {
    return Contents{ask(ManeuverInfoRequest::kType), ask(SettingsReadRequest::kType), board_->core.maneuvers().generation(),
                    board_->core.settings().generation()};
  }
  // Every reply is a whole frame, but for one that a pulled cable has torn.
  void host_reads() {
    uint8_t chunk[256];
    while (const size_t size = board_->stream.host_read(chunk, sizeof chunk)) {
      for (size_t i = 0; i < size; ++i) {
        if (chunk[i] != 0) {
          reply_.push_back(chunk[i]);
          continue;
        }
        const auto frame = reference_decode(reply_.data(), reply_.size(), kMaxPayloadBytes);
        reply_.clear();
        REQUIRE(frame.has_value() || reply_torn_);
        reply_torn_ = false;
        if (!frame) continue;
        REQUIRE((frame->type & kReplyBit) != 0);
        last_reply_ = *frame;
      }
    }
  }
  tick_t ticks() const { return static_cast<tick_t>((now_us_ - started_us_) * tfsat::sequencer::kTicksPerUs); }

  tfsat::emulator::NativeEeprom eeprom_;
  tfsat::sequencer::RetainedState retained_ = {};
  std::unique_ptr<Board> board_;
  uint64_t now_us_ = 0;
  uint64_t started_us_ = 0;
  uint64_t switched_us_ = 0;  // last change of a switch
  bool open_[2] = {false, false};
  bool opened_since_start_ = false;
  bool plugged_ = true;
  bool host_reads_ = true;
  bool armed_before_reset_ = false;  // and nothing has been decided since
  bool reply_torn_ = false;          // by a pulled cable
  std::deque<PinEdge> edges_;
  Bytes reply_;
  Frame last_reply_ = {};
};

}  // namespace tfsat_fuzz
