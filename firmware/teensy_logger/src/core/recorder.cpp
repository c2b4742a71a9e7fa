#include "recorder.h"

namespace tfsat {
namespace logger {

using protocol::DropPhase;
using protocol::ErrorCode;
using protocol::LoggerState;

Recorder::Recorder(Block* ring_blocks, uint32_t ring_capacity, BlockSink& sink)
    : ring_(ring_blocks, ring_capacity), builder_(ring_), writer_(ring_, sink) {}

ErrorCode Recorder::start(uint32_t number, const Plan& plan) {
  if (knows(number)) return ErrorCode::kNone;
  if (uses_card()) return ErrorCode::kWrongState;
  if (ram_holds_drop()) return ErrorCode::kRamHoldsDrop;
  capture_ = Capture::kOff;  // a failed recording may still be capturing
  const ErrorCode error = writer_.open(plan.file_blocks);
  number_ = number;
  plan_ = plan;
  error_ = ErrorCode::kNone;
  stop_reason_ = protocol::StopReason::kHost;
  footer_added_ = false;
  ram_released_ = false;
  followed_ = DropPhase::kWaiting;
  fall_kept_ = false;
  high_water_quarters_ = 0;
  file_reserve_blocks_ =
      ring_.capacity() < plan.file_blocks / 2 ? ring_.capacity() : plan.file_blocks / 2;
  builder_.begin(plan.session, plan.header, plan.unix_at_zero_us,
                 plan.file_blocks - file_reserve_blocks_);
  watch_.reset(plan.header.accel_lsb_per_g);
  state_ = LoggerState::kRecording;
  capture_ = Capture::kOn;
  if (error != ErrorCode::kNone) fail(error);
  return ErrorCode::kNone;
}

ErrorCode Recorder::stop(protocol::StopReason reason) {
  if (session() == 0) return ErrorCode::kNotRecording;
  if (capture_ != Capture::kOff) capture_ = Capture::kFinishing;
  if (state_ == LoggerState::kRecording) {
    state_ = LoggerState::kStopping;
    stop_reason_ = reason;
  }
  return ErrorCode::kNone;
}

void Recorder::poll(uint64_t t_us) {
  if (capturing()) follow_drop(t_us);
  if (!uses_card()) return;
  const ErrorCode error = writer_.poll(t_us);
  if (error != ErrorCode::kNone) {
    fail(error);
    return;
  }
  if (state_ == LoggerState::kRecording && builder_.file_full()) {
    error_ = ErrorCode::kCardFull;
    stop(protocol::StopReason::kFileFull);
  }
  if (state_ == LoggerState::kStopping && capture_ == Capture::kOff) finish(t_us);
}

void Recorder::follow_drop(uint64_t t_us) {
  const DropPhase phase = watch_.phase();
  if (phase != followed_) {
    if (phase == DropPhase::kWaiting) fall_kept_ = false;
    if (followed_ == DropPhase::kWaiting) {
      released_us_ = t_us;
      released_at_block_ = builder_.blocks();
    }
    if (phase == DropPhase::kLanded) landed_us_ = t_us;
    followed_ = phase;
  }
  if (followed_ == DropPhase::kLanded) after_fall(t_us);
}

void Recorder::after_fall(uint64_t t_us) {
  const bool over = t_us - landed_us_ >= protocol::kRewriteAfterLandingUs &&
                    t_us - released_us_ >= protocol::kRewriteAfterReleaseUs;
  if (over && !fall_kept_) {
    fall_kept_ = true;
    if (state_ == LoggerState::kFailed) {
      stop();  // what comes now would take the room of the fall
    } else {
      writer_.rewrite(first_block_of_drop(), file_reserve_blocks_);
    }
  }
  const bool closing = t_us - landed_us_ >= plan_.after_landing_s * 1000000ull;
  if (closing) stop(protocol::StopReason::kLanding);
}

// A block waits for kPartialBlockMs at most, so there are more of them at low rates than samples
// fill.
uint32_t Recorder::first_block_of_drop() const {
  constexpr uint32_t kBeforeMs = protocol::kRewriteBeforeReleaseUs / 1000;
  const uint32_t rate_hz = static_cast<uint32_t>(plan_.header.rate_hz);
  const uint32_t filled = kBeforeMs * rate_hz / (1000 * protocol::kSamplesPerBlock) + 1;
  const uint32_t timed = kBeforeMs / protocol::kPartialBlockMs;
  const uint32_t before = filled > timed ? filled : timed;
  return released_at_block_ > before ? released_at_block_ - before : 0;
}

void Recorder::finish(uint64_t t_us) {
  if (!footer_added_) {
    protocol::LogFooter footer = {};
    footer.card_stall_max_ms = writer_.stall_max_ms();
    footer.blocks_rewritten = writer_.blocks_rewritten();
    footer.stop_reason = stop_reason_;
    footer_added_ = builder_.add_footer(t_us, footer);
  }
  if (!footer_added_ || !writer_.drained()) return;
  const ErrorCode error = writer_.close(t_us);
  if (error != ErrorCode::kNone) {
    fail(error);
  } else if (writer_.closed()) {
    state_ = LoggerState::kStopped;
  }
}

void Recorder::fail(ErrorCode error) {
  error_ = error;
  state_ = LoggerState::kFailed;
  builder_.forget_file();
  Capture on = Capture::kOn;  // a recording that was ending just ends
  capture_.compare_exchange_strong(on, Capture::kNewest);
}

uint32_t Recorder::ram_blocks() const {
  const uint32_t made = ring_.committed();
  return made < ring_.capacity() ? made : ring_.capacity() - 1;
}

bool Recorder::copy_from_ram(uint32_t index, Block& out) const {
  return index < ram_blocks() && ring_.copy(ring_.committed() - ram_blocks() + index, out);
}

bool Recorder::ram_holds_drop() const {
  return state_ == LoggerState::kFailed && watch_.phase() != DropPhase::kWaiting && !ram_released_;
}

void Recorder::capture(uint64_t t_us, const protocol::Sample& sample, EventQueue& events) {
  const Capture capture = capture_;
  if (capture == Capture::kOff) {
    events.clear();
    return;
  }
  if (capture == Capture::kNewest) {
    // The writer has let go of the ring: whoever fills it makes the room.
    while (ring_.waiting() + kBlocksAnInstant > ring_.capacity()) ring_.release();
  }
  note_high_water(t_us, events);
  builder_.flush_if_due(t_us);
  builder_.add_sample(t_us, sample);
  // A chattering input must not fill the card: one block of events an instant, the rest waits.
  uint32_t budget = capture == Capture::kFinishing ? UINT32_MAX : protocol::kEventsPerBlock;
  for (const protocol::Event* event = events.front(); event != nullptr && budget-- > 0;
       event = events.front()) {
    if (!builder_.add_event(*event)) break;
    events.pop();
  }
  if (capture == Capture::kFinishing) {
    builder_.flush();
    capture_ = Capture::kOff;
  }
}

void Recorder::note_high_water(uint64_t t_us, EventQueue& events) {
  const uint32_t waiting = ring_.waiting();
  const uint8_t quarters = static_cast<uint8_t>(waiting * kQuarters / ring_.capacity());
  if (quarters <= high_water_quarters_ || capture_ == Capture::kNewest) return;
  high_water_quarters_ = quarters;
  protocol::Event event = {};
  event.time_us = t_us;
  event.code = protocol::EventCode::kRingHighWater;
  event.arg = quarters;
  event.value = static_cast<int32_t>(waiting);
  events.push(event);
}

}  // namespace logger
}  // namespace tfsat
