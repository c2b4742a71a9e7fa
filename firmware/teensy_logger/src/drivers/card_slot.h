// The built-in SD slot: which card is in it, and what it is fit for. SdFat drives it, with
// programmed transfers.
//
// All of SdFat's waits for a card end after 1 s, and only the main loop waits there. Its loops
// without a limit (SdioCard::readData(), writeData()) and in initSDHC() wait for the controller,
// whose clock runs whatever the card does; sampling goes on in its interrupt all the same.
#pragma once

#include <Arduino.h>
#include <SdFat.h>

#include "../core/ports.h"

namespace tfsat {
namespace logger {

class CardSlot {
 public:
  // Looks at the card, which takes a fraction of a millisecond, and starts and mounts it when it is
  // not the one that was there, or has failed since. Then each look reads a piece of a FAT32's
  // allocation table, to count the free room: in all 0.1 to 0.5 s as cards come formatted, 4 s for
  // 32 GB in clusters of 4 KiB. SdFat would count in one go, and its reading calls no yield() in
  // which a host could be answered. Errors: kBusy while it counts, kNoCard, kCardUnreadable,
  // kCardWriteProtected.
  protocol::ErrorCode look();

  // Starts the same card anew, as after a loss of contact, and mounts it anew: SdFat would take for
  // written what the card has forgotten. kNoCard also when it is another card, whose sectors belong
  // to somebody else's files; kCardUnreadable.
  protocol::ErrorCode restart();

  // Ends the transfer under way, which makes the card program what it has taken, and asks whether
  // it did. Errors: kCardWriteFailed.
  protocol::ErrorCode flush();

  // Something that the card was told to do since it was started did not succeed.
  bool has_failed();

  // Free room of the card that was mounted last, when it was counted last.
  uint64_t free_blocks() const { return free_blocks_; }
  uint32_t free_mib() const { return static_cast<uint32_t>(free_blocks_ / kBlocksPerMib); }
  // A file of so many blocks has come, or has gone.
  void take_room(uint32_t n_blocks);
  void give_room(uint32_t n_blocks) { free_blocks_ += whole_clusters(n_blocks); }

  // Counts the times that a card was mounted. What was open before is void.
  uint32_t mounted() const { return mounted_; }
  SdFs& volume() { return volume_; }
  SdCard& card() { return *volume_.card(); }

 private:
  static constexpr uint32_t kBlocksPerMib = (1u << 20) / protocol::kBlockBytes;

  bool start();
  bool still_there();
  protocol::ErrorCode mount();
  protocol::ErrorCode count_some();
  protocol::ErrorCode finish_counting(uint32_t free_clusters);
  uint64_t whole_clusters(uint32_t n_blocks) const;

  SdFs volume_;
  cid_t card_id_ = {};
  uint64_t free_blocks_ = 0;
  uint32_t entries_counted_ = 0;  // of the allocation table
  uint32_t free_clusters_ = 0;    // among them
  uint32_t mounted_ = 0;
  protocol::ErrorCode verdict_ = protocol::ErrorCode::kNoCard;
};

}  // namespace logger
}  // namespace tfsat
