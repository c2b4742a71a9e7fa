#include "card_writer.h"

namespace tfsat {
namespace logger {

using protocol::ErrorCode;
using protocol::EventCode;

ErrorCode CardWriter::open(uint32_t n_blocks) {
  file_blocks_ = n_blocks;
  position_ = 0;
  safe_position_ = 0;
  unsynced_ = 0;
  rewrite_next_ = 0;
  rewrite_safe_ = 0;
  rewrite_end_ = 0;
  rewritten_ = 0;
  rewritten_safe_ = 0;
  stall_max_ms_ = 0;
  refusals_ = 0;
  trouble_ = ErrorCode::kNone;
  refused_ = false;
  was_free_ = false;
  prepare_turn_ = false;
  busy_since_us_ = 0;
  closed_ = false;
  events_.clear();
  return sink_.open(n_blocks);
}

ErrorCode CardWriter::poll(uint64_t t_us, bool capturing, bool falling) {
  capturing_ = capturing;
  may_prepare_ = capturing && !falling && sink_.prepared_blocks() < file_blocks_;
  if (refused_) {
    if (t_us < retry_at_us_) return ErrorCode::kNone;
    const ErrorCode error = sink_.recover(t_us);
    if (error != ErrorCode::kNone) return refuse(error, t_us);
    refused_ = false;
    position_ = safe_position_;  // the card may have forgotten the rest: it is written again
    unsynced_ = 0;
    rewrite_next_ = rewrite_safe_;
    rewritten_ = rewritten_safe_;
    busy_since_us_ = t_us;
  }

  if (sink_.busy(t_us)) {
    if (busy_since_us_ == 0) busy_since_us_ = t_us;
    const bool gone =
        t_us - busy_since_us_ >= kBusyLimitUs || (refusals_ > 0 && ring_low());
    return gone ? refuse(ErrorCode::kCardWriteFailed, t_us) : ErrorCode::kNone;
  }
  busy_since_us_ = t_us;
  if (refusals_ == 0) note_stall(t_us);

  if (prepares(t_us)) return take(sink_.prepare(), t_us);
  if (sync_due(t_us)) {
    const ErrorCode result = sink_.sync();
    if (result == ErrorCode::kNone) mark_synced(t_us);
    return take(result, t_us);
  }

  const Block* block = ring_.peek(unsynced_);
  copy_turn_ = rewriting() && (block == nullptr || !copy_turn_);
  if (copy_turn_) return rewrite_one(t_us);
  if (block == nullptr) return ErrorCode::kNone;
  const ErrorCode result = write_block(t_us, block->bytes);
  if (result == ErrorCode::kNone) ++unsynced_;
  return take(result, t_us);
}

ErrorCode CardWriter::write_block(uint64_t t_us, const uint8_t* block) {
  const ErrorCode result = sink_.write(position_, block);
  if (result == ErrorCode::kNone && position_++ == safe_position_) unsynced_since_us_ = t_us;
  return result;
}

uint32_t CardWriter::rewrite(uint32_t first, uint32_t max_blocks) {
  const uint32_t end = ring_.committed();
  if (first < ring_.oldest()) first = ring_.oldest();
  if (end - first > max_blocks) first = end - max_blocks;
  rewrite_next_ = first;
  rewrite_safe_ = first;
  rewrite_end_ = end;
  return end - first;
}

// New samples take the room of the oldest blocks meanwhile: a block that is gone is passed over.
ErrorCode CardWriter::rewrite_one(uint64_t t_us) {
  if (!ring_.copy(rewrite_next_, copy_)) {
    ++rewrite_next_;
    return ErrorCode::kNone;
  }
  const ErrorCode result = write_block(t_us, copy_.bytes);
  if (result == ErrorCode::kNone) {
    ++rewrite_next_;
    ++rewritten_;
  }
  return take(result, t_us);
}

// In turns: blocks are written until none waits and made safe, then the file is prepared for three
// quarters of the time that blocks may wait to be safe: they are still to be written. A quarter of
// the ring ends that turn, too: the rest is for a stall.
bool CardWriter::prepares(uint64_t t_us) {
  const uint32_t prepared = sink_.prepared_blocks();
  if (position_ >= prepared && prepared < file_blocks_) return true;
  const bool enough = t_us - turn_since_us_ >= protocol::kCardSyncMs * 750 ||
                      ring_.waiting() >= ring_.capacity() / 4;
  if (!may_prepare_ || enough) prepare_turn_ = false;
  return prepare_turn_;
}

// Half a ring of blocks that only wait to be safe is enough: the other half is for new ones.
bool CardWriter::sync_due(uint64_t t_us) const {
  if (position_ == safe_position_) return false;
  if (safe_position_ == 0) return true;  // nothing can be read without the header
  if (may_prepare_ && ring_.peek(unsynced_) == nullptr) return true;
  return t_us - unsynced_since_us_ >= protocol::kCardSyncMs * 1000 ||
         unsynced_ >= ring_.capacity() / 2;
}

ErrorCode CardWriter::close(uint64_t t_us) {
  const ErrorCode result = sink_.close(position_);
  if (result == ErrorCode::kNone) {
    mark_synced(t_us);
    closed_ = true;
  }
  return take(result, t_us);
}

void CardWriter::mark_synced(uint64_t t_us) {
  prepare_turn_ = true;
  turn_since_us_ = t_us;
  ring_.release(unsynced_);
  unsynced_ = 0;
  safe_position_ = position_;
  if (rewrite_safe_ != rewrite_next_ && !rewriting()) {
    note(t_us, EventCode::kRewritten, 0, rewritten_);
  }
  rewrite_safe_ = rewrite_next_;
  rewritten_safe_ = rewritten_;
}

// What the card said to a block, a sync or the closing.
ErrorCode CardWriter::take(ErrorCode result, uint64_t t_us) {
  if (result != ErrorCode::kNone) return refuse(result, t_us);
  if (refusals_ > 0) {
    note_stall(t_us);
    const uint64_t gone_ms = (t_us - refused_since_us_) / 1000;
    note(t_us, EventCode::kCardBack, 0, static_cast<uint32_t>(gone_ms));
  }
  refusals_ = 0;
  trouble_ = ErrorCode::kNone;
  return ErrorCode::kNone;
}

ErrorCode CardWriter::refuse(ErrorCode error, uint64_t t_us) {
  if (refusals_++ == 0) {
    refused_since_us_ = t_us;
    note(t_us, EventCode::kCardLost, static_cast<uint16_t>(error), 0);
  }
  trouble_ = error;
  refused_ = true;
  retry_at_us_ = t_us + kRetryUs;
  const bool too_long = !capturing_ && t_us - refused_since_us_ >= kGiveUpUs;
  return (ring_low() && refusals_ >= kAttempts) || too_long ? error : ErrorCode::kNone;
}

// The card is free now, or takes blocks again. Creating the file is no stall: counting begins when
// it is free for the first time.
void CardWriter::note_stall(uint64_t t_us) {
  const uint64_t took_us = t_us - last_free_us_;
  if (was_free_ && took_us >= kStallUs) {
    const uint32_t took_ms = static_cast<uint32_t>(took_us / 1000);
    if (took_ms > stall_max_ms_) stall_max_ms_ = took_ms;
    note(last_free_us_, EventCode::kCardStall, 0, took_ms);
  }
  last_free_us_ = t_us;
  was_free_ = true;
}

void CardWriter::note(uint64_t t_us, EventCode code, uint16_t arg, uint32_t value) {
  protocol::Event event = {};
  event.time_us = t_us;
  event.code = code;
  event.arg = arg;
  event.value = static_cast<int32_t>(value);
  events_.push(event);
}

bool CardWriter::take_event(protocol::Event& event) {
  const protocol::Event* oldest = events_.front();
  if (oldest == nullptr) return false;
  event = *oldest;
  events_.pop();
  return true;
}

}  // namespace logger
}  // namespace tfsat
