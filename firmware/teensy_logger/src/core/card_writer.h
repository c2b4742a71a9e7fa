// Blocks from the ring to the card: one at a time, when the card is not busy.
//
// A block stays in the ring until a sync() has made it safe. A card that loses its contact (the jolt
// of the release) forgets what it had not programmed; once it is back, those blocks are written
// again. It is tried for as long as the ring has room, so that nothing is lost that the ring holds.
#pragma once

#include "block_ring.h"
#include "ports.h"

namespace tfsat {
namespace logger {

class CardWriter {
 public:
  // A card that takes nothing for longer than this is reported as stalled.
  static constexpr uint32_t kStallUs = 50000;
  // A card that is busy for longer than this is gone: cards may take 500 ms (SD Physical Layer
  // Simplified Specification, sec. Write Timeout).
  static constexpr uint32_t kBusyLimitUs = 1000000;
  static constexpr uint32_t kRetryUs = 100000;
  // A full ring ends the recording after this many refusals in a row, and time does while nothing
  // is captured any more that could fill it.
  static constexpr uint32_t kAttempts = 3;
  static constexpr uint32_t kGiveUpUs = 15000000;

  CardWriter(BlockRing& ring, BlockSink& sink) : ring_(ring), sink_(sink) {}

  protocol::ErrorCode open(uint32_t n_blocks);
  // One step: at most one block or one sync. An error ends the recording.
  protocol::ErrorCode poll(uint64_t t_us);
  // Everything that was in the ring is with the card, and the card is not busy.
  bool drained() { return !refused_ && ring_.waiting() == unsynced_ && !sink_.busy(); }
  // Closes the drained file. A refusal is met in poll(); closed() tells. An error ends the
  // recording.
  protocol::ErrorCode close(uint64_t t_us);
  bool closed() const { return closed_; }

  uint32_t blocks_written() const { return synced_ + unsynced_; }
  // A stall that has ended; false when there was none since the last call.
  bool take_stall(protocol::Event& event);

 private:
  bool sync_due(uint64_t t_us) const;
  protocol::ErrorCode take(protocol::ErrorCode result, uint64_t t_us);
  protocol::ErrorCode refuse(protocol::ErrorCode error, uint64_t t_us);
  void mark_synced();
  void note_stall(uint64_t t_us);

  BlockRing& ring_;
  BlockSink& sink_;
  uint32_t synced_ = 0;    // blocks of the file that are safe
  uint32_t unsynced_ = 0;  // behind them, with the card and still in the ring
  uint64_t unsynced_since_us_ = 0;
  uint64_t last_free_us_ = 0;
  uint64_t busy_since_us_ = 0;
  uint64_t stall_began_us_ = 0;
  uint64_t refused_since_us_ = 0;
  uint64_t retry_at_us_ = 0;
  uint32_t stall_ms_ = 0;
  uint32_t refusals_ = 0;  // in a row
  bool refused_ = false;   // recover() comes next
  bool was_free_ = false;
  bool closed_ = false;
};

}  // namespace logger
}  // namespace tfsat
