// A recording's file on the card.
//
// The file is allocated in one piece, filled with zeros and closed; blocks then go to its sectors
// directly, and no metadata is written until the recording ends. From the allocation on its
// directory entry states the whole length, so that whatever is on the card can be read anywhere. On
// exFAT that takes the filling, too: the entry also says how much of the file was ever written, and
// readers show no more. On any card, unfilled sectors would show blocks of old recordings.
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
  // Fills a piece of the file with zeros, 32 MiB in 2 to 4 s, while the ring holds the samples. An
  // error is kCardWriteFailed.
  protocol::ErrorCode poll(uint64_t t_us) override;
  bool busy() override;
  protocol::ErrorCode recover(uint64_t t_us) override;
  protocol::ErrorCode write(uint32_t index, const uint8_t* block) override;
  protocol::ErrorCode sync() override;
  protocol::ErrorCode close(uint32_t n_blocks) override;
  protocol::ErrorCode inspect(uint32_t n_blocks) override;
  uint32_t free_mib() override { return slot_.free_mib(); }

 private:
  enum class Stage : uint8_t { kNoFile, kFilling, kReady };

  bool create_next_file();
  protocol::ErrorCode fill_some();
  protocol::ErrorCode finish_filling();
  uint64_t file_bytes() const { return static_cast<uint64_t>(n_blocks_) * protocol::kBlockBytes; }

  CardSlot& slot_;
  FsFile file_;  // while it is filled
  uint32_t n_blocks_ = 0;
  uint32_t blocks_filled_ = 0;
  uint32_t first_sector_ = 0;
  uint16_t number_ = 0;
  Stage stage_ = Stage::kNoFile;
};

}  // namespace logger
}  // namespace tfsat
