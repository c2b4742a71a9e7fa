// Sequencer of the transformable CubeSat robot, for the Arduino Micro. Pins to core, nothing else.
//
//   D9 D10 D11  servo signals of joint 1, 2, 3        D4 D13  release switches 1, 2 (closed: low)
//   D12         stroke line to the logger             D6      status LED

#include <avr/sleep.h>

#include "src/core/request_server.h"
#include "src/core/sequencer.h"
#include "src/core/status_led.h"
#include "src/drivers/eeprom_memory.h"
#include "src/drivers/identity.h"
#include "src/drivers/ram_paint.h"
#include "src/drivers/release_capture.h"
#include "src/drivers/reset_cause.h"
#include "src/drivers/status_pin.h"
#include "src/drivers/tick_clock.h"
#include "src/drivers/timer1_servos.h"
#include "src/drivers/usb_stream.h"
#include "src/drivers/watchdog.h"
#include "src/protocol/link.h"

using namespace tfsat::sequencer;

static RetainedState retained __attribute__((section(".noinit")));
static Timer1Servos servos(retained.begun);
static ReleaseCapture switches;
static EepromMemory memory;
static UsbStream usb;
static StatusPin led;
static RamPaint ram;
static Identity identity;
static ImageCrc image_crc;
static Sequencer sequencer(switches, servos, memory, retained);
static RequestServer server(sequencer, identity, ram);
static tfsat::protocol::Link host_link(usb, server);

// Contacts have chattered on for longer than could be followed: a date depends on the main loop.
static bool may_hurry;
static bool hurried() {
  return may_hurry && ReleaseCapture::gave_up();
}

void setup() {
  usb.serve(hurried);
  TickClock::begin();
  servos.begin();
  switches.begin();
  memory.begin();
  led.begin();
  const ResetCause cause = take_reset_cause();
  sequencer.start(TickClock::now(), RamPaint::survived() ? cause : ResetCause::kPowerOn);
  identity = read_identity(cause);
  set_sleep_mode(SLEEP_MODE_IDLE);
}

// Asleep, the processor wakes with every interrupt, at the latest at Timer 0's after 1.02 ms; edges
// are stamped and pulses made by the timers meanwhile.
void loop() {
  const tick_t now = TickClock::now();
  sequencer.poll(now);
  may_hurry = ReleaseCapture::chattering(now) && sequencer.watching();
  usb.serve(hurried);
  // Nobody is answered until the board knows what it is.
  const bool ready = image_crc.read_on(identity.image_crc);
  server.update(now, host_link.rejected_frames());
  if (!usb.connected()) sequencer.host_gone();
  if (ready) host_link.poll();
  led.set(led_on(sequencer.state(), sequencer.uptime_ms()));
  Watchdog::feed(sequencer.may_upload());
  if (ready && !hurried()) sleep_mode();
}
