#include "native_ports.h"

#include <algorithm>

namespace tfsat {
namespace emulator {

using sequencer::SwitchEdge;
using sequencer::tick_t;

namespace {

constexpr uint8_t kStrokeLinePin = 3;
constexpr uint64_t kNever = UINT64_MAX;

}  // namespace

NativeServos::NativeServos(sequencer::BegunChanges& begun,
                           const std::array<PinHold, protocol::kJointCount>& holds)
    : changes_(begun) {
  for (size_t i = 0; i < holds.size(); ++i) {
    channels_[i].hold = holds[i];
    channels_[i].level = holds[i] == PinHold::kHigh;
  }
}

void NativeServos::hold(uint8_t joint, uint16_t width_ticks, uint32_t frame_ticks) {
  Channel& channel = channels_[joint];
  forget_changes();
  channel.train.hold(ticks() + sequencer::PulseTrain::kShortestGapTicks, width_ticks, frame_ticks);
  if (!channel.pending) plan(channel);
}

void NativeServos::schedule(uint8_t joint, tick_t at, uint16_t width_ticks) {
  changes_.add(joint, at, width_ticks);
}

bool NativeServos::cancel() {
  bool under_way = false;
  changes_.cancel();
  for (Channel& channel : channels_) {
    const bool to_rise = channel.pending && !channel.high;
    under_way |= channel.pending && channel.high && channel.pulse.change != nullptr;
    channel.train.cancel(to_rise ? &channel.pulse : nullptr);
    if (to_rise) channel.fall_ns = channel.rise_ns + channel.pulse.width_ticks * kNanosecondsPerTick;
  }
  return under_way;
}

void NativeServos::stop() {
  forget_changes();
  for (Channel& channel : channels_) {
    channel.train.stop();
    if (!channel.high) channel.pending = false;
  }
}

void NativeServos::forget_changes() {
  changes_.clear();
  for (Channel& channel : channels_) channel.pulse.change = nullptr;
}

void NativeServos::plan(Channel& channel) {
  channel.pulse = channel.train.next();
  const int32_t ahead = static_cast<int32_t>(channel.pulse.rise - ticks());
  channel.rise_ns = (now_ns_ / kNanosecondsPerTick + static_cast<uint64_t>(std::max<int32_t>(ahead, 1))) *
                    kNanosecondsPerTick;
  channel.fall_ns = channel.rise_ns + channel.pulse.width_ticks * kNanosecondsPerTick;
  channel.whole = !channel.level;
  channel.pending = true;
}

uint64_t NativeServos::next_edge_ns(const Channel& channel) const {
  if (!channel.pending) return kNever;
  return channel.high ? channel.fall_ns : channel.rise_ns;
}

// True when the level has changed.
bool NativeServos::update_level(uint8_t joint, uint64_t t_ns, std::deque<PinEdge>& edges) {
  Channel& channel = channels_[joint];
  const bool level = channel.hold == PinHold::kFree ? channel.high : channel.hold == PinHold::kHigh;
  if (level == channel.level) return false;
  channel.level = level;
  edges.push_back({t_ns, joint, level});
  return true;
}

void NativeServos::hold_pin(int joint, PinHold hold, uint64_t origin_ns, std::deque<PinEdge>& edges) {
  Channel& channel = channels_[static_cast<size_t>(joint)];
  channel.hold = hold;
  if (update_level(static_cast<uint8_t>(joint), now_ns_ + origin_ns, edges)) channel.whole = false;
}

void NativeServos::begin_stroke_mark(uint64_t origin_ns, std::deque<PinEdge>& edges) {
  if (!stroke_line_high_) edges.push_back({now_ns_ + origin_ns, kStrokeLinePin, true});
  stroke_line_high_ = true;
  stroke_line_falls_ns_ = now_ns_ + protocol::kStrokeLineUs * 1000;
}

void NativeServos::advance_to(uint64_t t_ns, uint64_t origin_ns, std::deque<PinEdge>& edges) {
  while (true) {
    uint8_t first = 0;
    for (uint8_t i = 1; i < channels_.size(); ++i) {
      if (next_edge_ns(channels_[i]) < next_edge_ns(channels_[first])) first = i;
    }
    Channel& channel = channels_[first];
    const uint64_t servo_ns = next_edge_ns(channel);
    if (stroke_line_high_ && stroke_line_falls_ns_ <= std::min(servo_ns, t_ns)) {
      stroke_line_high_ = false;
      edges.push_back({stroke_line_falls_ns_ + origin_ns, kStrokeLinePin, false});
      continue;
    }
    if (servo_ns > t_ns) break;
    now_ns_ = servo_ns;
    channel.high = !channel.high;
    update_level(first, servo_ns + origin_ns, edges);
    channel.whole = channel.whole && channel.level == channel.high;
    if (channel.high) {
      if (channel.whole && channel.pulse.change != nullptr) begin_stroke_mark(origin_ns, edges);
    } else {
      if (channel.whole) channel.train.was_whole(channel.pulse);
      channel.pending = false;
      if (channel.train.running()) plan(channel);
    }
  }
  now_ns_ = t_ns;
}

void NativeServos::release_pins(uint64_t origin_ns, std::deque<PinEdge>& edges) const {
  for (uint8_t i = 0; i < channels_.size(); ++i) {
    if (channels_[i].level && channels_[i].hold != PinHold::kHigh) edges.push_back({now_ns_ + origin_ns, i, false});
  }
  if (stroke_line_high_) edges.push_back({now_ns_ + origin_ns, kStrokeLinePin, false});
}

bool NativeSwitches::take_edge(SwitchEdge& edge) {
  if (edges_.empty()) return false;
  edge = edges_.front();
  edges_.pop_front();
  return true;
}

void NativeSwitches::set(int index, bool open, tick_t at) {
  const uint8_t bit = static_cast<uint8_t>(1 << index);
  if (((open_ & bit) != 0) == open) return;
  open_ = static_cast<uint8_t>(open ? open_ | bit : open_ & ~bit);
  edges_.push_back({at, static_cast<uint8_t>(index), open, false});
}

void NativeEeprom::write(uint16_t address, uint8_t value) {
  address_ = static_cast<uint16_t>(address % kBytes);
  old_value_ = image_[address_];
  image_[address_] = value;
  ++writes_;
  busy_until_us_ = now_us_ + kWriteUs;
}

void NativeEeprom::power_cut() {
  if (busy()) {
    image_[address_] = old_value_;
    ++writes_;
  }
  now_us_ = 0;
  busy_until_us_ = 0;
}

int NativeStream::read() {
  if (to_board_.empty()) return -1;
  const uint8_t byte = to_board_.front();
  to_board_.pop_front();
  return byte;
}

size_t NativeStream::write(const uint8_t* data, size_t size) {
  const size_t taken = std::min(size, kCapacity - to_host_.size());
  to_host_.insert(to_host_.end(), data, data + taken);
  return taken;
}

void NativeStream::set_plugged(bool plugged) {
  plugged_ = plugged;
  if (!plugged) clear();
}

void NativeStream::set_port(bool open) {
  port_open_ = open;
  if (!open) to_host_.clear();
}

size_t NativeStream::host_write(const uint8_t* data, size_t size) {
  if (!NativeStream::connected()) return 0;  // not the board's question
  const size_t taken = std::min(size, kCapacity - to_board_.size());
  to_board_.insert(to_board_.end(), data, data + taken);
  return taken;
}

size_t NativeStream::host_read(uint8_t* data, size_t capacity) {
  const size_t given = std::min(capacity, to_host_.size());
  std::copy_n(to_host_.begin(), given, data);
  to_host_.erase(to_host_.begin(), to_host_.begin() + static_cast<std::ptrdiff_t>(given));
  return given;
}

void NativeStream::clear() {
  to_board_.clear();
  to_host_.clear();
}

}  // namespace emulator
}  // namespace tfsat
