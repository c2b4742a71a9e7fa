// Samples and events into the 512-byte blocks of a recording, in place in the ring.
//
// Block numbers have no gaps: a block that finds no room in the ring is never begun, and its
// samples are counted as dropped instead.
//
// The scales stand in the header alone, so it is written again: every kHeaderRepeatBlocks, and once
// early, because a drop's recording may be shorter than that.
#pragma once

#include "block_ring.h"
#include "interval_stats.h"

namespace tfsat {
namespace logger {

class BlockBuilder {
 public:
  // Number of the first copy of the header: 0.15 s at 280 Hz, and at least 3.5 KiB from the original.
  static constexpr uint32_t kEarlyHeaderBlock = 8;

  explicit BlockBuilder(BlockRing& ring) : ring_(ring) {}

  // A new recording of at most `max_blocks` blocks. Empties the ring. Only while nobody captures.
  // `unix_at_zero_us`: Unix time at zero of the logger's clock; 0 when nobody has set it.
  void begin(uint32_t session, const protocol::LogHeader& header, uint64_t unix_at_zero_us,
             uint32_t max_blocks);
  // No end to the blocks from now on: RAM takes them, not a file.
  void forget_file() { max_blocks_ = UINT32_MAX; }
  // Main loop. The file has room for so many blocks more.
  void add_room(uint32_t blocks) { max_blocks_ = max_blocks_ + blocks; }
  // Main loop. Gives up to so many blocks of room away; returns how many.
  uint32_t give_room(uint32_t blocks);

  // Producer. The sample's time_offset_us is filled in here. A sample that finds no room is
  // counted.
  void add_sample(uint64_t t_us, protocol::Sample sample);
  // Producer. False, and nothing changed, when there is no room.
  bool add_event(const protocol::Event& event);
  // Producer. Closes a block that has waited for kPartialBlockMs.
  void flush_if_due(uint64_t t_us);
  // Producer. Closes the block that has been begun, however little it holds.
  void flush();
  // Closes the recording, with what the builder does not know of it filled in already; false while
  // the ring has no room. Only while nobody captures.
  bool add_footer(uint64_t t_us, protocol::LogFooter footer);

  // Samples taken, dropped ones included; of those, dropped; blocks made.
  uint32_t samples() const { return samples_.load(std::memory_order_relaxed); }
  uint32_t samples_dropped() const { return dropped_.load(std::memory_order_relaxed); }
  uint32_t blocks() const { return blocks_.load(std::memory_order_relaxed); }
  // Blocks that still have room in the file, the footer not counted.
  uint32_t room() const {
    const uint32_t made = blocks() + 1;
    const uint32_t max_blocks = max_blocks_;
    return made < max_blocks ? max_blocks - made : 0;
  }
  bool file_full() const { return room() == 0; }

 private:
  Block* open(uint64_t t_us);
  void drop_sample(uint64_t t_us);
  void note_drops();
  void append_event(const protocol::Event& event);
  bool put_header_if_due(uint64_t t_us);
  template <typename Payload>
  void put_whole(Block& block, protocol::BlockKind kind, const Payload& payload, uint64_t t_us);
  void close(Block& block, protocol::BlockKind kind, uint64_t t_us);

  BlockRing& ring_;
  protocol::LogHeader header_ = {};
  uint32_t session_ = 0;
  uint64_t unix_at_zero_us_ = 0;
  std::atomic<uint32_t> max_blocks_{0};

  Block* block_ = nullptr;  // the data block being filled
  uint64_t opened_us_ = 0;
  uint64_t block_time_us_ = 0;
  uint32_t first_sample_ = 0;
  uint8_t block_samples_ = 0;
  uint8_t block_events_ = 0;

  uint64_t first_dropped_us_ = 0;
  uint32_t drops_to_note_ = 0;
  IntervalStats intervals_;
  std::atomic<uint32_t> samples_{0};
  std::atomic<uint32_t> dropped_{0};
  std::atomic<uint32_t> blocks_{0};
};

}  // namespace logger
}  // namespace tfsat
