#include "lpi2c_bus.h"

namespace tfsat {
namespace logger {

namespace {

constexpr uint32_t kLpi2cMhz = 24;                   // Wire's begin() chooses the 24 MHz oscillator
constexpr uint32_t kFifoWords = 4;                   // transmit and receive FIFO (PARAM register)
constexpr uint32_t kFifoCountMask = 0x07;            // MFSR: transmit count bits 2-0, receive 18-16
constexpr uint32_t kReceiveCountShift = 16;
constexpr uint32_t kAllFlags = 0x00007F00;           // MSR: the flags that are cleared by writing 1
constexpr uint32_t kHalfClockUs = 2;                 // of the nine clocks that free a bus
constexpr uint32_t kBroken = LPI2C_MSR_ALF | LPI2C_MSR_FEF | LPI2C_MSR_PLTF;

}  // namespace

void Lpi2cBus::set_clock(uint16_t khz) {
  khz_ = khz;
  restart();
}

void Lpi2cBus::start_read(uint8_t address, uint8_t reg, uint8_t* data, uint8_t size) {
  begin_transfer(data, size);
  push(LPI2C_MTDR_CMD_START | static_cast<uint32_t>(address << 1));
  push(LPI2C_MTDR_CMD_TRANSMIT | reg);
  push(LPI2C_MTDR_CMD_START | static_cast<uint32_t>(address << 1) | 1u);
  push(LPI2C_MTDR_CMD_RECEIVE | static_cast<uint32_t>(size - 1));
  push(LPI2C_MTDR_CMD_STOP);
  poll();  // the first words go out now; the FIFO keeps the bus at work until the next call
}

void Lpi2cBus::start_write(uint8_t address, uint8_t reg, uint8_t value) {
  begin_transfer(nullptr, 0);
  push(LPI2C_MTDR_CMD_START | static_cast<uint32_t>(address << 1));
  push(LPI2C_MTDR_CMD_TRANSMIT | reg);
  push(LPI2C_MTDR_CMD_TRANSMIT | value);
  push(LPI2C_MTDR_CMD_STOP);
  poll();
}

void Lpi2cBus::begin_transfer(uint8_t* data, uint8_t size) {
  data_ = data;
  size_ = size;
  received_ = 0;
  command_count_ = 0;
  commands_sent_ = 0;
  nacked_ = false;
  bus_taken_ = false;
  began_us_ = micros();
  result_ = I2cResult::kBusy;
}

// The bus is busy for a moment after a stop and after a restart of the master; longer than that, a
// line is held low.
bool Lpi2cBus::take_bus(uint32_t waited_us) {
  const uint32_t status = port_.MSR;
  if ((status & LPI2C_MSR_BBF) != 0 && (status & LPI2C_MSR_MBF) == 0) {
    if (waited_us > kI2cStuckUs) end(I2cResult::kStuck);
    return false;
  }
  port_.MSR = kAllFlags;
  return true;
}

I2cResult Lpi2cBus::poll() {
  if (result_ != I2cResult::kBusy) return result_;
  const uint32_t waited_us = micros() - began_us_;
  const bool late = waited_us > i2c_read_deadline_us(khz_, size_);
  if (!bus_taken_) {
    bus_taken_ = take_bus(waited_us);
    if (!bus_taken_) return result_;
  }
  if (nacked_) {
    const bool stopped = (port_.MSR & LPI2C_MSR_SDF) != 0;
    return stopped || late ? give_up(I2cResult::kNack) : I2cResult::kBusy;
  }

  feed();
  drain();
  const uint32_t status = port_.MSR;
  if (status & LPI2C_MSR_NDF) {
    port_.MCR |= LPI2C_MCR_RTF | LPI2C_MCR_RRF;
    port_.MTDR = LPI2C_MTDR_CMD_STOP;
    nacked_ = true;
    return I2cResult::kBusy;
  }
  if ((status & kBroken) != 0) return give_up(I2cResult::kTimeout);
  const bool all_sent = commands_sent_ == command_count_ && (port_.MFSR & kFifoCountMask) == 0;
  if (all_sent && received_ == size_ && (status & LPI2C_MSR_SDF)) return end(I2cResult::kDone);
  return late ? give_up(I2cResult::kTimeout) : I2cResult::kBusy;
}

void Lpi2cBus::feed() {
  while (commands_sent_ < command_count_ && (port_.MFSR & kFifoCountMask) < kFifoWords) {
    port_.MTDR = commands_[commands_sent_++];
  }
}

// A full receive FIFO only makes the master hold the clock.
void Lpi2cBus::drain() {
  while (received_ < size_ && ((port_.MFSR >> kReceiveCountShift) & kFifoCountMask) > 0) {
    data_[received_++] = static_cast<uint8_t>(port_.MRDR);
  }
}

// A fresh start leaves no flag and no word behind that the next transfer would trip over.
I2cResult Lpi2cBus::give_up(I2cResult result) {
  restart();
  return end(result);
}

// I2C-bus specification UM10204 rev. 7, 3.1.16: nine clocks free a slave that holds the data line;
// then a stop. The clock's pin must be told that it is high before it is an output, or the clock dips
// when it becomes one; digitalWrite() of a pin that is none yet changes its pull-up alone.
void Lpi2cBus::recover() {
  pinMode(sda_pin_, INPUT_PULLUP);
  *portSetRegister(scl_pin_) = digitalPinToBitMask(scl_pin_);
  pinMode(scl_pin_, OUTPUT_OPENDRAIN);
  for (uint8_t clock = 0; clock < 9 && digitalRead(sda_pin_) == LOW; ++clock) {
    digitalWrite(scl_pin_, LOW);
    delayMicroseconds(kHalfClockUs);
    digitalWrite(scl_pin_, HIGH);
    delayMicroseconds(kHalfClockUs);
  }
  pinMode(sda_pin_, OUTPUT_OPENDRAIN);
  digitalWrite(sda_pin_, LOW);
  delayMicroseconds(kHalfClockUs);
  digitalWrite(sda_pin_, HIGH);
  delayMicroseconds(kHalfClockUs);
  restart();
}

// Wire's begin() resets the master, gives it its pins back and waits for nothing. Its setClock()
// knows 100 and 400 kHz, and has a new master take the bus for busy until it was idle for 250 or
// 150 us: with no other master, a bit time is enough. MCFGR2 may be written while MEN is 0.
void Lpi2cBus::restart() {
  wire_.begin();
  wire_.setClock(khz_ * 1000u);
  const uint32_t prescaler = port_.MCFGR1 & LPI2C_MCFGR1_PRESCALE(7);
  const uint32_t idle_cycles = kI2cIdleUs * (kLpi2cMhz >> prescaler);
  port_.MCR = 0;
  port_.MCFGR2 = (port_.MCFGR2 & ~LPI2C_MCFGR2_BUSIDLE(0xFFF)) | LPI2C_MCFGR2_BUSIDLE(idle_cycles);
  port_.MCR = LPI2C_MCR_MEN;
}

}  // namespace logger
}  // namespace tfsat
