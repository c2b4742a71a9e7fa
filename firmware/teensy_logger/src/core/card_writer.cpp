#include "card_writer.h"

namespace tfsat {
namespace logger {

using protocol::ErrorCode;

ErrorCode CardWriter::open(uint32_t n_blocks) {
  synced_ = 0;
  unsynced_ = 0;
  stall_ms_ = 0;
  refusals_ = 0;
  refused_ = false;
  was_free_ = false;
  closed_ = false;
  return sink_.open(n_blocks);
}

ErrorCode CardWriter::poll(uint64_t t_us) {
  if (refused_) {
    if (t_us < retry_at_us_) return ErrorCode::kNone;
    const ErrorCode error = sink_.recover(t_us);
    if (error != ErrorCode::kNone) return refuse(error, t_us);
    refused_ = false;
    unsynced_ = 0;  // the card may have forgotten them: they are written again
    busy_since_us_ = t_us;
  }

  const ErrorCode error = sink_.poll(t_us);
  if (error != ErrorCode::kNone) return refuse(error, t_us);
  if (sink_.busy()) {
    // Before it was free for the first time, the file is being prepared, which takes longer.
    const bool gone = was_free_ && t_us - busy_since_us_ >= kBusyLimitUs;
    return gone ? refuse(ErrorCode::kCardWriteFailed, t_us) : ErrorCode::kNone;
  }
  busy_since_us_ = t_us;
  if (refusals_ == 0) note_stall(t_us);

  if (sync_due(t_us)) {
    const ErrorCode result = sink_.sync();
    if (result == ErrorCode::kNone) mark_synced();
    return take(result, t_us);
  }

  const Block* block = ring_.peek(unsynced_);
  if (block == nullptr) return ErrorCode::kNone;
  const ErrorCode result = sink_.write(synced_ + unsynced_, block->bytes);
  if (result == ErrorCode::kNone && unsynced_++ == 0) unsynced_since_us_ = t_us;
  return take(result, t_us);
}

// Half a ring of blocks that only wait to be safe is enough: the other half is for new ones.
bool CardWriter::sync_due(uint64_t t_us) const {
  if (unsynced_ == 0) return false;
  return t_us - unsynced_since_us_ >= protocol::kCardSyncMs * 1000 ||
         unsynced_ >= ring_.capacity() / 2;
}

ErrorCode CardWriter::close(uint64_t t_us) {
  const ErrorCode result = sink_.close(synced_ + unsynced_);
  if (result == ErrorCode::kNone) {
    mark_synced();
    closed_ = true;
  }
  return take(result, t_us);
}

void CardWriter::mark_synced() {
  ring_.release(unsynced_);
  synced_ += unsynced_;
  unsynced_ = 0;
}

// What the card said to a block, a sync or the closing.
ErrorCode CardWriter::take(ErrorCode result, uint64_t t_us) {
  if (result != ErrorCode::kNone) return refuse(result, t_us);
  if (refusals_ > 0) note_stall(t_us);
  refusals_ = 0;
  return ErrorCode::kNone;
}

ErrorCode CardWriter::refuse(ErrorCode error, uint64_t t_us) {
  if (refusals_++ == 0) refused_since_us_ = t_us;
  refused_ = true;
  retry_at_us_ = t_us + kRetryUs;
  const bool ring_full = ring_.waiting() == ring_.capacity();
  const bool given_up =
      (ring_full && refusals_ >= kAttempts) || t_us - refused_since_us_ >= kGiveUpUs;
  return given_up ? error : ErrorCode::kNone;
}

// The card is free now, or takes blocks again. Preparing the file is no stall: counting begins when
// it is free for the first time.
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
