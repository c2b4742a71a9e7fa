// A recording's file on the card.
//
// The file is allocated in one piece and filled with zeros, in steps; blocks go to the sectors of
// those steps directly. Once it is filled, no metadata is written until the recording ends. From the
// allocation on its directory entry states the whole length, so that whatever is on the card can be
// read anywhere. On exFAT that takes the filling, too: the entry also says how much of the file was
// ever written, and readers show no more. On any card, unfilled sectors would show blocks of old
// recordings.
#pragma once

#include "card_slot.h"
#include "drop_files.h"

namespace tfsat {
namespace logger {

class SdBlockSink final : public BlockSink {
 public:
  explicit SdBlockSink(CardSlot& slot) : slot_(slot) {}

  // Errors: what CardSlot::look() says, kCardWriteFailed, and kCardFull, also when the free room is
  // in pieces or no number is left.
  protocol::ErrorCode open(uint32_t n_blocks) override;
  bool busy(uint64_t t_us) override;
  // 8 KiB. SdFat's programmed transfers take the processor for 21 to 30 us a block, so that 32 MiB
  // take 1.5 to 2 s of it. An error is kCardWriteFailed.
  protocol::ErrorCode prepare() override;
  uint32_t prepared_blocks() override { return blocks_prepared_; }
  protocol::ErrorCode recover(uint64_t t_us) override;
  protocol::ErrorCode write(uint32_t index, const uint8_t* block) override;
  protocol::ErrorCode sync() override;
  protocol::ErrorCode close(uint32_t n_blocks) override;
  protocol::ErrorCode inspect(uint32_t n_blocks) override;
  uint32_t free_mib() override { return slot_.free_mib(); }

 private:
  bool create_next_file();
  bool find_unfilled();
  bool finish_step();
  uint64_t file_bytes() const { return static_cast<uint64_t>(n_blocks_) * protocol::kBlockBytes; }

  CardSlot& slot_;
  FsFile file_;  // while it is filled
  uint32_t n_blocks_ = 0;
  uint32_t blocks_filled_ = 0;
  uint32_t blocks_prepared_ = 0;  // filled, and its directory entry says so
  uint32_t first_sector_ = 0;
  uint16_t number_ = 0;
};

}  // namespace logger
}  // namespace tfsat
