// tfsat logger for Teensy 4.1: records four MPU-6050 and six absolute angle sensors onto the SD
// card. This file gives pins to the core; everything else is under src/.
//
// Inputs take 3.3 V at most: a 5 V line of the sequencer needs a divider.

#include <Arduino.h>
#include <SdFat.h>
#include <Wire.h>

#include "src/core/logger.h"
#include "src/drivers/angle_adc.h"
#include "src/drivers/board_clock.h"
#include "src/drivers/board_identity.h"
#include "src/drivers/cycle_entropy.h"
#include "src/drivers/edge_inputs.h"
#include "src/drivers/flash_memory.h"
#include "src/drivers/lpi2c_bus.h"
#include "src/drivers/sample_timer.h"
#include "src/drivers/sd_block_sink.h"
#include "src/drivers/sd_log_archive.h"
#include "src/drivers/usb_stream.h"

namespace {

using namespace tfsat::logger;

// IMU 1, 2 on Wire (SDA 18, SCL 19); IMU 3, 4 on Wire1 (SDA 17, SCL 16); AD0 low = 1 and 3, high =
// 2 and 4.
Lpi2cBus bus_a(Wire, IMXRT_LPI2C1, 18, 19);
Lpi2cBus bus_b(Wire1, IMXRT_LPI2C3, 17, 16);

// Joint 1 on A0, A1; joint 2 on A6, A7; joint 3 on A8, A9. A2 to A5 are the buses' pins.
const uint8_t kAnglePins[] = {A0, A1, A6, A7, A8, A9};
AngleAdc angle_adc(kAnglePins);

// Release switches to ground on 2 and 3 (closed = low), stroke line of the sequencer on 4.
EdgeInputs inputs(EdgeInputs::Pins{{2, 3}, 4});

CardSlot card_slot;
SdBlockSink card(card_slot);
SdLogArchive archive(card_slot);
FlashMemory memory;
UsbStream usb;
CycleEntropy entropy;

void on_sampling_timer();
PeriodicTimer timer(on_sampling_timer);

DMAMEM Block ring_blocks[kRingBlocks];
Logger board(Ports{bus_a, bus_b, angle_adc, inputs, timer, card, archive, memory, usb, entropy},
             read_identity(), ring_blocks, kRingBlocks);

void on_sampling_timer() { board.sample(now_us()); }

}  // namespace

void setup() {
  pinMode(LED_BUILTIN, OUTPUT);
  bus_a.begin();
  bus_b.begin();
  angle_adc.begin();
  inputs.begin();
  board.begin();
}

void loop() {
  const uint64_t t_us = now_us();
  board.poll(t_us);
  digitalWrite(LED_BUILTIN, board.light(t_us) ? HIGH : LOW);
}
