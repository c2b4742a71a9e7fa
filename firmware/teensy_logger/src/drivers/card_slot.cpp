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
  if (!still_there()) verdict_ = mount();
  return verdict_;
}

// A card that was pulled and put back has lost its address and does not answer to it. An unreadable
// one is tried again: it may have been met while it was being pushed in.
bool CardSlot::still_there() {
  const bool usable = verdict_ == ErrorCode::kNone || verdict_ == ErrorCode::kCardWriteProtected;
  return usable && !has_failed();
}

bool CardSlot::has_failed() {
  return !card().syncDevice() || card().errorCode() != SD_CARD_ERROR_NONE ||
         card().status() == kNoAnswer;
}

ErrorCode CardSlot::mount() {
  ++mounted_;
  free_blocks_ = 0;
  if (!start() || !card().readCID(&card_id_)) return ErrorCode::kNoCard;
  if (!volume_.volumeBegin()) return ErrorCode::kCardUnreadable;
  count_room();
  if (has_failed()) return ErrorCode::kCardUnreadable;
  return is_write_protected(card()) ? ErrorCode::kCardWriteProtected : ErrorCode::kNone;
}

// SdFat keeps count on FAT32 and reads the bitmap again on exFAT, 15 ms for a million clusters.
void CardSlot::count_room() {
  const uint32_t free_clusters = volume_.freeClusterCount();
  constexpr uint32_t kUnknown = UINT32_MAX;  // FatPartition::freeClusterCount() could not read
  free_blocks_ = free_clusters == kUnknown
                     ? 0
                     : static_cast<uint64_t>(free_clusters) * volume_.sectorsPerCluster();
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
