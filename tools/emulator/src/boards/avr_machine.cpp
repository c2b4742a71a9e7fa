#include "avr_machine.h"

#include <simavr/avr_extint.h>
#include <simavr/avr_timer.h>
#include <simavr/avr_watchdog.h>
#include <simavr/sim_hex.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace tfsat {
namespace emulator {

namespace {

constexpr uint64_t kRunCycleLimit = 1000;
constexpr uint64_t kInterruptEntryCycles = 5;  // datasheet section 4.7.1; simavr takes none
constexpr size_t kSerialAddress = 0x0E;
constexpr uint8_t kReadSignatureRow = 0x21;  // SPMCSR: SIGRD and SPMEN
constexpr uint8_t kReadFuses = 0x09;         // SPMCSR: BLBSET and SPMEN
constexpr uint8_t kExternalReset = 0x02, kBrownOutReset = 0x04;
constexpr uint8_t kWatchdogTimeout = 0x27;                    // WDTCSR: WDP3..0
constexpr uint8_t kTimerSync = 0x80, kPrescalerReset = 0x01;  // GTCCR: TSM, PSRSYNC

void free_avr(avr_t* avr) {
  avr_terminate(avr);
  std::free(avr);
}

// RAM after power-on is arbitrary; the same arbitrary bytes each time keep runs repeatable.
void scramble(uint8_t* first, uint8_t* last) {
  uint32_t state = 0x2545F491;
  for (; first != last; ++first) {
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    *first = static_cast<uint8_t>(state);
  }
}

avr_io_t* find_module(avr_t* avr, const char* kind, uint32_t ioctl = 0) {
  for (avr_io_t* io = avr->io_port; io != nullptr; io = io->next) {
    if (std::strcmp(io->kind, kind) == 0 && (ioctl == 0 || io->irq_ioctl_get == ioctl)) return io;
  }
  throw std::runtime_error(std::string("this libsimavr has no ") + kind +
                           " module for the ATmega32U4");
}

avr_t* make_avr(const std::string& hex_path) {
  uint32_t size = 0, start = 0;
  uint8_t* image = read_ihex_file(hex_path.c_str(), &size, &start);
  if (image == nullptr) throw std::runtime_error(hex_path + " is no readable Intel HEX image");
  avr_t* avr = avr_make_mcu_by_name("atmega32u4");
  if (avr == nullptr || start + size > avr->flashend + 1) {
    std::free(image);
    throw std::runtime_error(hex_path +
                             " does not fit an ATmega32U4 (or libsimavr lacks that chip)");
  }
  avr_init(avr);
  avr->frequency = 16000000;
  avr->log = LOG_ERROR;
  avr_loadcode(avr, image, size, start);
  std::free(image);
  return avr;
}

}  // namespace

AvrMachine::AvrMachine(const std::string& hex_path)
    : avr(make_avr(hex_path), &free_avr),
      pins(avr.get()),
      timer1(avr.get(), Timer16::timer1(), prescaler, &pins),
      timer3(avr.get(), Timer16::timer3(), prescaler, nullptr),
      eeprom(avr.get()),
      usb(avr.get()) {
  pins.connect(&timer1, &timer3);
  hook_simavr();
}

void AvrMachine::hook_simavr() {
  avr->custom.data = this;
  simavr_reset_ = avr->reset;
  avr->reset = &AvrMachine::on_reset;
  avr->sleep = &AvrMachine::on_sleep;
  avr_global_logger_set(&AvrMachine::log);
  replace_write(avr.get(), reg::kGtccr, &AvrMachine::on_gtccr_write, this);
  replace_write(avr.get(), reg::kSpmcsr, &AvrMachine::on_spmcsr_write, this);
  wdtcsr_tap_.attach(avr.get(), reg::kWdtcsr, &AvrMachine::on_wdtcsr_write, this);
  avr_irq_register_notify(avr->interrupts.irq + AVR_INT_IRQ_RUNNING, &AvrMachine::on_interrupt,
                          this);
  // simavr's own Timer 1 and 3 still listen to their capture pins; with ICRn as top they do not.
  for (const char name : {'1', '3'}) {
    avr_io_t* io = find_module(avr.get(), "timer", AVR_IOCTL_TIMER_GETIRQ(name));
    reinterpret_cast<avr_timer_t*>(io)->mode.top = avr_timer_wgm_reg_icr;
  }
}

void AvrMachine::power(bool on) {
  if (on == powered) return;
  powered = on;
  if (!on) {
    eeprom.cut_power();
    pins.release_outputs(now);
    usb.reset();
    return;
  }
  avr->cycle = now;
  scramble(avr->data + avr->ioend + 1, avr->data + avr->ramend + 1);
  avr_reset(avr.get());
  avr_regbit_set(avr.get(), avr->reset_flags.porf);
}

void AvrMachine::restart(ResetCause cause) {
  if (!powered) return;
  if (cause == ResetCause::kWatchdog) {
    avr_watchdog_t* watchdog =
        reinterpret_cast<avr_watchdog_t*>(find_module(avr.get(), "watchdog"));
    watchdog->reset_context.wdrf = 1;
    watchdog->reset_context.avr_run = avr->run;
  }
  avr_reset(avr.get());
  if (cause == ResetCause::kBrownOut) avr->data[reg::kMcusr] |= kBrownOutReset;
  if (cause == ResetCause::kExternal) avr->data[reg::kMcusr] |= kExternalReset;
}

void AvrMachine::run_until(uint64_t cycle) {
  now = std::max(now, cycle);
  if (!powered) return;
  if (avr->cycle < now)
    avr_cycle_timer_register(avr.get(), now - avr->cycle, &AvrMachine::on_stop, this);
  while (avr->cycle < now) {
    avr->run(avr.get());
    if (watching_) note_blocking();
    if (avr->state == cpu_Crashed || avr->state == cpu_Done) {
      powered = false;
      throw std::runtime_error("the sequencer's firmware crashed at flash address " +
                               std::to_string(avr->pc) + ". " + fault_);
    }
  }
}

void AvrMachine::watch_blocking() {
  watching_ = true;
  avr->run_cycle_limit = avr->run_cycle_count = 1;
}

// Off by an interrupt, since its entry began, or by a CLI, since that began.
void AvrMachine::note_blocking() {
  const bool off = avr->sreg[S_I] == 0;
  if (off && !off_) {
    const bool interrupt = avr->pc <= avr->interrupts.vector_count * uint32_t{avr->vector_size};
    off_since_ = avr->cycle - (interrupt ? kInterruptEntryCycles : 1);
    off_at_ = static_cast<uint16_t>(avr->pc);
  } else if (!off && off_) {
    uint64_t& longest = blocked[off_at_];
    longest = std::max(longest, avr->cycle - off_since_);
  }
  off_ = off;
}

// Due again at once, until the next run moves it: where the clock passes this moment by the very
// instruction that sends the processor to sleep, simavr sleeps on to the next timer.
avr_cycle_count_t AvrMachine::on_stop(avr_t* avr, avr_cycle_count_t, void*) {
  return avr->cycle + 1;
}

// Every kind of reset comes by here; simavr has just cleared the registers and all cycle timers.
void AvrMachine::on_reset(avr_t* avr) {
  AvrMachine& machine = of(avr);
  if (machine.simavr_reset_ != nullptr) machine.simavr_reset_(avr);
  avr->run_cycle_limit = machine.watching_ ? 1 : kRunCycleLimit;
  machine.prescaler.origin = avr->cycle;
  machine.prescaler.held = false;
  machine.watchdog_timeout_ = 0;
  machine.timer1.reset();
  machine.timer3.reset();
  machine.eeprom.reset();
  machine.usb.reset();
  machine.pins.release_outputs(avr->cycle);
  if (!machine.covered_flash_.empty()) uncover_flash(avr, avr->cycle, &machine);
  avr_cycle_timer_register(avr, 1, &AvrMachine::after_reset, &machine);
}

// What must wait until simavr's modules have reset themselves.
avr_cycle_count_t AvrMachine::after_reset(avr_t* avr, avr_cycle_count_t, void* self) {
  AvrMachine& machine = *static_cast<AvrMachine*>(self);
  machine.usb.start();
  machine.pins.restore();
  // Else simavr polls a low INTn pin at every cycle, nine times slower, even when it is disabled.
  for (const uint8_t line : {0, 1, 2, 3, 6}) avr_extint_set_strict_lvl_trig(avr, line, 0);
  return 0;
}

// simavr tells of an interrupt's begin, with PC on its vector, and of a RETI. The firmware may also
// call a handler, or leave one by longjmp(), so simavr's stack of handlers is not to be relied on.
void AvrMachine::on_interrupt(avr_irq_t*, uint32_t vector, void* self) {
  avr_t* avr = static_cast<AvrMachine*>(self)->avr.get();
  if (vector == 0 || avr->pc != vector * avr->vector_size) return;
  avr->interrupts.running_ptr = 0;
  avr->cycle += kInterruptEntryCycles;
}

void AvrMachine::on_gtccr_write(avr_t* avr, avr_io_addr_t address, uint8_t value, void* self) {
  AvrMachine& machine = *static_cast<AvrMachine*>(self);
  machine.timer1.before_prescaler_change();
  machine.timer3.before_prescaler_change();
  const bool synchronize = (value & kTimerSync) != 0;
  const bool clear = (value & kPrescalerReset) != 0;
  if (clear || machine.prescaler.held) machine.prescaler.origin = avr->cycle;
  machine.prescaler.held = synchronize && clear;
  avr->data[address] = synchronize ? value : static_cast<uint8_t>(value & ~kPrescalerReset);
  machine.timer1.after_prescaler_change();
  machine.timer3.after_prescaler_change();
}

// simavr lets a watchdog that is running keep its old timeout until it is fed; wdt_enable() feeds
// it first, so the new timeout counts from here.
void AvrMachine::on_wdtcsr_write(void* self, uint8_t) {
  AvrMachine& machine = *static_cast<AvrMachine*>(self);
  const uint8_t timeout = machine.avr->data[reg::kWdtcsr] & kWatchdogTimeout;
  if (timeout == machine.watchdog_timeout_) return;
  machine.watchdog_timeout_ = timeout;
  avr_ioctl(machine.avr.get(), AVR_IOCTL_WATCHDOG_RESET, nullptr);
}

// LPM right after SIGRD reads the signature row, after BLBSET fuses and lock bits. simavr's LPM
// cannot, so they lie over the flash for the four cycles in which that LPM must come.
void AvrMachine::on_spmcsr_write(avr_t* avr, avr_io_addr_t address, uint8_t value, void* self) {
  AvrMachine& machine = *static_cast<AvrMachine*>(self);
  avr->data[address] = value;
  if (!machine.covered_flash_.empty()) return;
  if (value == kReadSignatureRow) machine.lay_over_flash(kSerialAddress, machine.serial);
  if (value == kReadFuses) machine.lay_over_flash(0, machine.fuses);
}

template <size_t n>
void AvrMachine::lay_over_flash(uint32_t address, const std::array<uint8_t, n>& bytes) {
  covered_at_ = address;
  covered_flash_.assign(avr->flash + address, avr->flash + address + n);
  std::copy_n(bytes.begin(), n, avr->flash + address);
  avr_cycle_timer_register(avr.get(), 5, &AvrMachine::uncover_flash, this);
}

avr_cycle_count_t AvrMachine::uncover_flash(avr_t* avr, avr_cycle_count_t, void* self) {
  AvrMachine& machine = *static_cast<AvrMachine*>(self);
  std::copy_n(machine.covered_flash_.begin(), machine.covered_flash_.size(),
              avr->flash + machine.covered_at_);
  machine.covered_flash_.clear();
  avr->data[reg::kSpmcsr] = 0;
  return 0;
}

// simavr's own logger prints to the standard output, which belongs to the program's results.
void AvrMachine::log(avr_t* avr, int level, const char* format, va_list arguments) {
  if (avr == nullptr || level > LOG_ERROR || avr->custom.data == nullptr) return;
  char line[256];
  std::vsnprintf(line, sizeof line, format, arguments);
  std::string& fault = of(avr).fault_;
  if (fault.size() < 1000) fault += line;
}

}  // namespace emulator
}  // namespace tfsat
