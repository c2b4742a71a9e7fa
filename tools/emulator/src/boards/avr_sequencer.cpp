#include "avr_sequencer.h"

#include <algorithm>
#include <stdexcept>

#include "avr_machine.h"

namespace tfsat {
namespace emulator {

namespace {

constexpr uint32_t kBaud = 115200;

}  // namespace

AvrSequencer::AvrSequencer(const std::string& hex_path) : machine_(new AvrMachine(hex_path)) {}
AvrSequencer::~AvrSequencer() = default;

void AvrSequencer::set_power(bool on) { machine_->power(on); }
void AvrSequencer::reset(ResetCause cause) { machine_->restart(cause); }
void AvrSequencer::advance_to(uint64_t t_us) { advance_to_cycle(t_us * kCyclesPerUs); }
void AvrSequencer::advance_to_cycle(uint64_t cycle) { machine_->run_until(cycle); }

void AvrSequencer::set_switch(int index, bool closed) {
  if (index < 0 || index > 1) throw std::out_of_range("a release switch is 0 (D4) or 1 (D13)");
  machine_->pins.set_switch(index, closed, machine_->now);
}

void AvrSequencer::hold_pin(int joint, PinHold hold) {
  if (joint < 0 || joint > 2) throw std::out_of_range("a servo pin is 0 (D9) to 2 (D11)");
  machine_->pins.hold(joint, hold, machine_->now);
}

void AvrSequencer::set_cable(bool plugged) { machine_->usb.set_cable(plugged); }
void AvrSequencer::set_port(bool open) { set_port(open, kBaud); }
void AvrSequencer::set_port(bool open, uint32_t baud) { machine_->usb.set_port(open, baud); }
void AvrSequencer::set_usb_stage_pause(uint32_t polls) { machine_->usb.set_stage_pause(polls); }
void AvrSequencer::set_usb_half_transfers(uint32_t polls) { machine_->usb.set_half_transfers(polls); }
void AvrSequencer::reset_usb_bus() { machine_->usb.reset_bus(); }
bool AvrSequencer::link_ready() const { return machine_->usb.configured(); }

size_t AvrSequencer::write(const uint8_t* data, size_t n) { return machine_->usb.write(data, n); }
size_t AvrSequencer::read(uint8_t* data, size_t capacity) {
  return machine_->usb.read(data, capacity);
}
bool AvrSequencer::take_edge(PinEdge& edge) { return machine_->pins.take_edge(edge); }

void AvrSequencer::eeprom_get(uint8_t* image, size_t n) {
  std::copy_n(machine_->eeprom.cells().begin(), std::min(n, AvrEeprom::kSize), image);
}

void AvrSequencer::eeprom_set(const uint8_t* image, size_t n) {
  std::copy_n(image, std::min(n, AvrEeprom::kSize), machine_->eeprom.cells().begin());
}

uint32_t AvrSequencer::eeprom_writes() const { return machine_->eeprom.writes_begun(); }
void AvrSequencer::set_serial_number(const std::array<uint8_t, 10>& serial) {
  machine_->serial = serial;
}

void AvrSequencer::set_extended_fuse(uint8_t fuse) { machine_->fuses[2] = fuse; }

uint8_t AvrSequencer::peek(uint16_t address) const {
  if (address > machine_->avr->ramend) throw std::out_of_range("no such byte of RAM");
  return machine_->avr->data[address];
}

void AvrSequencer::poke(uint16_t address, uint8_t value) {
  if (address > machine_->avr->ramend) throw std::out_of_range("no such byte of RAM");
  machine_->avr->data[address] = value;
}

uint64_t AvrSequencer::cycles() const { return machine_->avr->cycle; }
void AvrSequencer::watch_blocking() { machine_->watch_blocking(); }
std::map<uint16_t, uint64_t> AvrSequencer::blocked() const { return machine_->blocked; }

}  // namespace emulator
}  // namespace tfsat
