#include "card_slot.h"

#include <string.h>

namespace tfsat {
namespace logger {

using protocol::ErrorCode;

namespace {

// SD Physical Layer Simplified Specification 9.00, sec. 5.3: CSD bits 13 and 12, permanent and
// temporary write protection. SdFat keeps the register with its first byte first.
constexpr size_t kCsdProtectionByte = 14;
constexpr uint8_t kCsdProtected = 0x30;

// Sec. 4.10.1, card status: WP_VIOLATION, CARD_ECC_FAILED, CC_ERROR and ERROR. Of an answer, at
// least CURRENT_STATE is never 0; SdFat returns 0 for none.
constexpr uint32_t kStatusErrors = 0x04380000;
constexpr uint32_t kNoAnswer = 0;

constexpr uint32_t kFirstCluster = 2;
constexpr uint32_t kEntryMask = 0x0FFFFFFF;
constexpr uint32_t kEntriesASector = protocol::kBlockBytes / sizeof(uint32_t);
constexpr uint32_t kSectorsALook = 64;

bool is_write_protected(SdCard& card) {
  csd_t csd;
  if (!card.readCSD(&csd)) return false;
  uint8_t bytes[sizeof csd];
  memcpy(bytes, &csd, sizeof csd);
  return (bytes[kCsdProtectionByte] & kCsdProtected) != 0;
}

}  // namespace

// SdioCard::begin() forgets everything but a sector that was under way, whose end isBusy() would
// wait for ever after: that one is ended before, whether well or not.
bool CardSlot::start() {
  if (volume_.card() != nullptr) volume_.card()->syncDevice();
  return volume_.cardBegin(SdioConfig(FIFO_SDIO));
}

ErrorCode CardSlot::look() {
  if (!still_there()) {
    verdict_ = mount();
  } else if (verdict_ == ErrorCode::kBusy) {
    verdict_ = count_some();
  }
  return verdict_;
}

// A card that was pulled and put back has lost its address and does not answer to it. An unreadable
// one is tried again: it may have been met while it was being pushed in.
bool CardSlot::still_there() {
  const bool usable = verdict_ == ErrorCode::kNone || verdict_ == ErrorCode::kBusy ||
                      verdict_ == ErrorCode::kCardWriteProtected;
  return usable && !has_failed();
}

bool CardSlot::has_failed() {
  return !card().syncDevice() || card().errorCode() != SD_CARD_ERROR_NONE ||
         card().status() == kNoAnswer;
}

// Of exFAT, SdFat counts the bitmap, 15 ms for a million clusters; of FAT16 there is not much.
ErrorCode CardSlot::mount() {
  ++mounted_;
  free_blocks_ = 0;
  if (!start() || !card().readCID(&card_id_)) return ErrorCode::kNoCard;
  if (!volume_.volumeBegin()) return ErrorCode::kCardUnreadable;
  entries_counted_ = 0;
  free_clusters_ = 0;
  if (volume_.fatType() == FAT_TYPE_FAT32) return ErrorCode::kBusy;
  return finish_counting(volume_.freeClusterCount());
}

// The table has an entry of 28 bits for each cluster behind two that are none; 0 is free (Microsoft,
// FAT32 File System Specification 1.03, FAT Data Structure).
ErrorCode CardSlot::count_some() {
  uint32_t entries[kEntriesASector];
  const uint32_t end = kFirstCluster + volume_.clusterCount();
  for (uint32_t i = 0; i < kSectorsALook && entries_counted_ < end; ++i) {
    const uint32_t sector = volume_.fatStartSector() + entries_counted_ / kEntriesASector;
    if (!card().readSector(sector, reinterpret_cast<uint8_t*>(entries))) {
      return ErrorCode::kCardUnreadable;
    }
    for (const uint32_t entry : entries) {
      const bool cluster = entries_counted_ >= kFirstCluster && entries_counted_ < end;
      if (cluster && (entry & kEntryMask) == 0) ++free_clusters_;
      ++entries_counted_;
    }
  }
  return entries_counted_ < end ? ErrorCode::kBusy : finish_counting(free_clusters_);
}

ErrorCode CardSlot::finish_counting(uint32_t free_clusters) {
  if (has_failed() || free_clusters > volume_.clusterCount()) return ErrorCode::kCardUnreadable;
  free_blocks_ = static_cast<uint64_t>(free_clusters) * volume_.sectorsPerCluster();
  return is_write_protected(card()) ? ErrorCode::kCardWriteProtected : ErrorCode::kNone;
}

uint64_t CardSlot::whole_clusters(uint32_t n_blocks) const {
  const uint32_t size = volume_.sectorsPerCluster();
  return (static_cast<uint64_t>(n_blocks) + size - 1) / size * size;
}

void CardSlot::take_room(uint32_t n_blocks) {
  const uint64_t taken = whole_clusters(n_blocks);
  free_blocks_ -= taken < free_blocks_ ? taken : free_blocks_;
}

ErrorCode CardSlot::restart() {
  cid_t id = {};
  const bool same = start() && card().readCID(&id) && memcmp(&id, &card_id_, sizeof id) == 0;
  ++mounted_;
  // Whatever is not kNone is mounted by the next look().
  verdict_ = ErrorCode::kNoCard;
  if (same) verdict_ = volume_.volumeBegin() ? ErrorCode::kNone : ErrorCode::kCardUnreadable;
  return verdict_;
}

// CMD13 must not come while a sector is under way: SdFat would clear the flag that tells its end.
ErrorCode CardSlot::flush() {
  if (!card().syncDevice()) return ErrorCode::kCardWriteFailed;
  const uint32_t status = card().status();
  const bool kept = status != kNoAnswer && (status & kStatusErrors) == 0;
  return kept ? ErrorCode::kNone : ErrorCode::kCardWriteFailed;
}

}  // namespace logger
}  // namespace tfsat
