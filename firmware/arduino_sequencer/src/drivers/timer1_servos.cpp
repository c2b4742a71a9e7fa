#include "timer1_servos.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "tick_clock.h"

namespace tfsat {
namespace sequencer {

namespace {

Timer1Servos* instance;

constexpr uint8_t kServoPins = _BV(PB5) | _BV(PB6) | _BV(PB7);
constexpr uint8_t kStrokePin = _BV(PD6);
constexpr uint16_t kStrokeMarkTicks = 1 * kTicksPerMs;

// Compare output modes (datasheet table 14-2).
constexpr uint8_t kClear = 2, kSet = 3;

volatile uint16_t& compare_register(uint8_t channel) { return (&OCR1A)[channel]; }

constexpr uint8_t servo_pin(uint8_t channel) { return static_cast<uint8_t>(_BV(PB5) << channel); }

// Bits of PORTB. A pulse is whole so far if the pin was low when it rose and followed it since;
// between pulses: if the pin is low. Touched with interrupts off only.
uint8_t driven_high, whole;

template <typename Bits>
void set_bits(Bits& bits, uint8_t pins, bool to) {
  bits = static_cast<uint8_t>(to ? bits | pins : bits & ~pins);
}

constexpr uint8_t interrupt_bit(uint8_t channel) {
  return static_cast<uint8_t>(_BV(OCIE1A) << channel);
}

void set_output_mode(uint8_t channel, uint8_t mode) {
  const uint8_t shift = static_cast<uint8_t>(COM1A0 - 2 * channel);
  TCCR1A = static_cast<uint8_t>((TCCR1A & ~(3 << shift)) | (mode << shift));
}

// Applies the output mode at once, as a match would, but raises no flag.
void force_output(uint8_t channel) { TCCR1C = static_cast<uint8_t>(_BV(FOC1A) >> channel); }

}  // namespace

ISR(TIMER1_COMPA_vect) { instance->on_edge(0); }
ISR(TIMER1_COMPB_vect) { instance->on_edge(1); }
ISR(TIMER1_COMPC_vect) { instance->on_edge(2); }
// A pin that may begin a change has moved. Where a compare match explains it, the interrupt of that
// is still to come, and judges.
ISR(PCINT0_vect) {
  static_assert(PB5 - OCF1A == 4 && PB6 - OCF1B == 4 && PB7 - OCF1C == 4, "one shift for all");
  const uint8_t matched = static_cast<uint8_t>(TIFR1 << 4);
  const uint8_t astray = PINB ^ driven_high;
  whole = static_cast<uint8_t>((whole & matched) | ((whole | ~driven_high) & ~(astray | matched)));
}
ISR(TIMER3_COMPA_vect) { instance->end_stroke_mark(); }

constexpr uint8_t Timer1Servos::kChannels;
constexpr int32_t Timer1Servos::kLeastLeadTicks;

void Timer1Servos::begin() {
  instance = this;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    for (uint8_t i = 0; i < kChannels; ++i) {
      set_output_mode(i, kClear);
      force_output(i);
    }
    PORTB &= static_cast<uint8_t>(~kServoPins);
    DDRB |= kServoPins;
    PORTD &= static_cast<uint8_t>(~kStrokePin);
    DDRD |= kStrokePin;
    PCICR = _BV(PCIE0);
  }
}

// The three trains start a third of a frame apart: their interrupts, and the servos' currents, do
// not come at once. The first rise leaves time for a pulse that stop() let run to its end.
void Timer1Servos::hold(uint8_t joint, uint16_t width_ticks, uint32_t frame_ticks) {
  const uint32_t offset = joint * (frame_ticks / kChannels);
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    Channel& channel = channels_[joint];
    forget_changes();
    channel.train.hold(TickClock::now() + PulseTrain::kShortestGapTicks + offset, width_ticks,
                       frame_ticks);
    if (channel.next == Edge::kNone) {
      prepare_next_edge(joint);
      TIMSK1 |= interrupt_bit(joint);
    }
  }
}

void Timer1Servos::schedule(uint8_t joint, tick_t at, uint16_t width_ticks) {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { changes_.add(joint, at, width_ticks); }
}

// A pulse's width is settled by the interrupt after its rise: until then it can be the old one.
bool Timer1Servos::cancel() {
  bool under_way = false;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    changes_.cancel();
    for (Channel& channel : channels_) {
      if (channel.next == Edge::kFall && channel.pulse.change != nullptr) under_way = true;
      channel.train.cancel(channel.next == Edge::kRise ? &channel.pulse : nullptr);
    }
  }
  return under_way;
}

void Timer1Servos::stop() {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    forget_changes();
    for (uint8_t i = 0; i < kChannels; ++i) {
      Channel& channel = channels_[i];
      channel.train.stop();
      if (channel.next != Edge::kRise) continue;
      // A rise that has happened, or is about to, is completed by the interrupts.
      const int32_t lead = static_cast<int32_t>(channel.pulse.rise - TickClock::now());
      if (lead < kLeastLeadTicks) continue;
      set_output_mode(i, kClear);
      TIMSK1 &= static_cast<uint8_t>(~interrupt_bit(i));
      channel.next = Edge::kNone;
    }
  }
}

uint16_t Timer1Servos::changes_begun() {
  uint16_t begun;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { begun = changes_.begun(); }
  return begun;
}

tick_t Timer1Servos::change_began_at(uint8_t index) {
  tick_t at;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { at = changes_.began_at(index); }
  return at;
}

// A pulse under way keeps its width, and begins nothing. Inlined it would cost 46 bytes more.
__attribute__((noinline)) void Timer1Servos::forget_changes() {
  changes_.clear();
  for (Channel& channel : channels_) channel.pulse.change = nullptr;
}

// After a rise comes the pulse's fall, after a fall the train's next rise. Goes on while an edge is
// too late to prepare and has been made at once.
void Timer1Servos::prepare_next_edge(uint8_t channel) {
  Channel& c = channels_[channel];
  const uint8_t pin = servo_pin(channel);
  bool prepared = false;
  while (!prepared) {
    if (c.next == Edge::kRise) {
      set_bits(driven_high, pin, true);
      if ((PINB & pin) == 0) set_bits(whole, pin, false);
      if (c.pulse.change != nullptr && (whole & pin) != 0) begin_stroke_mark();
      c.next = Edge::kFall;
      prepared = set_edge(channel, c.pulse.rise + c.pulse.width_ticks, false);
      continue;
    }
    if ((PINB & pin) == 0 && (whole & pin) != 0) c.train.was_whole(c.pulse);
    set_bits(driven_high, pin, false);
    if (c.train.running()) {
      c.pulse = c.train.next();
      set_bits(PCMSK0, pin, c.pulse.change != nullptr);
      // Only now: a pin that is freed before it is watched raises no interrupt.
      set_bits(whole, pin, (PINB & pin) == 0);
      c.next = Edge::kRise;
      prepared = set_edge(channel, c.pulse.rise, true);
      if (!prepared)
        c.pulse.rise = TickClock::now();  // the width counts from the rise that was made
    } else {
      c.next = Edge::kNone;
      TIMSK1 &= static_cast<uint8_t>(~interrupt_bit(channel));
      return;
    }
  }
}

// A match acts at the end of the count it is found in (datasheet figure 14-11), hence the 1. The
// compare register comes before the mode, so that no match of its old value is used. False when it
// was too late: the edge has then been made at once.
bool Timer1Servos::set_edge(uint8_t channel, tick_t at, bool high) {
  const uint8_t mode = high ? kSet : kClear;
  if (static_cast<int32_t>(at - TickClock::now()) < kLeastLeadTicks) {
    set_output_mode(channel, mode);
    force_output(channel);
    return false;
  }
  compare_register(channel) = static_cast<uint16_t>(at - 1);
  TIFR1 = interrupt_bit(channel);
  set_output_mode(channel, mode);
  return true;
}

void Timer1Servos::begin_stroke_mark() {
  PORTD |= kStrokePin;
  OCR3A = static_cast<uint16_t>(TCNT3 + kStrokeMarkTicks);
  TIFR3 = _BV(OCF3A);
  TIMSK3 |= _BV(OCIE3A);
}

void Timer1Servos::end_stroke_mark() {
  PORTD &= static_cast<uint8_t>(~kStrokePin);
  TIMSK3 &= static_cast<uint8_t>(~_BV(OCIE3A));
}

}  // namespace sequencer
}  // namespace tfsat
