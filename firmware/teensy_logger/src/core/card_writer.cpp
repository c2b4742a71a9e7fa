#include "card_writer.h"

namespace tfsat {
namespace logger {

using protocol::ErrorCode;

ErrorCode CardWriter::open(uint32_t n_blocks) {
  blocks_written_ = 0;
  stall_ms_ = 0;
  retry_at_us_ = 0;
  failures_ = 0;
  was_free_ = false;
  unsynced_ = false;
  return sink_.open(n_blocks);
}

ErrorCode CardWriter::poll(uint64_t t_us) {
  const ErrorCode error = sink_.poll(t_us);
  if (error != ErrorCode::kNone) return error;
  if (sink_.busy() || t_us < retry_at_us_) return ErrorCode::kNone;
  note_stall(t_us);

  if (unsynced_ && t_us - last_sync_us_ >= protocol::kCardSyncMs * 1000) {
    const ErrorCode result = sink_.sync();
    if (result == ErrorCode::kNone) {
      unsynced_ = false;
      last_sync_us_ = t_us;
    }
    return after_attempt(result, t_us);
  }

  const Block* block = ring_.front();
  if (block == nullptr) return ErrorCode::kNone;
  const ErrorCode result = sink_.write(blocks_written_, block->bytes);
  if (result == ErrorCode::kNone) {
    ring_.release();
    ++blocks_written_;
    if (!unsynced_) last_sync_us_ = t_us;
    unsynced_ = true;
  }
  return after_attempt(result, t_us);
}

// One refusal may be a contact that bounced: the same block is tried again a little later.
ErrorCode CardWriter::after_attempt(ErrorCode error, uint64_t t_us) {
  if (error == ErrorCode::kNone) {
    failures_ = 0;
    return ErrorCode::kNone;
  }
  retry_at_us_ = t_us + kRetryUs;
  return ++failures_ < kAttempts ? ErrorCode::kNone : error;
}

// The card is free now. Preparing the file is no stall: counting begins when it is free for the
// first time.
void CardWriter::note_stall(uint64_t t_us) {
  const uint64_t took_us = t_us - last_free_us_;
  if (was_free_ && took_us >= kStallUs) {
    stall_began_us_ = last_free_us_;
    stall_ms_ = static_cast<uint32_t>(took_us / 1000);
  }
  last_free_us_ = t_us;
  was_free_ = true;
}

bool CardWriter::take_stall(protocol::Event& event) {
  if (stall_ms_ == 0) return false;
  event = protocol::Event();
  event.time_us = stall_began_us_;
  event.code = protocol::EventCode::kCardStall;
  event.value = static_cast<int32_t>(stall_ms_);
  stall_ms_ = 0;
  return true;
}

}  // namespace logger
}  // namespace tfsat
