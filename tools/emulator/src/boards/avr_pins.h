// The pins of the Arduino Micro that the sequencer uses: four outputs, whose edges are logged with
// the cycle they happen at, and two release switches with pull-ups. A servo pin may be held; the
// edges are those of the pin, whatever the chip drives.
#pragma once

#include <array>
#include <cstdint>
#include <deque>

#include "avr_io.h"
#include "avr_timer16.h"
#include "sequencer_board.h"

namespace tfsat {
namespace emulator {

class AvrPins : public CompareOutputListener {
 public:
  explicit AvrPins(avr_t* avr);
  AvrPins(const AvrPins&) = delete;
  AvrPins& operator=(const AvrPins&) = delete;

  // Timer 1 drives D9 D10 D11 and captures D4; Timer 3 captures D13.
  void connect(Timer16* timer1, Timer16* timer3);

  void set_switch(int index, bool closed, uint64_t cycle);
  void hold(int servo, PinHold hold, uint64_t cycle);
  void restore();                        // after a reset: simavr forgets input levels
  void release_outputs(uint64_t cycle);  // reset or power off: every pin floats

  bool take_edge(PinEdge& edge);
  void compare_output_changed(uint64_t cycle) override { update_outputs(cycle); }

 private:
  static constexpr int kOutputs = 4;
  static constexpr int kSwitches = 2;

  void update_outputs(uint64_t cycle);
  void set_output(int pin, bool driven_high, uint64_t cycle);
  void update_switch(int index, uint64_t cycle);
  static void on_port_write(void* self, uint8_t);
  static uint8_t on_pinb_read(avr_t* avr, avr_io_addr_t address, void* self);

  avr_t* avr_;
  Timer16* timer1_ = nullptr;
  std::array<Timer16*, kSwitches> capture_{};
  std::array<avr_irq_t*, kSwitches> input_irq_{};
  std::array<bool, kSwitches> closed_{};
  std::array<PinHold, kOutputs> hold_{};
  std::array<bool, kOutputs> driven_high_{};
  std::array<bool, kOutputs> high_{};
  avr_int_vector_t* pin_change_ = nullptr;
  std::array<WriteTap, 8> taps_;
  avr_io_read_t simavr_pinb_read_ = nullptr;
  void* simavr_pinb_param_ = nullptr;
  std::deque<PinEdge> edges_;
};

}  // namespace emulator
}  // namespace tfsat
