#include "sd_block_sink.h"

#include <string.h>

namespace tfsat {
namespace logger {

using protocol::ErrorCode;
using protocol::kBlockBytes;

namespace {

constexpr uint32_t kFillBlocks = 16;
alignas(32) const uint8_t kZeros[kFillBlocks * kBlockBytes] PROGMEM = {};  // SdFat moves words

constexpr uint16_t kLastFileNumber = 9999;

void put_number(char digits[4], uint16_t number) {
  for (int8_t i = 3; i >= 0; --i, number /= 10) digits[i] = static_cast<char>('0' + number % 10);
}

}  // namespace

ErrorCode SdBlockSink::open(uint32_t n_blocks) {
  ready_ = false;
  file_.close();
  if (!card_.cardBegin(SdioConfig(FIFO_SDIO)) || !card_.card()->readCID(&card_id_)) {
    return ErrorCode::kNoCard;
  }
  if (!card_.volumeBegin()) return ErrorCode::kCardWriteFailed;
  if (!create_next_file()) return ErrorCode::kCardWriteFailed;
  if (!file_.preAllocate(static_cast<uint64_t>(n_blocks) * kBlockBytes)) {
    file_.remove();
    return ErrorCode::kCardFull;
  }
  n_blocks_ = n_blocks;
  blocks_filled_ = 0;
  return ErrorCode::kNone;
}

// DROP0001.BIN counted up; from the last one on, because each look-up reads the directory.
bool SdBlockSink::create_next_file() {
  char name[] = "DROP0000.BIN";
  while (file_number_ < kLastFileNumber) {
    ++file_number_;
    put_number(name + 4, file_number_);
    if (!card_.exists(name)) return file_.open(&card_, name, O_RDWR | O_CREAT | O_EXCL);
  }
  return false;
}

// Fills a piece of the file with zeros. The ring holds the samples meanwhile: 32 MiB take 2 to 4 s.
ErrorCode SdBlockSink::poll(uint64_t) {
  if (ready_ || !file_.isOpen()) return ErrorCode::kNone;
  const uint32_t left = n_blocks_ - blocks_filled_;
  const uint32_t count = left < kFillBlocks ? left : kFillBlocks;
  const size_t bytes = count * kBlockBytes;
  // A write that failed may have moved the position.
  if (!file_.seekSet(static_cast<uint64_t>(blocks_filled_) * kBlockBytes)) {
    return ErrorCode::kCardWriteFailed;
  }
  if (file_.write(kZeros, bytes) != bytes) return ErrorCode::kCardWriteFailed;
  blocks_filled_ += count;
  return blocks_filled_ == n_blocks_ ? finish_preparation() : ErrorCode::kNone;
}

ErrorCode SdBlockSink::finish_preparation() {
  uint32_t last_sector = 0;
  if (!file_.sync() || !file_.contiguousRange(&first_sector_, &last_sector)) {
    return ErrorCode::kCardWriteFailed;
  }
  if (last_sector - first_sector_ + 1 < n_blocks_) return ErrorCode::kCardFull;
  ready_ = true;
  return ErrorCode::kNone;
}

bool SdBlockSink::busy() { return !ready_ || card_.card()->isBusy(); }

// The volume and the file stay as they are: both refer to the same card object.
ErrorCode SdBlockSink::recover(uint64_t) {
  cid_t id = {};
  if (!card_.cardBegin(SdioConfig(FIFO_SDIO)) || !card_.card()->readCID(&id)) {
    return ErrorCode::kNoCard;
  }
  return memcmp(&id, &card_id_, sizeof id) == 0 ? ErrorCode::kNone : ErrorCode::kNoCard;
}

ErrorCode SdBlockSink::write(uint32_t index, const uint8_t* block) {
  if (index >= n_blocks_) return ErrorCode::kCardFull;
  return card_.card()->writeSector(first_sector_ + index, block) ? ErrorCode::kNone
                                                                 : ErrorCode::kCardWriteFailed;
}

// Ends the running multi-sector write, which makes the card program what it has taken.
ErrorCode SdBlockSink::sync() {
  return card_.card()->syncDevice() ? ErrorCode::kNone : ErrorCode::kCardWriteFailed;
}

ErrorCode SdBlockSink::close(uint32_t n_blocks) {
  const bool done = card_.card()->syncDevice() &&
                    file_.truncate(static_cast<uint64_t>(n_blocks) * kBlockBytes) && file_.close();
  ready_ = false;
  return done ? ErrorCode::kNone : ErrorCode::kCardWriteFailed;
}

}  // namespace logger
}  // namespace tfsat
