#include "recorder.h"

#include "file_budget.h"

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
  number_ = number;
  capture_ = Capture::kOff;  // a failed recording may still be capturing
  goes_on_ = false;
  continued_ = false;
  watch_.reset(plan.header.accel_lsb_per_g);
  const ErrorCode error = open(plan);
  capture_ = Capture::kOn;
  if (error != ErrorCode::kNone) fail(error);
  return ErrorCode::kNone;
}

// The switches have been followed all the time: a release between the files is the next file's. After
// a landing the watch begins anew.
void Recorder::start_next_file(const Plan& plan) {
  const bool after_landing = watch_.phase() == DropPhase::kLanded;
  continued_ = !after_landing;
  if (after_landing) {
    goes_on_ = false;
    watch_.reset(plan.header.accel_lsb_per_g);
  }
  const ErrorCode error = open(plan);
  capture_ = Capture::kOn;
  goes_on_ = false;
  if (error != ErrorCode::kNone) fail(error);
}

ErrorCode Recorder::open(const Plan& plan) {
  const ErrorCode error = writer_.open(plan.file_blocks);
  plan_ = plan;
  error_ = ErrorCode::kNone;
  stop_reason_ = protocol::StopReason::kHost;
  footer_added_ = false;
  ram_released_ = false;
  followed_ = DropPhase::kWaiting;
  releases_followed_ = 0;
  fall_kept_ = false;
  drop_only_in_ram_ = false;
  high_water_quarters_ = 0;
  file_reserve_blocks_ =
      ring_.capacity() < plan.file_blocks / 2 ? ring_.capacity() : plan.file_blocks / 2;
  const uint32_t for_drop =
      drop_blocks(static_cast<uint32_t>(plan.header.rate_hz), plan.after_landing_s);
  const uint32_t half = (plan.file_blocks - file_reserve_blocks_) / 2;
  file_spare_blocks_ = for_drop < half ? for_drop : half;
  builder_.begin(plan.session, plan.header, plan.unix_at_zero_us,
                 plan.file_blocks - file_reserve_blocks_);
  state_ = LoggerState::kRecording;
  return error;
}

ErrorCode Recorder::stop() {
  if (session() == 0) return ErrorCode::kNotRecording;
  goes_on_ = false;
  end(protocol::StopReason::kHost);
  return ErrorCode::kNone;
}

void Recorder::end(protocol::StopReason reason) {
  Capture capture = capture_;
  while (capture != Capture::kOff &&
         !capture_.compare_exchange_weak(capture, Capture::kFinishing)) {
  }
  if (state_ != LoggerState::kRecording) return;
  state_ = LoggerState::kStopping;
  stop_reason_ = reason;
}

void Recorder::poll(uint64_t t_us) {
  if (capturing() || state_ == LoggerState::kRecording) follow_drop(t_us);
  if (!uses_card()) return;
  const bool falling = followed_ != DropPhase::kWaiting;
  const ErrorCode error = writer_.poll(t_us, capturing(), falling);
  if (error != ErrorCode::kNone) {
    fail(error);
    return;
  }
  const bool between_files =
      goes_on_ && !capturing() && stop_reason_ == protocol::StopReason::kFileFull;
  if (between_files && writer_.in_trouble_for(t_us, kChangeLimitUs)) {
    fail(writer_.trouble());
    return;
  }
  // The interrupt ends a capture that would cost RAM the drop.
  if (state_ == LoggerState::kRecording && !capturing()) {
    goes_on_ = followed_ != DropPhase::kLanded;
    end(protocol::StopReason::kCardGone);
  }
  if (state_ == LoggerState::kRecording) follow_file();
  if (state_ == LoggerState::kStopping && capture_ == Capture::kOff) finish(t_us);
}

// Where the file ends in a fall, the room for the second copy is the first's, and all of it is used.
void Recorder::follow_file() {
  const bool falling = followed_ != DropPhase::kWaiting && !fall_kept_;
  if (falling && builder_.room() < ring_.capacity() / 4) {
    builder_.add_room(file_reserve_blocks_);
    file_reserve_blocks_ = 0;
  }
  const bool waiting = followed_ == DropPhase::kWaiting;
  const bool card_takes = writer_.trouble() == ErrorCode::kNone;
  const bool next = waiting && card_takes && builder_.room() <= file_spare_blocks_;
  if (!next && !builder_.file_full()) return;
  error_ = ErrorCode::kCardFull;
  goes_on_ = waiting;
  end(protocol::StopReason::kFileFull);
}

void Recorder::follow_drop(uint64_t t_us) {
  const DropPhase phase = watch_.phase();
  const uint32_t releases = watch_.releases();
  if (releases != releases_followed_ && phase != DropPhase::kWaiting) {
    releases_followed_ = releases;
    fall_kept_ = false;
    released_us_ = watch_.released_us(t_us);
    drop_first_block_ = block_before(released_us_);
  }
  if (phase == DropPhase::kLanded && followed_ != DropPhase::kLanded) landed_us_ = t_us;
  followed_ = phase;
  if (followed_ != DropPhase::kWaiting) keep_fall(t_us);
  const bool on_card_twice = fall_kept_ && writer_.rewritten();
  const bool card_takes = uses_card() && writer_.trouble() == ErrorCode::kNone;
  drop_only_in_ram_ = followed_ != DropPhase::kWaiting && !on_card_twice && !card_takes;
}

// Of the fall, RAM holds what it needs to once the blow is over, and as much as it can when it
// would lose the beginning.
void Recorder::keep_fall(uint64_t t_us) {
  const bool landed = followed_ == DropPhase::kLanded;
  const bool over = landed && t_us - landed_us_ >= protocol::kRewriteAfterLandingUs &&
                    t_us >= released_us_ + protocol::kRewriteAfterReleaseUs;
  if (!fall_kept_ && (over || no_room_behind_drop(kRewriteSpareBlocks))) {
    fall_kept_ = true;
    if (uses_card()) write_fall_again();
  }
  if (fall_kept_ && state_ == LoggerState::kFailed) {
    end(protocol::StopReason::kLanding);  // more would take the room of the fall
  }
  if (!landed || t_us - landed_us_ < plan_.after_landing_s * 1000000ull) return;
  if (state_ == LoggerState::kRecording) goes_on_ = watch_.seated();
  end(protocol::StopReason::kLanding);
}

bool Recorder::no_room_behind_drop(uint32_t spare_blocks) const {
  return builder_.blocks() - drop_first_block_ + spare_blocks >= ring_.capacity();
}

// The newest block in RAM that begins kRewriteBeforeReleaseUs before `t_us`, or the oldest. Only
// samples tell: an event may come late into the log.
uint32_t Recorder::block_before(uint64_t t_us) const {
  Block block;
  protocol::BlockHeader head;
  uint32_t number = ring_.committed();
  while (number > ring_.oldest() && ring_.copy(number - 1, block)) {
    --number;
    const bool read = head.decode(block.bytes, protocol::BlockHeader::kSize);
    if (read && head.sample_count > 0 && head.time_us + protocol::kRewriteBeforeReleaseUs <= t_us) {
      break;
    }
  }
  return number;
}

// When the file's end has no room for it, because of an earlier drop or a long one, what has not been
// recorded yet gives some.
void Recorder::write_fall_again() {
  const uint32_t wanted = builder_.blocks() - drop_first_block_;
  if (wanted > file_reserve_blocks_) {
    file_reserve_blocks_ += builder_.give_room(wanted - file_reserve_blocks_);
  }
  file_reserve_blocks_ -= writer_.rewrite(drop_first_block_, file_reserve_blocks_);
}

void Recorder::finish(uint64_t t_us) {
  if (writer_.rewriting()) return;  // the footer counts it
  if (!footer_added_) {
    protocol::LogFooter footer = {};
    footer.card_stall_max_ms = writer_.stall_max_ms();
    footer.blocks_rewritten = writer_.blocks_rewritten();
    footer.stop_reason = stop_reason_;
    footer_added_ = builder_.add_footer(t_us, footer);
  }
  if (!footer_added_ || !writer_.drained(t_us)) return;
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
  // What was to follow goes into RAM, unless that holds a fall that no card has.
  const bool follows = goes_on_ && stop_reason_ == protocol::StopReason::kFileFull;
  goes_on_ = false;
  if (follows) {
    capture_ = Capture::kNewest;
    return;
  }
  Capture on = Capture::kOn;  // a recording that was ending just ends
  capture_.compare_exchange_strong(on, Capture::kNewest);
}

uint32_t Recorder::ram_blocks() const { return ring_.committed() - ring_.oldest(); }

bool Recorder::copy_from_ram(uint32_t index, Block& out) const {
  return index < ram_blocks() && ring_.copy(ring_.oldest() + index, out);
}

bool Recorder::ram_holds_drop() const {
  return state_ == LoggerState::kFailed && watch_.phase() != DropPhase::kWaiting && !ram_released_;
}

void Recorder::capture(uint64_t t_us, const protocol::Sample& sample, EventQueue& events) {
  if (capturing() && drop_only_in_ram_ && no_room_behind_drop(kBlocksAnInstant + 1)) {
    capture_ = Capture::kFinishing;
  }
  const Capture capture = capture_;
  if (capture == Capture::kOff) {
    if (!goes_on_) events.clear();  // else they are the next file's
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
    if (goes_on_) watch_.tell_release_again();
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
