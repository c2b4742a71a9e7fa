#include "avr_eeprom.h"

namespace tfsat {
namespace emulator {

namespace {

constexpr uint8_t kReadEnable = 0x01, kProgramEnable = 0x02, kMasterProgramEnable = 0x04;
constexpr uint8_t kReadyInterruptEnable = 0x08, kModeBits = 0x30;
enum : uint8_t { kEraseAndWrite = 0x00, kEraseOnly = 0x10, kWriteOnly = 0x20 };

constexpr uint64_t kEraseAndWriteCycles = 3400 * kCyclesPerUs;
constexpr uint64_t kHalfCycles = 1800 * kCyclesPerUs;

}  // namespace

constexpr size_t AvrEeprom::kSize;

AvrEeprom::AvrEeprom(avr_t* avr) : avr_(avr) {
  cells_.fill(0xFF);
  replace_read(avr_, reg::kEecr, &AvrEeprom::on_read, this);
  replace_write(avr_, reg::kEecr, &AvrEeprom::on_write, this);
}

void AvrEeprom::reset() {
  control_ = 0;
  master_enable_until_ = 0;
  if (!busy()) return;
  const uint64_t left = busy_until_ > avr_->cycle ? busy_until_ - avr_->cycle : 0;
  avr_cycle_timer_register(avr_, left, &AvrEeprom::on_done, this);
}

void AvrEeprom::cut_power() {
  if (!busy()) return;
  cells_[address_] = erased_;
  busy_until_ = kNever;
}

void AvrEeprom::begin_write(uint8_t mode) {
  address_ =
      static_cast<uint16_t>((avr_->data[reg::kEearh] << 8 | avr_->data[reg::kEearl]) % kSize);
  const uint8_t before = cells_[address_];
  const uint8_t value = avr_->data[reg::kEedr];
  erased_ = mode == kWriteOnly ? before : 0xFF;
  result_ = mode == kEraseOnly ? 0xFF : (mode == kWriteOnly ? before & value : value);
  const uint64_t duration = mode == kEraseAndWrite ? kEraseAndWriteCycles : kHalfCycles;
  busy_until_ = avr_->cycle + duration;
  ++writes_begun_;
  avr_cycle_timer_register(avr_, duration, &AvrEeprom::on_done, this);
}

void AvrEeprom::end_write() {
  cells_[address_] = result_;
  busy_until_ = kNever;
}

uint8_t AvrEeprom::on_read(avr_t* avr, avr_io_addr_t, void* self) {
  const AvrEeprom& eeprom = *static_cast<AvrEeprom*>(self);
  uint8_t value = eeprom.control_;
  if (eeprom.busy()) value |= kProgramEnable;
  if (avr->cycle < eeprom.master_enable_until_) value |= kMasterProgramEnable;
  return value;
}

void AvrEeprom::on_write(avr_t* avr, avr_io_addr_t, uint8_t value, void* self) {
  AvrEeprom& eeprom = *static_cast<AvrEeprom*>(self);
  const bool enabled = avr->cycle <= eeprom.master_enable_until_;
  eeprom.control_ = value & (kReadyInterruptEnable | kModeBits);
  if (eeprom.busy()) return;
  if ((value & kProgramEnable) != 0) {
    if (!enabled) return;
    eeprom.master_enable_until_ = 0;
    eeprom.begin_write(value & kModeBits);
    avr->cycle += 2;  // the CPU halts
  } else if ((value & kMasterProgramEnable) != 0) {
    eeprom.master_enable_until_ = avr->cycle + 4;
  }
  if ((value & kReadEnable) != 0 && !eeprom.busy()) {
    const uint16_t address =
        static_cast<uint16_t>(avr->data[reg::kEearh] << 8 | avr->data[reg::kEearl]);
    avr->data[reg::kEedr] = eeprom.cells_[address % kSize];
    avr->cycle += 4;
  }
}

avr_cycle_count_t AvrEeprom::on_done(avr_t*, avr_cycle_count_t, void* self) {
  static_cast<AvrEeprom*>(self)->end_write();
  return 0;
}

}  // namespace emulator
}  // namespace tfsat
