// What avr_*.cpp share: simavr's header, the ATmega32U4's register addresses (data space; datasheet
// section 31, register summary) and a way to stand in for one of simavr's register handlers.
#pragma once

#include <simavr/sim_avr.h>

#include <cstdint>

namespace tfsat {
namespace emulator {

constexpr uint64_t kCyclesPerUs = 16;
constexpr uint64_t kNever = ~uint64_t{0};

namespace reg {
constexpr avr_io_addr_t kPinb = 0x23, kDdrb = 0x24, kPortb = 0x25;
constexpr avr_io_addr_t kPinc = 0x26, kDdrc = 0x27, kPortc = 0x28;
constexpr avr_io_addr_t kPind = 0x29, kDdrd = 0x2A, kPortd = 0x2B;
constexpr avr_io_addr_t kEecr = 0x3F, kEedr = 0x40, kEearl = 0x41, kEearh = 0x42;
constexpr avr_io_addr_t kGtccr = 0x43, kMcusr = 0x54, kSpmcsr = 0x57, kWdtcsr = 0x60;
constexpr avr_io_addr_t kPcmsk0 = 0x6B;
constexpr avr_io_addr_t kUsbcon = 0xD8, kUsbsta = 0xD9, kUdcon = 0xE0, kUdint = 0xE1, kUdien = 0xE2;
constexpr avr_io_addr_t kUdfnuml = 0xE4, kUdfnumh = 0xE5, kUeintx = 0xE8, kUenum = 0xE9, kUeienx = 0xF0;
}  // namespace reg

// Puts `handler` in simavr's place for writes to (reads of) one register. The tables are part of
// simavr's public avr_t; avr_register_io_write() would run simavr's own handler as well.
inline void replace_write(avr_t* avr, avr_io_addr_t address, avr_io_write_t handler, void* param) {
  avr->io[AVR_DATA_TO_IO(address)].w.c = handler;
  avr->io[AVR_DATA_TO_IO(address)].w.param = param;
}
inline void replace_read(avr_t* avr, avr_io_addr_t address, avr_io_read_t handler, void* param) {
  avr->io[AVR_DATA_TO_IO(address)].r.c = handler;
  avr->io[AVR_DATA_TO_IO(address)].r.param = param;
}

// Sees every write to one register after simavr has carried it out.
class WriteTap {
 public:
  typedef void (*Watcher)(void* owner, uint8_t value);

  void attach(avr_t* avr, avr_io_addr_t address, Watcher watcher, void* owner) {
    const auto& present = avr->io[AVR_DATA_TO_IO(address)].w;
    next_ = present.c;
    next_param_ = present.param;
    watcher_ = watcher;
    owner_ = owner;
    replace_write(avr, address, &WriteTap::on_write, this);
  }

 private:
  static void on_write(avr_t* avr, avr_io_addr_t address, uint8_t value, void* param) {
    WriteTap& tap = *static_cast<WriteTap*>(param);
    if (tap.next_ != nullptr) {
      tap.next_(avr, address, value, tap.next_param_);
    } else {
      avr->data[address] = value;
    }
    tap.watcher_(tap.owner_, value);
  }

  avr_io_write_t next_ = nullptr;
  void* next_param_ = nullptr;
  Watcher watcher_ = nullptr;
  void* owner_ = nullptr;
};

// The interrupt vector of this number, as simavr registered it; null when it models none.
inline avr_int_vector_t* find_vector(avr_t* avr, uint8_t number) {
  for (int i = 0; i < avr->interrupts.vector_count; ++i) {
    if (avr->interrupts.vector[i]->vector == number) return avr->interrupts.vector[i];
  }
  return nullptr;
}

}  // namespace emulator
}  // namespace tfsat
