// C functions over AvrSequencer, so that Python can drive one board through ctypes.
// Errors come back as text: every function that can fail returns null or the message.
#include <array>
#include <cstring>
#include <exception>
#include <string>

#include "boards/avr_sequencer.h"

using tfsat::emulator::AvrSequencer;
using tfsat::emulator::PinEdge;
using tfsat::emulator::PinHold;
using tfsat::emulator::ResetCause;

namespace {
std::string last_error;
}

extern "C" {

AvrSequencer* board_open(const char* hex_path) {
  try {
    return new AvrSequencer(hex_path);
  } catch (const std::exception& error) {
    last_error = error.what();
    return nullptr;
  }
}
const char* board_error() { return last_error.c_str(); }
void board_close(AvrSequencer* board) { delete board; }

void board_set_power(AvrSequencer* board, bool on) { board->set_power(on); }
void board_reset(AvrSequencer* board, uint8_t cause) {
  board->reset(static_cast<ResetCause>(cause));
}
const char* board_advance_to_cycle(AvrSequencer* board, uint64_t cycle) {
  try {
    board->advance_to_cycle(cycle);
    return nullptr;
  } catch (const std::exception& error) {
    last_error = error.what();
    return last_error.c_str();
  }
}
void board_set_switch(AvrSequencer* board, int index, bool closed) {
  board->set_switch(index, closed);
}
void board_hold_pin(AvrSequencer* board, int joint, uint8_t hold) {
  board->hold_pin(joint, static_cast<PinHold>(hold));
}
void board_set_cable(AvrSequencer* board, bool plugged) { board->set_cable(plugged); }
void board_set_port(AvrSequencer* board, bool open, uint32_t baud) { board->set_port(open, baud); }
void board_set_usb_stage_pause(AvrSequencer* board, uint32_t polls) {
  board->set_usb_stage_pause(polls);
}
void board_reset_usb_bus(AvrSequencer* board) { board->reset_usb_bus(); }
bool board_link_ready(AvrSequencer* board) { return board->link_ready(); }
size_t board_write(AvrSequencer* board, const uint8_t* data, size_t n) {
  return board->write(data, n);
}
size_t board_read(AvrSequencer* board, uint8_t* data, size_t n) { return board->read(data, n); }
bool board_take_edge(AvrSequencer* board, uint64_t* t_ns, uint8_t* pin, bool* high) {
  PinEdge edge;
  if (!board->take_edge(edge)) return false;
  *t_ns = edge.t_ns;
  *pin = edge.pin;
  *high = edge.high;
  return true;
}
void board_eeprom_get(AvrSequencer* board, uint8_t* image, size_t n) {
  board->eeprom_get(image, n);
}
void board_eeprom_set(AvrSequencer* board, const uint8_t* image, size_t n) {
  board->eeprom_set(image, n);
}
uint32_t board_eeprom_writes(AvrSequencer* board) { return board->eeprom_writes(); }
void board_set_serial(AvrSequencer* board, const uint8_t* serial) {
  std::array<uint8_t, 10> bytes;
  std::memcpy(bytes.data(), serial, bytes.size());
  board->set_serial_number(bytes);
}
void board_set_extended_fuse(AvrSequencer* board, uint8_t fuse) { board->set_extended_fuse(fuse); }
uint64_t board_cycles(AvrSequencer* board) { return board->cycles(); }
uint8_t board_peek(AvrSequencer* board, uint16_t address) { return board->peek(address); }
void board_copy(AvrSequencer* board, uint16_t from, uint8_t* out, size_t n) {
  for (size_t i = 0; i < n; ++i) out[i] = board->peek(static_cast<uint16_t>(from + i));
}
void board_poke(AvrSequencer* board, uint16_t address, uint8_t value) {
  board->poke(address, value);
}
void board_watch_blocking(AvrSequencer* board) { board->watch_blocking(); }
size_t board_blocked(AvrSequencer* board, uint16_t* address, uint64_t* cycles, size_t capacity) {
  size_t count = 0;
  for (const auto& path : board->blocked()) {
    if (count == capacity) break;
    address[count] = path.first;
    cycles[count++] = path.second;
  }
  return count;
}

}  // extern "C"
