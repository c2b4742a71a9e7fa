// Blocks from the ring to the card: one at a time, when the card is not busy.
#pragma once

#include "block_ring.h"
#include "ports.h"

namespace tfsat {
namespace logger {

class CardWriter {
 public:
  // A card that takes nothing for longer than this is reported as stalled.
  static constexpr uint32_t kStallUs = 50000;
  // A write that fails this often in a row ends the recording.
  static constexpr uint8_t kAttempts = 3;
  static constexpr uint32_t kRetryUs = 100000;

  CardWriter(BlockRing& ring, BlockSink& sink) : ring_(ring), sink_(sink) {}

  protocol::ErrorCode open(uint32_t n_blocks);
  // One step: at most one block or one sync. An error ends the recording.
  protocol::ErrorCode poll(uint64_t t_us);
  // Everything that was in the ring is with the card, and the card is not busy.
  bool drained() { return ring_.front() == nullptr && !sink_.busy(); }
  protocol::ErrorCode close() { return sink_.close(blocks_written_); }

  uint32_t blocks_written() const { return blocks_written_; }
  // A stall that has ended; false when there was none since the last call.
  bool take_stall(protocol::Event& event);

 private:
  void note_stall(uint64_t t_us);
  protocol::ErrorCode after_attempt(protocol::ErrorCode error, uint64_t t_us);

  BlockRing& ring_;
  BlockSink& sink_;
  uint32_t blocks_written_ = 0;
  uint64_t last_free_us_ = 0;
  uint64_t last_sync_us_ = 0;
  uint64_t stall_began_us_ = 0;
  uint64_t retry_at_us_ = 0;
  uint32_t stall_ms_ = 0;
  uint8_t failures_ = 0;
  bool was_free_ = false;
  bool unsynced_ = false;
};

}  // namespace logger
}  // namespace tfsat
