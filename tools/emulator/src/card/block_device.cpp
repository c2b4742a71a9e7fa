#include "block_device.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>

namespace tfsat {
namespace emulator {
namespace {
constexpr uint16_t kLastDropFile = 9999;  // as in the firmware's drivers/drop_files.h, which needs SdFat
}

BlockDevice::BlockDevice(const CardParameters& parameters) : parameters_(parameters) {}

CardResult BlockDevice::state() const {
  if (!present_) return CardResult::kAbsent;
  switch (defect_) {
    case CardDefect::kNone: break;
    case CardDefect::kWriteProtected: return CardResult::kWriteProtected;
    case CardDefect::kUnreadable: return CardResult::kUnreadable;
    case CardDefect::kFailing: return CardResult::kFailed;
  }
  return CardResult::kOk;
}

uint32_t BlockDevice::used_blocks() const {
  size_t bytes = medium_.size();
  for (const auto& [number, file] : older_) bytes += file.size();
  return static_cast<uint32_t>(bytes / kBlockBytes) + foreign_blocks_;
}

uint32_t BlockDevice::free_blocks() const {
  return present_ ? parameters_.capacity_blocks - std::min(used_blocks(), parameters_.capacity_blocks)
                  : 0;
}

void BlockDevice::fill_up_to(uint32_t free) {
  foreign_blocks_ = 0;
  const uint32_t room = parameters_.capacity_blocks - used_blocks();
  foreign_blocks_ = room - std::min(free, room);
}

CardResult BlockDevice::inspect(uint32_t n_blocks) const {
  if (state() != CardResult::kOk) return state();
  return free_blocks() < n_blocks ? CardResult::kOutOfRange : CardResult::kOk;
}

CardResult BlockDevice::preallocate(uint32_t n_blocks) {
  const CardResult result = inspect(n_blocks);
  if (result != CardResult::kOk) return result;
  if (newest_ >= kLastDropFile) return CardResult::kOutOfRange;
  flush();
  if (newest_ != 0) older_[newest_] = std::move(medium_);
  ++newest_;
  medium_.assign(static_cast<size_t>(n_blocks) * kBlockBytes, 0);
  return CardResult::kOk;
}

CardResult BlockDevice::fill(uint64_t t_us) {
  if (state() != CardResult::kOk) return state();
  if (busy(t_us)) return CardResult::kBusy;
  busy_until_us_ = t_us + parameters_.write_us + stall_of_block(t_us);
  return CardResult::kOk;
}

CardResult BlockDevice::write(uint64_t t_us, uint32_t block_index, const uint8_t* data) {
  if (state() != CardResult::kOk) return state();
  if (busy(t_us)) return CardResult::kBusy;
  if (block_index >= n_blocks()) return CardResult::kOutOfRange;
  cache_.push_back({block_index, std::vector<uint8_t>(data, data + kBlockBytes)});
  while (cache_.size() > parameters_.cache_blocks) {
    program(cache_.front(), kBlockBytes, medium_);
    cache_.pop_front();
  }
  ++blocks_written_;
  busy_until_us_ = t_us + parameters_.write_us + stall_of_block(t_us);
  return CardResult::kOk;
}

CardResult BlockDevice::sync(uint64_t t_us) {
  if (!present_) return CardResult::kAbsent;
  if (busy(t_us)) return CardResult::kBusy;
  flush();
  busy_until_us_ = t_us + parameters_.sync_us;
  return CardResult::kOk;
}

CardResult BlockDevice::truncate(uint32_t n_blocks_to_keep) {
  if (!present_) return CardResult::kAbsent;
  flush();
  if (n_blocks_to_keep < n_blocks())
    medium_.resize(static_cast<size_t>(n_blocks_to_keep) * kBlockBytes);
  return CardResult::kOk;
}

const std::vector<uint8_t>* BlockDevice::find_file(uint16_t number) const {
  if (number != 0 && number == newest_) return &medium_;
  const auto found = older_.find(number);
  return found == older_.end() ? nullptr : &found->second;
}

bool BlockDevice::find(uint16_t from, uint16_t& number, uint32_t& n_blocks) const {
  if (!present_ || defect_ == CardDefect::kUnreadable) return false;
  number = next_file(from);
  if (number == 0) return false;
  n_blocks = static_cast<uint32_t>(find_file(number)->size() / kBlockBytes);
  return true;
}

uint16_t BlockDevice::next_file(uint16_t from) const {
  const auto older = older_.lower_bound(from);
  if (older != older_.end()) return older->first;
  return newest_ >= from ? newest_ : 0;
}

CardResult BlockDevice::read(uint16_t number, uint32_t block_index, uint8_t* data) const {
  if (!present_) return CardResult::kAbsent;
  const std::vector<uint8_t>* file = find_file(number);
  if (file == nullptr || (size_t{block_index} + 1) * kBlockBytes > file->size()) {
    return CardResult::kOutOfRange;
  }
  std::copy_n(file->begin() + static_cast<std::ptrdiff_t>(block_index * kBlockBytes), kBlockBytes,
              data);
  return CardResult::kOk;
}

CardResult BlockDevice::erase(uint16_t number) {
  if (state() != CardResult::kOk) return state();
  if (find_file(number) == nullptr) return CardResult::kOutOfRange;
  older_.erase(number);
  if (number != newest_) return CardResult::kOk;
  medium_.clear();
  newest_ = 0;
  if (!older_.empty()) {
    auto last = std::prev(older_.end());
    newest_ = last->first;
    medium_ = std::move(last->second);
    older_.erase(last);
  }
  return CardResult::kOk;
}

void BlockDevice::put_file(uint16_t number, const std::vector<uint8_t>& bytes) {
  if (number <= newest_) {
    (number == newest_ ? medium_ : older_[number]) = bytes;
    return;
  }
  if (newest_ != 0) older_[newest_] = std::move(medium_);
  newest_ = number;
  medium_ = bytes;
}

std::vector<uint8_t> BlockDevice::file(uint16_t number) const {
  if (number != 0 && number == newest_) return bytes();
  const std::vector<uint8_t>* found = find_file(number);
  return found == nullptr ? std::vector<uint8_t>() : *found;
}

void BlockDevice::stall_until(uint64_t t_us) { busy_until_us_ = std::max(busy_until_us_, t_us); }

void BlockDevice::set_stalls(uint64_t stall_us, uint64_t every_us) {
  stall_us_ = stall_us;
  stall_every_us_ = every_us;
  next_stall_us_ = 0;
}

uint64_t BlockDevice::stall_of_block(uint64_t t_us) {
  const bool by_chance = parameters_.stall_one_in != 0 &&
                         stall_random_.uniform() * parameters_.stall_one_in < 1.0;
  if (by_chance) return 50000 + static_cast<uint64_t>(stall_random_.uniform() * 450000.0);
  if (stall_us_ == 0 || t_us < next_stall_us_) return 0;
  const double apart = (0.5 + stall_random_.uniform()) * static_cast<double>(stall_every_us_);
  next_stall_us_ = t_us + stall_us_ + static_cast<uint64_t>(apart);
  return stall_us_;
}

void BlockDevice::set_present(bool present) {
  if (!present) power_cut(PowerCut::kLosesCache);
  if (present && !present_) ++insertions_;
  present_ = present;
}

void BlockDevice::power_cut(PowerCut kind) {
  if (kind == PowerCut::kTearsOldestInCache && !cache_.empty())
    program(cache_.front(), kBlockBytes / 2, medium_);
  cache_.clear();
  busy_until_us_ = 0;
}

void BlockDevice::program(const CachedBlock& block, size_t n_bytes, std::vector<uint8_t>& medium) {
  std::copy_n(block.data.begin(), n_bytes,
              medium.begin() + static_cast<std::ptrdiff_t>(block.index * kBlockBytes));
}

void BlockDevice::flush() {
  for (const CachedBlock& block : cache_) program(block, kBlockBytes, medium_);
  cache_.clear();
}

std::vector<uint8_t> BlockDevice::bytes() const {
  std::vector<uint8_t> all = medium_;
  for (const CachedBlock& block : cache_) program(block, kBlockBytes, all);
  return all;
}

bool BlockDevice::save(const std::string& path, std::string& error) const {
  const std::vector<uint8_t> all = bytes();
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) {
    error = path + ": " + std::strerror(errno);
    return false;
  }
  const bool written = all.empty() || std::fwrite(all.data(), 1, all.size(), file) == all.size();
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed) error = path + ": " + std::strerror(errno);
  return written && closed;
}

bool BlockDevice::load(const std::string& path, std::string& error) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) {
    error = path + ": " + std::strerror(errno);
    return false;
  }
  std::vector<uint8_t> all;
  uint8_t buffer[64 * kBlockBytes];
  size_t n = 0;
  while ((n = std::fread(buffer, 1, sizeof buffer, file)) > 0)
    all.insert(all.end(), buffer, buffer + n);
  const bool failed = std::ferror(file) != 0;
  std::fclose(file);
  if (failed || all.size() % kBlockBytes != 0) {
    error = path + (failed ? ": cannot be read" : ": does not hold whole 512-byte blocks");
    return false;
  }
  medium_ = std::move(all);
  if (newest_ == 0) newest_ = 1;
  cache_.clear();
  return true;
}

}  // namespace emulator
}  // namespace tfsat
