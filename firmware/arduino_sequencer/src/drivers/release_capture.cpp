#include "release_capture.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>
#include <util/delay.h>

#include "tick_clock.h"

namespace tfsat {
namespace sequencer {

namespace {

ReleaseCapture* instance;

// Of the capture unit in one interrupt: some 50 us at the most, a tenth of the shortest pulse.
constexpr uint8_t kMostTurns = 8;

// Timer 1 and Timer 3 have the same bits in the same places.
constexpr uint8_t kRisingEdge = _BV(ICES1), kNoiseCanceler = _BV(ICNC1), kCaptureFlag = _BV(ICF1);

bool is_open(uint8_t index) { return index == 0 ? (PIND & _BV(PD4)) != 0 : (PINC & _BV(PC7)) != 0; }

// The edge that ends the present level is the one to wait for.
void wait_for(volatile uint8_t& control, volatile uint8_t& flags, bool rising) {
  if (rising) {
    control |= kRisingEdge;
  } else {
    control &= static_cast<uint8_t>(~kRisingEdge);
  }
  flags = kCaptureFlag;  // changing the edge may raise it (datasheet section 14.6.3)
}

}  // namespace

ISR(TIMER1_CAPT_vect) { instance->on_capture(0); }
ISR(TIMER3_CAPT_vect) { instance->on_capture(1); }

constexpr uint8_t ReleaseCapture::kQueueSize;

void ReleaseCapture::begin() {
  instance = this;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    DDRD &= static_cast<uint8_t>(~_BV(PD4));
    DDRC &= static_cast<uint8_t>(~_BV(PC7));
    PORTD |= _BV(PD4);
    PORTC |= _BV(PC7);
    TCCR1B |= kNoiseCanceler;
    TCCR3B |= kNoiseCanceler;
    wait_for(TCCR1B, TIFR1, !is_open(0));
    wait_for(TCCR3B, TIFR3, !is_open(1));
    TIMSK1 |= _BV(ICIE1);
    TIMSK3 |= _BV(ICIE3);
  }
}

// While the capture unit is turned round, the contact may have moved on already: such an edge is stamped
// with the present time, and the next one is waited for. Chatter of some microseconds is followed so
// for a while; what comes after that, aim() finds.
void ReleaseCapture::on_capture(uint8_t index) {
  volatile uint8_t& control = index == 0 ? TCCR1B : TCCR3B;
  volatile uint8_t& flags = index == 0 ? TIFR1 : TIFR3;
  bool open = (control & kRisingEdge) != 0;
  push(TickClock::extend(index == 0 ? ICR1 : ICR3), index, open);
  wait_for(control, flags, !open);
  for (uint8_t turn = 0; turn < kMostTurns && is_open(index) != open; ++turn) {
    open = !open;
    push(TickClock::now(), index, open);
    wait_for(control, flags, !open);
  }
}

// In order of time: edges of both switches that come during one interrupt are served by the order of
// their vectors, and in that order two switches that were open together might never have been.
//
// A full queue keeps its oldest edges: the first is the release. levels() makes up for the rest. Until
// then nothing more is captured: no noise may take the processor from the servos.
void ReleaseCapture::push(tick_t at, uint8_t index, bool open) {
  if (count_ == kQueueSize) {
    TIMSK1 &= static_cast<uint8_t>(~_BV(ICIE1));
    TIMSK3 &= static_cast<uint8_t>(~_BV(ICIE3));
    return;
  }
  uint8_t place = static_cast<uint8_t>(head_ + count_++);
  for (; place != head_ && tick_before(at, in_queue(place - 1).at); --place) {
    in_queue(place) = in_queue(place - 1);
  }
  SwitchEdge& edge = in_queue(place);
  edge.at = at;
  edge.index = index;
  edge.open = open;
}

// Not while an interrupt is due that may bring an earlier edge.
bool ReleaseCapture::take_edge(SwitchEdge& edge) {
  bool taken = false;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    const uint8_t due = static_cast<uint8_t>((TIFR1 & TIMSK1) | (TIFR3 & TIMSK3)) & kCaptureFlag;
    if (count_ > 0 && due == 0) {
      edge = in_queue(head_);
      head_ = static_cast<uint8_t>((head_ + 1) % kQueueSize);
      --count_;
      taken = true;
    }
  }
  return taken;
}

// A contact that moved back within the microseconds in which an interrupt turned the capture unit
// round leaves it waiting for the edge that has already been: turned again here, or the next edge,
// which may be the release, would go unstamped.
void ReleaseCapture::aim(uint8_t index) {
  volatile uint8_t& control = index == 0 ? TCCR1B : TCCR3B;
  volatile uint8_t& flags = index == 0 ? TIFR1 : TIFR3;
  volatile uint8_t& mask = index == 0 ? TIMSK1 : TIMSK3;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    const bool open = is_open(index);
    _delay_us(1);  // the noise canceler's four cycles and the synchronizer's: the flag is up to date
    const bool waits_for_opening = (control & kRisingEdge) != 0;
    const bool off = (mask & _BV(ICIE1)) == 0;
    if (off || (open == waits_for_opening && (flags & kCaptureFlag) == 0)) {
      if (!off) push(TickClock::now(), index, open);
      wait_for(control, flags, !open);
      mask |= _BV(ICIE1);
    }
  }
}

uint8_t ReleaseCapture::levels() {
  aim(0);
  aim(1);
  return static_cast<uint8_t>((is_open(0) ? 1 : 0) | (is_open(1) ? 2 : 0));
}

}  // namespace sequencer
}  // namespace tfsat
