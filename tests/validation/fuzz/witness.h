// Stands between the parts of a board, hands everything on, and requires that each did what it may.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <iterator>
#include <optional>
#include <utility>

#include "../../../firmware/arduino_sequencer/src/core/request_server.h"
#include "../../../tools/emulator/src/boards/native_ports.h"
#include "reference_frame.h"

namespace tfsat_fuzz {

using tfsat::emulator::NativeStream;
using tfsat::emulator::PinEdge;
using tfsat::protocol::Reply;
using tfsat::protocol::SequencerState;
using tfsat::sequencer::RequestServer;
using tfsat::sequencer::Sequencer;

// At the EEPROM: nobody touches it while it writes, or writes what stands there already.
class MemoryWitness : public tfsat::sequencer::NonVolatile {
 public:
  explicit MemoryWitness(tfsat::emulator::NativeEeprom& eeprom) : eeprom_(eeprom) {}

  uint8_t read(uint16_t address) override {
    REQUIRE(!eeprom_.busy() && address < tfsat::emulator::NativeEeprom::kBytes);
    return eeprom_.read(address);
  }
  bool busy() override { return eeprom_.busy(); }
  void write(uint16_t address, uint8_t value) override {
    REQUIRE(read(address) != value);
    eeprom_.write(address, value);
  }

 private:
  tfsat::emulator::NativeEeprom& eeprom_;
};

// Between stream and link: remembers what stands since the last zero that the link has read.
class StreamWitness : public tfsat::protocol::ByteStream {
 public:
  explicit StreamWitness(NativeStream& stream) : stream_(stream) {}

  bool connected() override {
    if (!stream_.connected()) coded_.clear();
    return stream_.connected();
  }
  int read() override {
    REQUIRE(stream_.connected());
    if (ended_) coded_.clear();
    const int byte = stream_.read();
    ended_ = byte == 0;
    drained_ = byte < 0;
    if (byte > 0) coded_.push_back(static_cast<uint8_t>(byte));
    return byte;
  }
  size_t write(const uint8_t* data, size_t size) override {
    REQUIRE(stream_.connected());
    REQUIRE(size > 0);
    return stream_.write(data, size);
  }

  // The link found nothing more to read.
  bool drained() const { return drained_; }
  // The frame that ends with the byte read last.
  std::optional<Frame> frame() const {
    if (!ended_) return std::nullopt;
    return reference_decode(coded_.data(), coded_.size(), tfsat::protocol::kMaxPayloadBytes);
  }

 private:
  NativeStream& stream_;
  Bytes coded_;
  bool ended_ = false;
  bool drained_ = false;
};

// Between link and server: only frames that came whole are served, and a request changes the state only as the
// protocol says.
class RequestWitness : public tfsat::protocol::RequestHandler {
 public:
  RequestWitness(const StreamWitness& stream, Sequencer& core, RequestServer& server)
      : stream_(stream), core_(core), server_(server) {}

  Reply handle(uint8_t type, const uint8_t* payload, size_t size, uint8_t* reply) override {
    const auto frame = stream_.frame();
    REQUIRE(frame.has_value());
    REQUIRE(frame->type == type && frame->payload == Bytes(payload, payload + size));

    const SequencerState before = core_.state();
    const uint16_t token = core_.arm_token();
    int16_t held_cdeg[tfsat::protocol::kJointCount];
    std::copy(std::begin(core_.held_cdeg()), std::end(core_.held_cdeg()), held_cdeg);
    const Reply result = server_.handle(type, payload, size, reply);
    REQUIRE(result.size <= tfsat::protocol::kMaxPayloadBytes);
    const bool served = result.error == tfsat::protocol::ErrorCode::kNone;
    const SequencerState after = core_.state();
    if (type == tfsat::protocol::DisarmRequest::kType && size == 0) {
      REQUIRE(served && after == SequencerState::kSafe);
      disarmed_ = true;
    } else if (after != before) {
      REQUIRE(served);
      REQUIRE(after == SequencerState::kArmed || after == SequencerState::kJogging);
      if (after == SequencerState::kArmed) require_arming(before, held_cdeg, token, type, payload, size);
      if (after == SequencerState::kJogging) require_jog(before, type, payload, size);
    } else if (type == tfsat::protocol::ArmRequest::kType && served) {
      REQUIRE(before == SequencerState::kArmed);  // a second copy
    }
    return result;
  }

  // There was a DISARM since the last call.
  bool take_disarmed() { return std::exchange(disarmed_, false); }

 private:
  using Angles = int16_t[tfsat::protocol::kJointCount];

  // No servo snaps back from where a run has left it.
  static void require_at_start_pose(const Angles& held_cdeg) {
    for (const int angle : held_cdeg) {
      REQUIRE(std::abs(angle) <= static_cast<int>(tfsat::protocol::kStartPoseToleranceCdeg));
    }
  }
  void require_arming(SequencerState before, const Angles& held_cdeg, uint16_t token, uint8_t type,
                      const uint8_t* payload, size_t size) {
    REQUIRE(before == SequencerState::kSafe || before == SequencerState::kDone);
    REQUIRE(type == tfsat::protocol::ArmRequest::kType && size == 2);
    REQUIRE((payload[0] | payload[1] << 8) == token);
    REQUIRE(core_.switches_open() == 0);
    REQUIRE(core_.maneuvers().origin() == tfsat::protocol::Origin::kUploaded);
    REQUIRE(core_.maneuvers().defect() == tfsat::protocol::ErrorCode::kNone);
    REQUIRE(core_.settings().defect() == tfsat::protocol::ErrorCode::kNone);
    if (before == SequencerState::kDone) require_at_start_pose(held_cdeg);
    REQUIRE(core_.maneuvers().current().valid() && !core_.maneuvers().writing() && !core_.settings().writing());
  }
  void require_jog(SequencerState before, uint8_t type, const uint8_t* payload, size_t size) {
    REQUIRE(before == SequencerState::kSafe);
    tfsat::protocol::JogRequest request;
    REQUIRE(type == tfsat::protocol::JogRequest::kType && request.decode(payload, size));
    REQUIRE(request.confirm == tfsat::protocol::kJogConfirm);
  }

  const StreamWitness& stream_;
  Sequencer& core_;
  RequestServer& server_;
  bool disarmed_ = false;
};

// At the pins: every servo pulse that a running board ends is one that a servo understands.
class PulseWitness {
 public:
  // Takes the edges; true if a pulse has begun among them.
  bool take(std::deque<PinEdge>& edges) {
    bool begun = false;
    for (; !edges.empty(); edges.pop_front()) {
      const PinEdge& edge = edges.front();
      if (edge.pin >= tfsat::protocol::kJointCount) continue;
      REQUIRE(edge.high != high_[edge.pin]);
      high_[edge.pin] = edge.high;
      if (edge.high) {
        begun = true;
        rise_ns_[edge.pin] = edge.t_ns;
      } else {
        const uint64_t width_ns = edge.t_ns - rise_ns_[edge.pin];
        REQUIRE(width_ns >= 1000 * tfsat::protocol::kServoPulseMinUs);
        REQUIRE(width_ns <= 1000 * tfsat::protocol::kServoPulseMaxUs);
      }
    }
    return begun;
  }

 private:
  uint64_t rise_ns_[tfsat::protocol::kJointCount] = {};
  bool high_[tfsat::protocol::kJointCount] = {};
};

}  // namespace tfsat_fuzz
