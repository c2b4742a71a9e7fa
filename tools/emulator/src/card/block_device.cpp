#include "block_device.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace tfsat {
namespace emulator {

BlockDevice::BlockDevice(const CardParameters& parameters) : parameters_(parameters) {}

CardResult BlockDevice::preallocate(uint32_t n_blocks) {
  if (!present_) return CardResult::kAbsent;
  cache_.clear();
  medium_.assign(static_cast<size_t>(n_blocks) * kBlockBytes, 0);
  return CardResult::kOk;
}

CardResult BlockDevice::write(uint64_t t_us, uint32_t block_index, const uint8_t* data) {
  if (!present_) return CardResult::kAbsent;
  if (busy(t_us)) return CardResult::kBusy;
  if (block_index >= n_blocks()) return CardResult::kOutOfRange;
  cache_.push_back({block_index, std::vector<uint8_t>(data, data + kBlockBytes)});
  while (cache_.size() > parameters_.cache_blocks) {
    program(cache_.front(), kBlockBytes, medium_);
    cache_.pop_front();
  }
  ++blocks_written_;
  busy_until_us_ = t_us + parameters_.write_us;
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

void BlockDevice::stall_until(uint64_t t_us) { busy_until_us_ = std::max(busy_until_us_, t_us); }

void BlockDevice::set_present(bool present) {
  if (!present) power_cut(PowerCut::kLosesCache);
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
  cache_.clear();
  return true;
}

}  // namespace emulator
}  // namespace tfsat
