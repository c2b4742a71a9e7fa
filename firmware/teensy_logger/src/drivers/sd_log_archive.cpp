#include "sd_log_archive.h"

namespace tfsat {
namespace logger {

using protocol::ErrorCode;
using protocol::kBlockBytes;

bool SdLogArchive::readable() {
  const ErrorCode card = slot_.look();
  return card == ErrorCode::kNone || card == ErrorCode::kCardWriteProtected;
}

bool SdLogArchive::find(uint16_t from, uint16_t& number, uint32_t& n_blocks) {
  if (!readable()) return false;
  const uint16_t lowest = find_drop_files(slot_.volume(), from).lowest;
  if (lowest == 0 || !open(lowest)) return false;
  number = lowest;
  n_blocks = n_blocks_;
  return true;
}

ErrorCode SdLogArchive::read(uint16_t number, uint32_t index, uint8_t* block) {
  if (!open(number)) return readable() ? ErrorCode::kNoSuchLog : slot_.look();
  if (index >= n_blocks_) return ErrorCode::kNoSuchLog;
  if (file_.seekSet(static_cast<uint64_t>(index) * kBlockBytes) &&
      file_.read(block, kBlockBytes) == static_cast<int>(kBlockBytes)) {
    return ErrorCode::kNone;
  }
  forget(file_);
  return readable() ? ErrorCode::kCardUnreadable : slot_.look();
}

ErrorCode SdLogArchive::erase(uint16_t number) {
  forget(file_);
  const ErrorCode card = slot_.look();
  if (card != ErrorCode::kNone) return card;
  const DropFileName name(number);
  if (!slot_.volume().exists(name.text)) return ErrorCode::kNoSuchLog;
  FsFile file;
  if (!file.open(&slot_.volume(), name.text, O_RDWR)) return ErrorCode::kCardWriteFailed;
  const uint32_t n_blocks = static_cast<uint32_t>(file.fileSize() / kBlockBytes);
  if (!file.remove() || slot_.flush() != ErrorCode::kNone) return ErrorCode::kCardWriteFailed;
  slot_.give_room(n_blocks);
  return ErrorCode::kNone;
}

// Keeps the file open from block to block: finding it reads the directory.
bool SdLogArchive::open(uint16_t number) {
  if (file_.isOpen() && number_ == number && mounted_ == slot_.mounted()) return true;
  forget(file_);
  if (!file_.open(&slot_.volume(), DropFileName(number).text, O_RDONLY)) return false;
  n_blocks_ = static_cast<uint32_t>(file_.fileSize() / kBlockBytes);
  mounted_ = slot_.mounted();
  number_ = number;
  return true;
}

}  // namespace logger
}  // namespace tfsat
