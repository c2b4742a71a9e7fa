// Blocks from the ring to the card: one at a time, when the card is not busy.
//
// A new file is filled with zeros by what time is left: its first piece before anything else, the
// rest in turns with the blocks that wait, and in a fall no more than it needs. At 1 kHz, sampling
// leaves a fifth of the processor, and filling the whole file would take longer than the ring lasts.
//
// A block stays in the ring until a sync() has made it safe. A card that loses its contact (the jolt
// of the release) forgets what it had not programmed; once it is back, those blocks are written
// again. It is tried for as long as the ring has room, so that nothing is lost that the ring holds.
//
// After the landing, what RAM still holds of the fall is written a second time, behind everything
// else: a blow or a failing supply may have spoiled the first copy in ways that the card itself does
// not notice. The decoder takes whichever copy is whole.
#pragma once

#include "block_ring.h"
#include "ports.h"
#include "spsc_queue.h"

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
  // A card that refuses this often in a row is given up when the ring is full but for 1/8 (0.7 s at
  // 1 kHz: no sample is lost between trying and giving up), or after this time once nothing is
  // captured any more that could fill it.
  static constexpr uint32_t kAttempts = 3;
  static constexpr uint32_t kGiveUpUs = 15000000;

  CardWriter(BlockRing& ring, BlockSink& sink) : ring_(ring), sink_(sink) {}

  protocol::ErrorCode open(uint32_t n_blocks);
  // One step: at most one block, one sync or one piece of the file. An error ends the recording.
  // `capturing`: more blocks are to come; `falling`: nothing is prepared that need not be.
  protocol::ErrorCode poll(uint64_t t_us, bool capturing, bool falling);
  // Writes the ring's blocks from `first` up to now again, if they are still there; at most
  // `max_blocks`, the newest. Returns how much room that takes.
  uint32_t rewrite(uint32_t first, uint32_t max_blocks);
  // Some of them are still to be written.
  bool rewriting() const { return rewrite_next_ != rewrite_end_; }
  // All of them are safe.
  bool rewritten() const { return rewrite_safe_ == rewrite_end_; }
  // Everything that was in the ring is with the card, and the card is not busy.
  bool drained(uint64_t t_us) {
    return !refused_ && !rewriting() && ring_.waiting() == unsynced_ && !sink_.busy(t_us);
  }
  // Closes the drained file. A refusal is met in poll(); closed() tells. An error ends the
  // recording.
  protocol::ErrorCode close(uint64_t t_us);
  bool closed() const { return closed_; }

  // Why the card takes nothing now, or kNone.
  protocol::ErrorCode trouble() const { return trouble_; }
  bool in_trouble_for(uint64_t t_us, uint32_t duration_us) const {
    return refusals_ > 0 && t_us - refused_since_us_ >= duration_us;
  }
  uint32_t blocks_written() const { return position_; }
  uint32_t blocks_rewritten() const { return rewritten_; }
  uint32_t stall_max_ms() const { return stall_max_ms_; }
  // Interrupt. A stall that has ended, a card lost or back, a second copy that is whole.
  bool take_event(protocol::Event& event);

 private:
  protocol::ErrorCode write_block(uint64_t t_us, const uint8_t* block);
  protocol::ErrorCode rewrite_one(uint64_t t_us);
  bool sync_due(uint64_t t_us) const;
  bool prepares(uint64_t t_us);
  bool ring_low() const { return ring_.waiting() >= ring_.capacity() - ring_.capacity() / 8; }
  protocol::ErrorCode take(protocol::ErrorCode result, uint64_t t_us);
  protocol::ErrorCode refuse(protocol::ErrorCode error, uint64_t t_us);
  void mark_synced(uint64_t t_us);
  void note_stall(uint64_t t_us);
  void note(uint64_t t_us, protocol::EventCode code, uint16_t arg, uint32_t value);

  BlockRing& ring_;
  BlockSink& sink_;
  SpscQueue<protocol::Event, 16> events_;
  Block copy_;
  uint32_t file_blocks_ = 0;
  uint32_t position_ = 0;       // of the file, where the next block goes
  uint32_t safe_position_ = 0;  // everything before is safe
  uint32_t unsynced_ = 0;       // blocks of the ring behind it, with the card and still in the ring
  uint32_t rewrite_next_ = 0;   // number in the ring
  uint32_t rewrite_safe_ = 0;
  uint32_t rewrite_end_ = 0;
  uint32_t rewritten_ = 0;
  uint32_t rewritten_safe_ = 0;
  uint64_t unsynced_since_us_ = 0;
  uint64_t turn_since_us_ = 0;  // of preparing
  uint64_t last_free_us_ = 0;
  uint64_t busy_since_us_ = 0;
  uint64_t refused_since_us_ = 0;
  uint64_t retry_at_us_ = 0;
  uint32_t stall_max_ms_ = 0;
  uint32_t refusals_ = 0;  // in a row
  protocol::ErrorCode trouble_ = protocol::ErrorCode::kNone;
  bool capturing_ = false;
  bool may_prepare_ = false;  // something is left, and time to do it
  bool prepare_turn_ = false;
  bool refused_ = false;  // recover() comes next
  bool was_free_ = false;
  bool closed_ = false;
  bool copy_turn_ = false;
};

}  // namespace logger
}  // namespace tfsat
