#include "usb_stream.h"

#include <Arduino.h>
#include <setjmp.h>
#include <util/atomic.h>

#include "../core/ticks.h"

// The Arduino core's handlers of the bus's events and of the control endpoint. They save what they use
// and end with RETI.
extern "C" void USB_GEN_vect(void);
extern "C" void USB_COM_vect(void);

namespace tfsat {
namespace sequencer {

namespace {

constexpr uint16_t kControlLimitTicks = 10 * kTicksPerMs;
// Short, since it is copied with interrupts off: about 20 us.
constexpr size_t kLongestWrite = 24;

jmp_buf host_is_silent;

// After a bus reset the handler of the bus enables the control endpoint's interrupt. No interrupt comes
// between its RETI and the CLI after it, so that one never does. True when a request waits.
bool serve_bus() {
  bool request;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    if (UDINT != 0) asm volatile("call %x0\n\tcli" ::"i"(USB_GEN_vect) : "memory");
    UDIEN = 0;
    UENUM = 0;
    UEIENX = 0;
    request = (UEINTX & _BV(RXSTPI)) != 0;
  }
  return request;
}

void start_limit() {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    OCR3B = static_cast<uint16_t>(TCNT3 + kControlLimitTicks);
    TIFR3 = _BV(OCF3B);
    TIMSK3 |= _BV(OCIE3B);
  }
}

void end_limit() {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { TIMSK3 &= static_cast<uint8_t>(~_BV(OCIE3B)); }
}

}  // namespace

// Only the core's wait loops run this long; an edge of a release switch makes it come at once
// (release_capture.cpp). Leaving them from here loses nothing but the request; longjmp() brings back the
// registers, and the interrupt flag, of setjmp().
ISR(TIMER3_COMPB_vect) { longjmp(host_is_silent, 1); }

void UsbStream::serve(bool (*hurried)()) {
  if (!serve_bus()) return;
  if (setjmp(host_is_silent) == 0) {
    start_limit();
    // From here on an edge ends the wait: one from before is asked for.
    if (!hurried()) USB_COM_vect();
  }
  end_limit();
}

bool UsbStream::connected() {
  return USBDevice.configured() && Serial.dtr() && !USBDevice.isSuspended();
}

int UsbStream::read() { return Serial.read(); }

size_t UsbStream::write(const uint8_t* data, size_t size) {
  size_t taken = 0;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    const size_t room = static_cast<size_t>(Serial.availableForWrite());
    if (room > 1) {
      taken = size < room ? size : room - 1;
      if (taken > kLongestWrite) taken = kLongestWrite;
      taken = Serial.write(data, taken);
    }
  }
  return taken;
}

}  // namespace sequencer
}  // namespace tfsat
