// A recording's file on the built-in SD slot, through SdFat (SDIO, programmed transfers).
//
// The file is allocated in one piece, filled with zeros and closed to changes of its metadata;
// blocks then go to its sectors directly. On exFAT an allocated file that was not filled reads as
// empty after a power cut, and an unfilled one of any kind holds blocks of old recordings.
//
// SdFat waits up to 1 s for a card that is busy, and without limit inside a sector's transfer: only
// the main loop waits there, sampling goes on in its interrupt. A card that lost its contact answers
// no CMD13, which SdFat's isBusy() takes for busy, until it is initialised again.
#pragma once

#include <Arduino.h>
#include <SdFat.h>

#include "../core/ports.h"

namespace tfsat {
namespace logger {

class SdBlockSink final : public BlockSink {
 public:
  protocol::ErrorCode open(uint32_t n_blocks) override;
  protocol::ErrorCode poll(uint64_t t_us) override;
  bool busy() override;
  // Gives up after SdFat's 1 s for a card that is there and does not get ready. Another card than
  // at open() is refused: its sectors belong to somebody else's files.
  protocol::ErrorCode recover(uint64_t t_us) override;
  protocol::ErrorCode write(uint32_t index, const uint8_t* block) override;
  protocol::ErrorCode sync() override;
  protocol::ErrorCode close(uint32_t n_blocks) override;

 private:
  bool create_next_file();
  protocol::ErrorCode finish_preparation();

  SdFs card_;
  FsFile file_;
  cid_t card_id_ = {};
  uint32_t n_blocks_ = 0;
  uint32_t blocks_filled_ = 0;
  uint32_t first_sector_ = 0;
  uint16_t file_number_ = 0;
  bool ready_ = false;
};

}  // namespace logger
}  // namespace tfsat
