// The sequencer on a bench: wired as the emulator's native board is, with a witness at each joint, and with the
// factory's maneuver uploaded. Whatever is done to it, what the bench requires must hold.
#pragma once

#include <memory>
#include <utility>

#include "witness.h"

namespace tfsat_fuzz {

using tfsat::protocol::ResetCause;
using tfsat::sequencer::tick_t;

class Bench {
 public:
  Bench();

  // One turn of the main loop, `later_us` after the last.
  void loop(uint32_t later_us);
  void set_switch(int index, bool open);
  void set_cable(bool plugged);
  // While the host does not read, replies pile up until the link is full.
  void set_host_reads(bool reads) { host_reads_ = reads; }
  void write(const Bytes& data) { board_->stream.host_write(data.data(), data.size()); }
  void send(uint8_t type, const uint8_t* payload, size_t size);
  void reset(ResetCause cause);
  void cut_power();

  uint16_t arm_token() const { return board_->core.arm_token(); }
  // Whatever came before, a DISARM that is sent through a plugged cable is obeyed and answered.
  void require_disarm();

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

  void start(ResetCause cause);
  void restart(ResetCause cause);
  void require_start(ResetCause cause, SequencerState before) const;
  void require_transition(SequencerState before);
  void require_valid();
  Bytes ask(uint8_t type);
  Contents contents();
  void host_reads();
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
