#include "sd_block_sink.h"

namespace tfsat {
namespace logger {

using protocol::ErrorCode;
using protocol::kBlockBytes;

namespace {

constexpr uint32_t kFillBlocks = 16;
constexpr uint32_t kStepBlocks = 256;
alignas(32) const uint8_t kZeros[kFillBlocks * kBlockBytes] PROGMEM = {};  // SdFat moves words

}  // namespace

ErrorCode SdBlockSink::inspect(uint32_t n_blocks) {
  const ErrorCode error = slot_.look();
  if (error != ErrorCode::kNone) return error;
  return n_blocks <= slot_.free_blocks() ? ErrorCode::kNone : ErrorCode::kCardFull;
}

ErrorCode SdBlockSink::open(uint32_t n_blocks) {
  forget(file_);
  const ErrorCode error = inspect(n_blocks);
  const bool counting = error == ErrorCode::kBusy;  // then the allocation tells whether there is room
  if (error != ErrorCode::kNone && !counting) return error;
  n_blocks_ = n_blocks;
  blocks_filled_ = 0;
  blocks_prepared_ = 0;
  if (!create_next_file() || !file_.preAllocate(file_bytes()) ||
      !file_.contiguousRange(&first_sector_, nullptr)) {
    const bool failed = slot_.has_failed();
    file_.remove();
    return failed ? ErrorCode::kCardWriteFailed : ErrorCode::kCardFull;
  }
  return ErrorCode::kNone;
}

// One number above the highest, so that recordings stay in the order of their numbers.
bool SdBlockSink::create_next_file() {
  const uint16_t highest = find_drop_files(slot_.volume(), kFirstDropFile).highest;
  for (number_ = highest + 1; number_ <= kLastDropFile; ++number_) {
    const DropFileName name(number_);
    if (slot_.volume().exists(name.text)) continue;  // a damaged directory ended the search early
    return file_.open(&slot_.volume(), name.text, O_RDWR | O_CREAT | O_EXCL);
  }
  return false;
}

bool SdBlockSink::busy(uint64_t) { return slot_.card().isBusy(); }

ErrorCode SdBlockSink::prepare() {
  if (!file_.isOpen() && !find_unfilled()) return ErrorCode::kCardWriteFailed;
  const uint32_t left = n_blocks_ - blocks_filled_;
  const uint32_t count = left < kFillBlocks ? left : kFillBlocks;
  const size_t bytes = count * kBlockBytes;
  if (file_.write(kZeros, bytes) != bytes) return ErrorCode::kCardWriteFailed;
  blocks_filled_ += count;
  const bool step = blocks_filled_ == n_blocks_ || blocks_filled_ - blocks_prepared_ >= kStepBlocks;
  return !step || finish_step() ? ErrorCode::kNone : ErrorCode::kCardWriteFailed;
}

// After a loss of contact the file is looked up, and filled from where its entry says that it is:
// what SdFat had in mind for that entry may not be what the card has.
bool SdBlockSink::find_unfilled() {
  blocks_filled_ = blocks_prepared_;
  return file_.open(&slot_.volume(), DropFileName(number_).text, O_RDWR) &&
         file_.seekSet(static_cast<uint64_t>(blocks_filled_) * kBlockBytes);
}

bool SdBlockSink::finish_step() {
  if (!file_.sync() || slot_.flush() != ErrorCode::kNone) return false;
  blocks_prepared_ = blocks_filled_;
  if (blocks_prepared_ == n_blocks_) forget(file_);
  return true;
}

ErrorCode SdBlockSink::recover(uint64_t) {
  forget(file_);
  return slot_.restart();
}

ErrorCode SdBlockSink::write(uint32_t index, const uint8_t* block) {
  if (index >= n_blocks_) return ErrorCode::kCardFull;
  return slot_.card().writeSector(first_sector_ + index, block) ? ErrorCode::kNone
                                                                : ErrorCode::kCardWriteFailed;
}

ErrorCode SdBlockSink::sync() { return slot_.flush(); }

// When the card is well and the file cannot be shortened, it stays as long as it is: the recording
// is whole, and a decoder does not go by the length. What was not filled yet goes with the rest.
ErrorCode SdBlockSink::close(uint32_t n_blocks) {
  forget(file_);
  const ErrorCode error = slot_.flush();
  if (error != ErrorCode::kNone) return error;
  FsFile file;
  const bool shortened = file.open(&slot_.volume(), DropFileName(number_).text, O_RDWR) &&
                         file.truncate(static_cast<uint64_t>(n_blocks) * kBlockBytes) &&
                         slot_.flush() == ErrorCode::kNone;
  if (!shortened && slot_.has_failed()) return ErrorCode::kCardWriteFailed;
  slot_.take_room(shortened ? n_blocks : n_blocks_);
  return ErrorCode::kNone;
}

}  // namespace logger
}  // namespace tfsat
