// The I2C driver's recovery on two open-drain lines, pins as the Teensy's core and the chip have them:
// an output's level is that of its data register, which a write to the set register changes.
#include <Arduino.h>

#include <vector>

#include "../../firmware/teensy_logger/src/drivers/lpi2c_bus.h"
#include "check.h"

namespace {

constexpr uint8_t kSda = 0, kScl = 1;
constexpr uint32_t kWords = 36;
constexpr uint32_t kDirection = 1, kSet = 33;

volatile uint32_t port[kWords];
volatile uint32_t unused;

// What the lines have seen: each level of SDA and SCL that differs from the one before.
struct Lines {
  bool low(uint8_t pin) const {
    const uint32_t mask = 1u << pin;
    return gpio[pin] && (port[kDirection] & mask) != 0 && (port[0] & mask) == 0;
  }
  bool scl() const { return !low(kScl); }
  bool sda() const { return !low(kSda) && clocks >= slave_lets_go_after; }
  void settle() {
    port[0] = port[0] | port[kSet];
    port[kSet] = 0;
    if (scl() == was_scl && sda() == was_sda) return;
    if (!was_scl && scl()) ++clocks;
    if (was_scl && !scl()) ++falls;
    if (was_scl && scl() && !was_sda && sda()) ++stops;
    was_scl = scl();
    was_sda = sda();
  }
  int slave_lets_go_after = 0;
  bool gpio[2] = {false, false};
  int clocks = 0, falls = 0, stops = 0;
  bool was_scl = true, was_sda = true;
} lines;

}  // namespace

const digital_pin_bitband_and_config_table_struct digital_pin_to_info_PGM[] = {
    {port, &unused, &unused, 1u << kSda}, {port, &unused, &unused, 1u << kScl}};

// In the order of the core's own: direction, pad, then the pin's multiplexer.
void pinMode(uint8_t pin, uint8_t mode) {
  lines.settle();
  const uint32_t mask = 1u << pin;
  port[kDirection] = mode == OUTPUT_OPENDRAIN ? port[kDirection] | mask : port[kDirection] & ~mask;
  lines.settle();
  lines.gpio[pin] = true;
  lines.settle();
}
void digitalWrite(uint8_t pin, uint8_t value) {
  const uint32_t mask = 1u << pin;
  if ((port[kDirection] & mask) == 0) return;  // it would set the pull-up
  port[0] = value != LOW ? port[0] | mask : port[0] & ~mask;
  lines.settle();
}
uint8_t digitalRead(uint8_t pin) {
  lines.settle();
  return pin == kSda ? lines.sda() : lines.scl();
}
uint32_t micros() { return 0; }
void delayMicroseconds(uint32_t) { lines.settle(); }
void TwoWire::begin() { lines.gpio[kSda] = lines.gpio[kScl] = false; }
void TwoWire::setClock(uint32_t) {}

namespace {

alignas(4) uint8_t registers[sizeof(IMXRT_LPI2C_t)];

// Both data registers are 0 after a reset.
void recover(int slave_lets_go_after, int times) {
  for (volatile uint32_t& word : port) word = 0;
  lines = Lines();
  TwoWire wire;
  tfsat::logger::Lpi2cBus bus(wire, reinterpret_cast<IMXRT_LPI2C_t&>(registers), kSda, kScl);
  for (int i = 0; i < times; ++i) {
    lines.clocks = lines.falls = lines.stops = 0;
    lines.slave_lets_go_after = slave_lets_go_after;
    lines.was_sda = lines.sda();
    bus.recover();
    lines.settle();
  }
}

}  // namespace

TEST_CASE(a_free_bus_sees_a_stop_and_no_clock) {
  for (const int times : {1, 2}) {
    recover(0, times);
    CHECK(lines.falls == 0 && lines.clocks == 0 && lines.stops == 1);
  }
}

TEST_CASE(a_slave_gets_as_many_clocks_as_it_needs) {
  for (int needed = 1; needed <= 9; ++needed) {
    recover(needed, 1);
    CHECK(lines.falls == needed && lines.clocks == needed);
    CHECK(lines.stops >= 1 && lines.scl() && lines.sda());
  }
}
