// The sequencer firmware's core on the PC: the same source as on the board, without an AVR.
#pragma once

#include <memory>

#include "../../../../firmware/arduino_sequencer/src/core/retained_state.h"
#include "native_ports.h"
#include "sequencer_board.h"

namespace tfsat {
namespace emulator {

// Without power until set_power(true).
class NativeSequencer : public SequencerBoard {
 public:
  NativeSequencer();
  ~NativeSequencer() override;

  void set_power(bool on) override;
  void reset(ResetCause cause) override;
  void advance_to(uint64_t t_us) override;
  void set_switch(int index, bool closed) override;
  void hold_pin(int joint, PinHold hold) override;
  void set_cable(bool plugged) override;
  void set_port(bool open) override;
  size_t write(const uint8_t* data, size_t n) override;
  size_t read(uint8_t* data, size_t capacity) override;
  bool take_edge(PinEdge& edge) override;
  void eeprom_get(uint8_t* image, size_t n) override;
  void eeprom_set(const uint8_t* image, size_t n) override;
  uint32_t eeprom_writes() const override { return eeprom_.writes(); }

 private:
  // Everything that dies with the power.
  struct Running;

  void start(protocol::ResetCause cause);
  void stop();

  NativeEeprom eeprom_;
  sequencer::RetainedState retained_;  // RAM that a reset leaves alone
  std::unique_ptr<Running> running_;
  std::deque<PinEdge> edges_;
  uint64_t now_us_ = 0;
  bool switch_open_[protocol::kSwitchCount] = {false, false};
  std::array<PinHold, protocol::kJointCount> holds_{};
  bool plugged_ = true;
  bool port_open_ = true;
};

}  // namespace emulator
}  // namespace tfsat
