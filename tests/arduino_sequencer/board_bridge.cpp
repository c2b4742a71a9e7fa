// The sequencer's core on the PC, for Python: the native board of the emulator without the robot
// around it, so that its pins can be read to the nanosecond and hours pass in a moment.
#include <algorithm>

#include "boards/native_sequencer.h"

using tfsat::emulator::NativeSequencer;
using tfsat::emulator::PinEdge;
using tfsat::emulator::PinHold;
using tfsat::emulator::ResetCause;

namespace {

struct Board {
  NativeSequencer sequencer;
  uint64_t now_us = 0;

  void advance_to(uint64_t t_us) {
    now_us = std::max(now_us, t_us);
    sequencer.advance_to(now_us);
  }
};

}  // namespace

extern "C" {

Board* board_new() { return new Board; }
void board_free(Board* board) { delete board; }
uint64_t board_now_us(const Board* board) { return board->now_us; }
void board_set_power(Board* board, int on) { board->sequencer.set_power(on != 0); }
void board_reset(Board* board, int cause) {
  board->sequencer.reset(static_cast<ResetCause>(cause));
}
void board_advance_to(Board* board, uint64_t t_us) { board->advance_to(t_us); }
void board_set_switch(Board* board, int index, int closed) {
  board->sequencer.set_switch(index, closed != 0);
}
void board_hold_pin(Board* board, int joint, int hold) {
  board->sequencer.hold_pin(joint, static_cast<PinHold>(hold));
}
void board_set_cable(Board* board, int plugged) { board->sequencer.set_cable(plugged != 0); }
size_t board_write(Board* board, const uint8_t* data, size_t size) {
  return board->sequencer.write(data, size);
}

// Bytes for the host, at least one if one comes before `until_us`.
size_t board_read(Board* board, uint8_t* data, size_t capacity, uint64_t until_us) {
  while (true) {
    const size_t size = board->sequencer.read(data, capacity);
    if (size > 0 || board->now_us >= until_us) return size;
    board->advance_to(std::min(until_us, board->now_us + 50));
  }
}

// Takes up to `capacity` edges of the output pins.
size_t board_edges(Board* board, uint64_t* t_ns, uint8_t* pin, uint8_t* high, size_t capacity) {
  size_t count = 0;
  PinEdge edge;
  while (count < capacity && board->sequencer.take_edge(edge)) {
    t_ns[count] = edge.t_ns;
    pin[count] = edge.pin;
    high[count++] = edge.high ? 1 : 0;
  }
  return count;
}

void board_eeprom_get(Board* board, uint8_t* image, size_t size) {
  board->sequencer.eeprom_get(image, size);
}
void board_eeprom_set(Board* board, const uint8_t* image, size_t size) {
  board->sequencer.eeprom_set(image, size);
}

}  // extern "C"
