#include "avr_pins.h"

#include <simavr/avr_ioport.h>

namespace tfsat {
namespace emulator {

namespace {

struct Pin {
  char port;
  avr_io_addr_t pin_register;  // DDRx and PORTx follow it
  uint8_t bit;

  avr_io_addr_t ddr_register() const { return static_cast<avr_io_addr_t>(pin_register + 1); }
  avr_io_addr_t port_register() const { return static_cast<avr_io_addr_t>(pin_register + 2); }
};

// Arduino Micro: D9 = PB5, D10 = PB6, D11 = PB7, D12 = PD6; D4 = PD4, D13 = PC7.
constexpr Pin kOutputPins[] = {
    {'B', reg::kPinb, 5}, {'B', reg::kPinb, 6}, {'B', reg::kPinb, 7}, {'D', reg::kPind, 6}};
constexpr Pin kSwitchPins[] = {{'D', reg::kPind, 4}, {'C', reg::kPinc, 7}};

constexpr uint8_t kPinChangeVector = 9;  // PCINT0 (datasheet table 9-1)

// A write to PINx toggles PORTx, so it is watched too.
constexpr avr_io_addr_t kWatched[] = {reg::kPinb,  reg::kDdrb, reg::kPortb, reg::kDdrc,
                                      reg::kPortc, reg::kPind, reg::kDdrd,  reg::kPortd};

bool bit_of(const avr_t* avr, avr_io_addr_t address, uint8_t bit) {
  return (avr->data[address] >> bit & 1) != 0;
}

}  // namespace

constexpr int AvrPins::kOutputs;
constexpr int AvrPins::kSwitches;

AvrPins::AvrPins(avr_t* avr) : avr_(avr), pin_change_(find_vector(avr, kPinChangeVector)) {
  for (int i = 0; i < kSwitches; ++i) {
    input_irq_[i] =
        avr_io_getirq(avr_, AVR_IOCTL_IOPORT_GETIRQ(kSwitchPins[i].port), kSwitchPins[i].bit);
  }
}

void AvrPins::connect(Timer16* timer1, Timer16* timer3) {
  timer1_ = timer1;
  capture_ = {timer1, timer3};
  for (size_t i = 0; i < taps_.size(); ++i)
    taps_[i].attach(avr_, kWatched[i], &AvrPins::on_port_write, this);
  const auto& present = avr_->io[AVR_DATA_TO_IO(reg::kPinb)].r;
  simavr_pinb_read_ = present.c;
  simavr_pinb_param_ = present.param;
  replace_read(avr_, reg::kPinb, &AvrPins::on_pinb_read, this);
}

// PINx shows what is on the pin, also where a timer drives it; simavr shows PORTx there.
uint8_t AvrPins::on_pinb_read(avr_t* avr, avr_io_addr_t address, void* self) {
  const AvrPins& pins = *static_cast<AvrPins*>(self);
  if (pins.simavr_pinb_read_ != nullptr)
    pins.simavr_pinb_read_(avr, address, pins.simavr_pinb_param_);
  uint8_t& value = avr->data[address];
  for (int i = 0; i < Timer16::kChannels; ++i) {
    const uint8_t mask = static_cast<uint8_t>(1 << kOutputPins[i].bit);
    if (!bit_of(avr, kOutputPins[i].ddr_register(), kOutputPins[i].bit)) continue;
    value = static_cast<uint8_t>(pins.high_[i] ? value | mask : value & ~mask);
  }
  return value;
}

void AvrPins::on_port_write(void* self, uint8_t) {
  AvrPins& pins = *static_cast<AvrPins*>(self);
  pins.update_outputs(pins.avr_->cycle);
  for (int i = 0; i < kSwitches; ++i) pins.update_switch(i, pins.avr_->cycle);
}

void AvrPins::update_outputs(uint64_t cycle) {
  for (int i = 0; i < kOutputs; ++i) {
    const Pin& pin = kOutputPins[i];
    bool high = false;  // a floating servo line rests low
    if (bit_of(avr_, pin.ddr_register(), pin.bit)) {
      const bool compare = i < Timer16::kChannels && timer1_->drives(i);
      high = compare ? timer1_->output(i) : bit_of(avr_, pin.port_register(), pin.bit);
    }
    set_output(i, high, cycle);
  }
}

void AvrPins::set_output(int pin, bool driven_high, uint64_t cycle) {
  driven_high_[pin] = driven_high;
  const bool high = hold_[pin] == PinHold::kFree ? driven_high : hold_[pin] == PinHold::kHigh;
  if (high_[pin] == high) return;
  high_[pin] = high;
  edges_.push_back({cycle * 1000 / kCyclesPerUs, static_cast<uint8_t>(pin), high});
  const Pin& changed = kOutputPins[pin];
  if (changed.port == 'B' && bit_of(avr_, reg::kPcmsk0, changed.bit)) {
    avr_raise_interrupt(avr_, pin_change_);
  }
}

void AvrPins::hold(int servo, PinHold hold, uint64_t cycle) {
  hold_[servo] = hold;
  set_output(servo, driven_high_[servo], cycle);
}

void AvrPins::release_outputs(uint64_t cycle) {
  for (int i = 0; i < kOutputs; ++i) set_output(i, false, cycle);
}

void AvrPins::set_switch(int index, bool closed, uint64_t cycle) {
  closed_[index] = closed;
  update_switch(index, cycle);
}

void AvrPins::restore() {
  for (int i = 0; i < kSwitches; ++i) update_switch(i, avr_->cycle);
}

// An open switch reads high only with the pull-up on; without it the pin floats, taken as low here
// so that a forgotten pull-up shows.
void AvrPins::update_switch(int index, uint64_t cycle) {
  const Pin& pin = kSwitchPins[index];
  if (bit_of(avr_, pin.ddr_register(), pin.bit)) return;
  const bool high = !closed_[index] && bit_of(avr_, pin.port_register(), pin.bit);
  const uint8_t mask = static_cast<uint8_t>(1 << pin.bit);
  avr_ioport_external_t external;
  external.name = pin.port;
  external.mask = mask;
  external.value = high ? mask : 0;
  avr_ioctl(avr_, AVR_IOCTL_IOPORT_SET_EXTERNAL(pin.port), &external);
  avr_raise_irq(input_irq_[index], high ? 1 : 0);
  // simavr drops an irq of unchanged value, and PINx is zero after a reset.
  uint8_t& pins = avr_->data[pin.pin_register];
  pins = static_cast<uint8_t>(high ? pins | mask : pins & ~mask);
  capture_[index]->set_capture_pin(high, cycle);
}

bool AvrPins::take_edge(PinEdge& edge) {
  if (edges_.empty()) return false;
  edge = edges_.front();
  edges_.pop_front();
  return true;
}

}  // namespace emulator
}  // namespace tfsat
