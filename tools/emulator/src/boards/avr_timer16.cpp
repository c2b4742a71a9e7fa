#include "avr_timer16.h"

#include <algorithm>

namespace tfsat {
namespace emulator {

namespace {

// Offsets from TCCRnA.
enum : int { kControlA = 0, kControlB = 1, kControlC = 2, kCount = 4, kCaptured = 6, kCompare = 8 };

constexpr uint8_t kNoiseCanceler = 0x80, kRisingEdge = 0x40;
constexpr uint64_t kNoiseCancelerCycles = 4;
constexpr uint64_t kTurn = 65536;

// Bits of TIMSKn and TIFRn, in the order of Timer16::Vector.
constexpr uint8_t kFlagBit[] = {5, 1, 2, 3, 0};

}  // namespace

constexpr int Timer16::kChannels;

Timer16::Timer16(avr_t* avr, const Layout& layout, Prescaler& prescaler,
                 CompareOutputListener* listener)
    : avr_(avr), layout_(layout), prescaler_(prescaler), listener_(listener) {
  for (int i = 0; i < kVectors; ++i) {
    const uint8_t number = static_cast<uint8_t>(layout_.capture_vector + i);
    vectors_[i] = find_vector(avr_, number);
    if (vectors_[i] != nullptr) continue;
    compare_c_.vector = number;
    compare_c_.enable = AVR_IO_REGBIT(layout_.timsk, kFlagBit[i]);
    compare_c_.raised = AVR_IO_REGBIT(layout_.tifr, kFlagBit[i]);
    avr_register_vector(avr_, &compare_c_);
    vectors_[i] = &compare_c_;
  }
  for (int offset = kControlA; offset < kCompare + 2 * kChannels; ++offset) {
    const avr_io_addr_t address = static_cast<avr_io_addr_t>(layout_.tccra + offset);
    replace_write(avr_, address, &Timer16::on_write, this);
    replace_read(avr_, address, &Timer16::on_read, this);
  }
  for (const avr_io_addr_t address : {layout_.timsk, layout_.tifr}) {
    replace_write(avr_, address, &Timer16::on_write, this);
    replace_read(avr_, address, &Timer16::on_read, this);
  }
  reset();
}

void Timer16::reset() {
  control_a_ = control_b_ = temp_ = 0;
  compare_.fill(0);
  captured_ = 0;
  output_.fill(false);
  anchor_cycle_ = avr_->cycle;
  anchor_count_ = 0;
  filtered_pin_ = pin_;
  plan();
}

uint32_t Timer16::divider() const {
  static const uint16_t kDividers[8] = {0, 1, 8, 64, 256, 1024, 0, 0};
  return prescaler_.held ? 0 : kDividers[control_b_ & 7];
}

uint16_t Timer16::count_at(uint64_t cycle) const {
  const uint32_t divide = divider();
  if (divide == 0) return anchor_count_;
  const uint64_t ticks =
      (cycle - prescaler_.origin) / divide - (anchor_cycle_ - prescaler_.origin) / divide;
  return static_cast<uint16_t>(anchor_count_ + ticks);
}

uint64_t Timer16::next_tick(uint64_t cycle) const {
  const uint32_t divide = divider();
  return prescaler_.origin + ((cycle - prescaler_.origin) / divide + 1) * divide;
}

// A match acts at the clock that ends the count it was found in (datasheet figure 14-11).
uint64_t Timer16::match_after(uint64_t cycle, uint16_t value) const {
  const uint16_t ahead = static_cast<uint16_t>(value - count_at(cycle));
  return next_tick(cycle) + uint64_t{ahead} * divider();
}

uint64_t Timer16::next_due() const {
  return std::min({match_due_[0], match_due_[1], match_due_[2], overflow_due_});
}

// Makes now the anchor of the count, so that the clock may change.
void Timer16::settle() {
  catch_up();
  anchor_count_ = count_at(avr_->cycle);
  anchor_cycle_ = avr_->cycle;
}

// Carries out what was due up to now. simavr runs cycle timers between instructions only, and an
// interrupt's entry takes cycles after them.
void Timer16::catch_up() {
  for (;;) {
    const uint64_t due = next_due();
    if (due > avr_->cycle) return;
    fire(due);
  }
}

void Timer16::plan() {
  match_due_.fill(kNever);
  overflow_due_ = kNever;
  if (divider() != 0 && normal_mode()) {
    for (int i = 0; i < kChannels; ++i) match_due_[i] = match_after(avr_->cycle, compare_[i]);
    overflow_due_ = match_after(avr_->cycle, 0xFFFF);
  }
  arm();
}

void Timer16::arm() {
  const uint64_t due = next_due();
  if (due == kNever) {
    avr_cycle_timer_cancel(avr_, &Timer16::on_due, this);
    return;
  }
  avr_cycle_timer_register(avr_, due > avr_->cycle ? due - avr_->cycle : 0, &Timer16::on_due, this);
}

void Timer16::fire(uint64_t when) {
  const uint64_t turn = kTurn * divider();
  for (int i = 0; i < kChannels; ++i) {
    if (match_due_[i] != when) continue;
    match_due_[i] += turn;
    apply_compare(i, when);
    raise(kCompareA + i);
  }
  if (overflow_due_ == when) {
    overflow_due_ += turn;
    raise(kOverflow);
  }
}

void Timer16::apply_compare(int channel, uint64_t when) {
  const uint8_t mode = com(channel);
  if (mode == 0) return;
  output_[channel] = mode == 1 ? !output_[channel] : mode == 3;
  if (listener_ != nullptr) listener_->compare_output_changed(when);
}

void Timer16::raise(int vector) { avr_raise_interrupt(avr_, vectors_[vector]); }

void Timer16::set_capture_pin(bool high, uint64_t cycle) {
  if (high == pin_) return;
  pin_ = high;
  if ((control_b_ & kNoiseCanceler) == 0) {
    capture(cycle);
    return;
  }
  const uint64_t stable = cycle + kNoiseCancelerCycles;
  avr_cycle_timer_register(avr_, stable > avr_->cycle ? stable - avr_->cycle : 0,
                           &Timer16::on_pin_stable, this);
}

void Timer16::capture(uint64_t cycle) {
  if (filtered_pin_ == pin_) return;
  filtered_pin_ = pin_;
  if (pin_ != ((control_b_ & kRisingEdge) != 0)) return;
  captured_ = count_at(cycle);
  raise(kCapture);
}

uint8_t Timer16::read_register(avr_io_addr_t address) {
  catch_up();
  if (address == layout_.timsk || address == layout_.tifr) return avr_->data[address];
  const int offset = address - layout_.tccra;
  if (offset == kControlA) return control_a_;
  if (offset == kControlB) return control_b_;
  if (offset >= kCompare) {
    const uint16_t value = compare_[(offset - kCompare) / 2];
    return static_cast<uint8_t>(offset % 2 == 0 ? value : value >> 8);
  }
  if (offset == kCount || offset == kCaptured) {
    const uint16_t value = offset == kCount ? count_at(avr_->cycle) : captured_;
    temp_ = static_cast<uint8_t>(value >> 8);
    return static_cast<uint8_t>(value);
  }
  return offset > kCount ? temp_ : 0;
}

void Timer16::write_register(avr_io_addr_t address, uint8_t value) {
  catch_up();
  if (address == layout_.timsk) return write_interrupt_mask(value);
  if (address == layout_.tifr) return clear_flags(value);
  const int offset = address - layout_.tccra;
  if (offset >= kCount) {
    if (offset % 2 != 0) {
      temp_ = value;
    } else {
      write_low_byte(offset, static_cast<uint16_t>(temp_ << 8 | value));
    }
    return;
  }
  settle();
  if (offset == kControlA) control_a_ = value;
  if (offset == kControlB) control_b_ = value;
  if (offset == kControlC) {  // FOCnA, FOCnB, FOCnC: bits 7, 6, 5
    for (int i = 0; i < kChannels; ++i) {
      if ((value & (0x80 >> i)) != 0) apply_compare(i, avr_->cycle);
    }
  }
  plan();
  if (offset == kControlA && listener_ != nullptr) listener_->compare_output_changed(avr_->cycle);
}

void Timer16::write_low_byte(int offset, uint16_t word) {
  if (offset >= kCompare) {
    compare_[(offset - kCompare) / 2] = word;
    plan();
  } else if (offset == kCount) {
    anchor_count_ = word;
    anchor_cycle_ = avr_->cycle;
    plan();
    for (int i = 0; i < kChannels; ++i) {  // the clock after a write to TCNT finds no match
      if (compare_[i] == word && match_due_[i] != kNever) match_due_[i] += kTurn * divider();
    }
    arm();
  }
}

void Timer16::write_interrupt_mask(uint8_t value) {
  avr_->data[layout_.timsk] = value;
  for (int i = 0; i < kVectors; ++i) {
    const bool flagged = (avr_->data[layout_.tifr] >> kFlagBit[i] & 1) != 0;
    if ((value >> kFlagBit[i] & 1) != 0 && flagged && !vectors_[i]->pending) raise(i);
  }
}

void Timer16::clear_flags(uint8_t value) {
  for (int i = 0; i < kVectors; ++i) {
    if ((value >> kFlagBit[i] & 1) != 0) avr_clear_interrupt(avr_, vectors_[i]);
  }
}

uint8_t Timer16::on_read(avr_t*, avr_io_addr_t address, void* self) {
  return static_cast<Timer16*>(self)->read_register(address);
}

void Timer16::on_write(avr_t*, avr_io_addr_t address, uint8_t value, void* self) {
  static_cast<Timer16*>(self)->write_register(address, value);
}

avr_cycle_count_t Timer16::on_due(avr_t*, avr_cycle_count_t, void* self) {
  Timer16& timer = *static_cast<Timer16*>(self);
  timer.catch_up();
  const uint64_t due = timer.next_due();
  return due == kNever ? 0 : due;
}

avr_cycle_count_t Timer16::on_pin_stable(avr_t*, avr_cycle_count_t when, void* self) {
  static_cast<Timer16*>(self)->capture(when);
  return 0;
}

}  // namespace emulator
}  // namespace tfsat
