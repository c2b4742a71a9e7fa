// The recordings' files on the card, to be listed, read and erased.
#pragma once

#include "card_slot.h"
#include "drop_files.h"

namespace tfsat {
namespace logger {

class SdLogArchive final : public LogArchive {
 public:
  explicit SdLogArchive(CardSlot& slot) : slot_(slot) {}

  bool find(uint16_t from, uint16_t& number, uint32_t& n_blocks) override;
  // Errors: kNoSuchLog, what CardSlot::look() says, kCardUnreadable for a block that cannot be
  // read.
  protocol::ErrorCode read(uint16_t number, uint32_t index, uint8_t* block) override;
  // Errors: kNoSuchLog, what CardSlot::look() says, kCardWriteFailed.
  protocol::ErrorCode erase(uint16_t number) override;

 private:
  bool readable();
  bool open(uint16_t number);

  CardSlot& slot_;
  FsFile file_;  // the one that was read last
  uint32_t n_blocks_ = 0;
  uint32_t mounted_ = 0;
  uint16_t number_ = 0;
};

}  // namespace logger
}  // namespace tfsat
