#include "native_sequencer.h"

#include <algorithm>

#include "../../../../firmware/arduino_sequencer/src/core/request_server.h"

namespace tfsat {
namespace emulator {

using sequencer::Identity;
using sequencer::RequestServer;
using sequencer::Sequencer;
using sequencer::tick_t;

namespace {

// How often the main loop comes round. The AVR's takes 20 to 60 us.
constexpr uint64_t kLoopUs = 50;

protocol::ResetCause reported(ResetCause cause) {
  switch (cause) {
    case ResetCause::kWatchdog:
      return protocol::ResetCause::kWatchdog;
    case ResetCause::kBrownOut:
      return protocol::ResetCause::kBrownOut;
    case ResetCause::kExternal:
      break;
  }
  return protocol::ResetCause::kExternal;
}

}  // namespace

struct NativeSequencer::Running {
  Running(NativeEeprom& eeprom, sequencer::RetainedState& retained, uint64_t started_us,
          protocol::ResetCause cause, const std::array<PinHold, protocol::kJointCount>& holds)
      : origin_us(started_us), servos(retained.begun, holds), identity{{'n', 'a', 't', 'i', 'v', 'e', '-', '1'}, 0, cause, 0},
        core(switches, servos, eeprom, retained), server(core, identity, health), link(stream, server) {}

  uint64_t origin_us;
  NativeSwitches switches;
  NativeServos servos;
  NativeStream stream;
  Identity identity;
  NativeHealth health;
  Sequencer core;
  RequestServer server;
  protocol::Link link;

  tick_t ticks(uint64_t t_us) const {
    return static_cast<tick_t>((t_us - origin_us) * sequencer::kTicksPerUs);
  }
};

NativeSequencer::NativeSequencer() { retained_.clear(); }
NativeSequencer::~NativeSequencer() = default;

void NativeSequencer::start(protocol::ResetCause cause) {
  running_ = std::make_unique<Running>(eeprom_, retained_, now_us_, cause, holds_);
  running_->stream.set_plugged(plugged_);
  running_->stream.set_port(port_open_);
  for (int i = 0; i < static_cast<int>(protocol::kSwitchCount); ++i) {
    running_->switches.set(i, switch_open_[i], 0);
  }
  eeprom_.set_now(now_us_);
  eeprom_.complete_write();
  running_->core.start(0, cause);
}

void NativeSequencer::set_power(bool on) {
  if (on == (running_ != nullptr)) return;
  if (on) {
    start(protocol::ResetCause::kPowerOn);
  } else {
    eeprom_.power_cut();
    stop();
    retained_.crc = static_cast<uint16_t>(~retained_.crc);  // RAM is gone
  }
}

void NativeSequencer::reset(ResetCause cause) {
  if (!running_) return;
  stop();
  start(reported(cause));
}

void NativeSequencer::stop() {
  running_->servos.release_pins(running_->origin_us * 1000, edges_);
  running_.reset();
}

void NativeSequencer::advance_to(uint64_t t_us) {
  while (now_us_ < t_us) {
    now_us_ = std::min(t_us, now_us_ + kLoopUs);
    if (!running_) {
      now_us_ = t_us;
      return;
    }
    Running& board = *running_;
    eeprom_.set_now(now_us_);
    board.servos.advance_to((now_us_ - board.origin_us) * 1000, board.origin_us * 1000, edges_);
    const tick_t now = board.ticks(now_us_);
    board.core.poll(now);
    board.server.update(now, board.link.rejected_frames());
    if (!board.stream.connected()) board.core.host_gone();
    board.link.poll();
  }
}

void NativeSequencer::set_switch(int index, bool closed) {
  switch_open_[index] = !closed;
  if (running_) running_->switches.set(index, !closed, running_->ticks(now_us_));
}

// A board without power drives nothing: the level is the hold's.
void NativeSequencer::hold_pin(int joint, PinHold hold) {
  PinHold& held = holds_[static_cast<size_t>(joint)];
  if (running_) {
    running_->servos.hold_pin(joint, hold, running_->origin_us * 1000, edges_);
  } else if ((held == PinHold::kHigh) != (hold == PinHold::kHigh)) {
    edges_.push_back({now_us_ * 1000, static_cast<uint8_t>(joint), hold == PinHold::kHigh});
  }
  held = hold;
}

void NativeSequencer::set_cable(bool plugged) {
  plugged_ = plugged;
  if (running_) running_->stream.set_plugged(plugged);
}

void NativeSequencer::set_port(bool open) {
  port_open_ = open;
  if (running_) running_->stream.set_port(open);
}

size_t NativeSequencer::write(const uint8_t* data, size_t n) {
  return running_ ? running_->stream.host_write(data, n) : 0;
}

size_t NativeSequencer::read(uint8_t* data, size_t capacity) {
  return running_ ? running_->stream.host_read(data, capacity) : 0;
}

bool NativeSequencer::take_edge(PinEdge& edge) {
  if (edges_.empty()) return false;
  edge = edges_.front();
  edges_.pop_front();
  return true;
}

void NativeSequencer::eeprom_get(uint8_t* image, size_t n) {
  std::copy_n(eeprom_.image().begin(), std::min(n, eeprom_.image().size()), image);
}

void NativeSequencer::eeprom_set(const uint8_t* image, size_t n) {
  std::copy_n(image, std::min(n, eeprom_.image().size()), eeprom_.image().begin());
}

}  // namespace emulator
}  // namespace tfsat
