#include "release_capture.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "tick_clock.h"

namespace tfsat {
namespace sequencer {

namespace {

// Of switch 1 on port D, of switch 2 on port C.
constexpr uint8_t kFirstPin = _BV(PD4), kSecondPin = _BV(PC7);

// As a sample has them: bit 6 and 7 are switch 1 and 2 being open; the rest is the turn.
constexpr uint8_t kFirst = 0x40, kSecond = 0x80, kBoth = kFirst | kSecond, kLost = 0x20, kTurn = 0x1F;
constexpr uint32_t kStampTicks = static_cast<uint32_t>(kTurn) << 16 | 0xFFFF;

// Contacts that have not moved for this many samples, 10 cycles each, will not within the 15 us of fast
// chatter.
constexpr uint8_t kQuietSamples = 28;
// Following may take this much of the time from one levels() to the next. A servo's next edge may be
// 0.5 ms away, and is prepared after it, after the other servos' edges and what else holds interrupts
// off (docs/sequencer-proof.md).
constexpr uint16_t kFollowTicks = 250 * kTicksPerUs;
// No contact chatters on for longer than so many times 2048 ticks, 205 ms.
constexpr uint8_t kMostChatter = 200;
// As soon as the interrupt is over.
constexpr uint16_t kEndWaitTicks = 16 * kTicksPerUs;

// Timer 1 and Timer 3 have the same bits in the same places.
constexpr uint8_t kRisingEdge = _BV(ICES1), kNoiseCanceler = _BV(ICNC1), kCaptureFlag = _BV(ICF1);
constexpr uint8_t kClock = _BV(CS11);

// Both switches at one moment; with kLost, after a time without capture. The turn of the timers' count
// tells moments apart for 1.05 s, about when the watchdog bites: the main loop comes round in 20 ms.
struct Sample {
  uint16_t count;
  uint8_t levels_and_turn;
};

constexpr uint8_t kQueueSize = 64;
Sample queue[kQueueSize];
Sample* next_in = queue;
Sample* next_out = queue;
volatile uint8_t waiting;  // samples in the queue
uint8_t followed;          // levels of the newest
uint8_t told;              // levels after the edges that were taken
uint16_t left_ticks;       // of kFollowTicks
Sample* seen_in = queue;   // next_in, a round of the main loop before
uint8_t still_at;          // when the switches last did not move in a round, in 2048 ticks

inline __attribute__((always_inline)) void step(Sample*& place) {
  if (++place == queue + kQueueSize) place = queue;
}

inline __attribute__((always_inline)) void put(Sample*& place, uint16_t count, uint8_t levels_and_turn) {
  place->count = count;
  place->levels_and_turn = levels_and_turn;
  step(place);
}

inline __attribute__((always_inline)) uint8_t open_now() {
  uint8_t levels = PINC & kSecondPin;
  if ((PIND & kFirstPin) != 0) levels |= kFirst;
  return levels;
}
static_assert(kSecond == kSecondPin, "the second switch's level is its pin's bit");

// The edge that ends the present level is the one to wait for. Changing it may raise the flag
// (datasheet section 14.6.3).
inline __attribute__((always_inline)) void wait_for_change(uint8_t levels, uint8_t switches) {
  constexpr uint8_t falling = kNoiseCanceler | kClock, rising = falling | kRisingEdge;
  if ((switches & kFirst) != 0) {
    TCCR1B = (levels & kFirst) != 0 ? falling : rising;
    TIFR1 = kCaptureFlag;
  }
  if ((switches & kSecond) != 0) {
    TCCR3B = (levels & kSecond) != 0 ? falling : rising;
    TIFR3 = kCaptureFlag;
  }
}

// The switches whose edge a timer has stamped.
inline __attribute__((always_inline)) uint8_t stamped() {
  uint8_t switches = 0;
  if ((TIFR1 & kCaptureFlag) != 0) switches |= kFirst;
  if ((TIFR3 & kCaptureFlag) != 0) switches |= kSecond;
  return switches;
}

}  // namespace

// One interrupt for both switches. Timer 3's leaves a mark in GPIOR0, which changes no register, and goes
// on as Timer 1's; so does levels(), with another mark.
constexpr uint8_t kByTimer3 = 1, kByNone = 2;

ISR(TIMER3_CAPT_vect, ISR_NAKED) {
  asm volatile("sbi %0, 0\n\tjmp __vector_16" ::"I"(_SFR_IO_ADDR(GPIOR0)));
}

// Contacts that open chatter within microseconds, and both may at once. What the timers have stamped, an
// edge of each switch at the most, goes first, in order of time. Then both pins are read together, again
// and again, 0.6 us apart and some 4 us where one has moved, until neither has for longer than fast
// chatter pauses. Whatever moves, its timer is at once told to stamp the next edge.
//
// A full queue keeps its oldest samples, and where the time is used up there is no following on:
// nothing more is captured until levels(), and the first sample then says so. No noise may take the
// processor from the servos. Whatever has moved, the main loop must come round: its wait for a USB host,
// which Timer 3's second channel limits (usb_stream.cpp), ends now; GPIOR1 says whether it may.
ISR(TIMER1_CAPT_vect) {
  const uint8_t by = GPIOR0;
  GPIOR0 = 0;
  uint8_t captured = by == kByTimer3 ? kSecond : kFirst;
  uint8_t levels = followed;
  if (by == kByNone) {
    captured = 0;
    levels = open_now();
    wait_for_change(levels, kBoth);
  }
  uint8_t room = static_cast<uint8_t>(kQueueSize - waiting);
  Sample* to = next_in;
  const uint16_t begin = TCNT1;
  const uint16_t end = begin + left_ticks;
  uint8_t quiet = kQuietSamples;
  bool going_on = false;
  if (by == kByNone && room > 0) {
    put(to, begin, levels | kLost | (TickClock::turn_of(begin) & kTurn));
    --room;
  }

  while (room > 0) {
    captured |= stamped();
    uint8_t moved;
    uint16_t at;
    if (captured != 0) {
      const uint16_t first = ICR1, second = ICR3;
      moved = captured;
      if (moved == kBoth) moved = static_cast<int16_t>(second - first) < 0 ? kSecond : kFirst;
      captured ^= moved;
      levels ^= moved;
      wait_for_change(levels, moved);
      at = moved == kFirst ? first : second;
      const uint16_t present = TCNT1;  // no stamp is later
      uint8_t turn = TickClock::turn_of(present);
      if (at > present) --turn;
      put(to, at, levels | (turn & kTurn));
    } else {
      uint8_t seen;
      do {
        seen = open_now();
      } while (seen == levels && --quiet != 0);
      at = TCNT1;
      if (stamped() != 0) continue;  // what comes later than `at` is stamped later
      going_on = seen == levels;
      if (going_on) break;
      moved = seen ^ levels;
      levels = seen;
      wait_for_change(levels, moved);
      put(to, at, levels | (TickClock::turn_of(at) & kTurn));
    }
    --room;
    if (static_cast<int16_t>(at - end) >= 0) break;
    quiet = kQuietSamples;
  }
  const uint16_t present = TCNT1;
  const int16_t left = static_cast<int16_t>(end - present);
  left_ticks = left > 0 ? left : 0;
  if (GPIOR1 != 0) OCR3B = present + kEndWaitTicks;
  followed = levels;
  next_in = to;
  waiting = static_cast<uint8_t>(kQueueSize - room);
  // Of a line that rattles on, each edge may take half the time to the next: one edge alone uses up none of
  // the time in which it is followed.
  if (going_on && (left_ticks != 0 || GPIOR1 != 0)) {
    TIMSK1 |= _BV(ICIE1);
    TIMSK3 |= _BV(ICIE3);
  } else {
    TIMSK1 &= static_cast<uint8_t>(~_BV(ICIE1));
    TIMSK3 &= static_cast<uint8_t>(~_BV(ICIE3));
  }
}

void ReleaseCapture::begin() {
  DDRD &= static_cast<uint8_t>(~kFirstPin);
  DDRC &= static_cast<uint8_t>(~kSecondPin);
  PORTD |= kFirstPin;
  PORTC |= kSecondPin;
  levels();
}

// Where both moved between two samples, the one that opened is told first: they met, or all but.
bool ReleaseCapture::take_edge(SwitchEdge& edge) {
  while (waiting > 0) {
    const Sample sample = *next_out;
    const uint8_t moved = static_cast<uint8_t>((sample.levels_and_turn ^ told) & kBoth);
    edge.lost = (sample.levels_and_turn & kLost) != 0;
    uint8_t one = moved;
    if (one == kBoth) one = (sample.levels_and_turn & kFirst) != 0 ? kFirst : kSecond;
    told ^= one;
    if (moved == one) {
      step(next_out);
      ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { waiting = static_cast<uint8_t>(waiting - 1); }
    } else {
      next_out->levels_and_turn &= static_cast<uint8_t>(~kLost);
    }
    if (one == 0) {
      if (!edge.lost) continue;
      one = kFirst;
    }
    const tick_t now = TickClock::now();
    const uint32_t stamp =
        static_cast<uint32_t>(sample.levels_and_turn & kTurn) << 16 | sample.count;
    edge.at = now - ((now - stamp) & kStampTicks);
    edge.index = one == kFirst ? 0 : 1;
    edge.open = (sample.levels_and_turn & one) != 0;
    return true;
  }
  return false;
}

bool ReleaseCapture::chattering(tick_t now) {
  const uint8_t present = static_cast<uint8_t>(now >> 11);
  if (!gave_up() && next_in == seen_in) still_at = present;
  seen_in = next_in;
  const bool chatter = static_cast<uint8_t>(present - still_at) < kMostChatter;
  // The byte must not come round to fewer.
  if (!chatter) still_at = static_cast<uint8_t>(present - kMostChatter);
  GPIOR1 = chatter;
  return chatter;
}

bool ReleaseCapture::gave_up() { return (TIMSK1 & _BV(ICIE1)) == 0; }

// Capture that was given up begins anew.
uint8_t ReleaseCapture::levels() {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    left_ticks = kFollowTicks;
    if (gave_up()) {
      GPIOR0 = kByNone;
      TIMER1_CAPT_vect();
    }
  }
  return static_cast<uint8_t>(open_now() >> 6);
}

}  // namespace sequencer
}  // namespace tfsat
