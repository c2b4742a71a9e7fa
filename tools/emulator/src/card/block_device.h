// The SD card as the logger sees it: files of 512-byte blocks, busy times, what a power cut takes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "../sensors/noise.h"

namespace tfsat {
namespace emulator {

enum class CardResult : uint8_t {
  kOk,
  kBusy,
  kOutOfRange,  // beyond the file, or no room
  kAbsent,
  kWriteProtected,
  kUnreadable,  // no file system
  kFailed,      // it takes no block any more
};

enum class CardDefect : uint8_t { kNone, kWriteProtected, kUnreadable, kFailing };

enum class PowerCut : uint8_t {
  kLosesCache,           // what the card had not programmed yet is gone
  kTearsOldestInCache,   // and the block being programmed holds half of the new, half of the old
};

struct CardParameters {
  uint32_t write_us = 250;      // busy after a block
  uint32_t sync_us = 1000;      // busy after a sync
  uint32_t cache_blocks = 0;    // the card's own RAM: written, but lost in a power cut until synced
  uint32_t capacity_blocks = 1u << 22;  // 2 GiB
  uint32_t transfer_ns = 23000;  // of the processor, to hand over a block (SdFat on a Teensy 4.x)
  uint32_t stall_one_in = 0;     // writes keeps it busy for 50 to 500 ms; 0: none
  uint32_t mount_us = 0;         // to count its free room, when a board meets it
};

class BlockDevice {
 public:
  static constexpr size_t kBlockBytes = 512;

  explicit BlockDevice(const CardParameters& parameters = CardParameters());

  // The next file: contiguous, zero-filled, of this many blocks, on the medium when the call returns.
  CardResult preallocate(uint32_t n_blocks);
  // Whether such a file would find room.
  CardResult inspect(uint32_t n_blocks) const;
  uint32_t free_blocks() const;
  // Takes some zeros of the newest file, which are there already.
  CardResult fill(uint64_t t_us);
  bool busy(uint64_t t_us) const { return t_us < busy_until_us_; }
  CardResult write(uint64_t t_us, uint32_t block_index, const uint8_t data[kBlockBytes]);
  // Flushes the cache. The card is busy afterwards; its data is safe at once.
  CardResult sync(uint64_t t_us);
  // Clean stop: flushes and shortens the file to `n_blocks`; longer than it is changes nothing.
  CardResult truncate(uint32_t n_blocks);

  // The files, by number from 1 up: the first from `from` on; a block of one; its end.
  bool find(uint16_t from, uint16_t& number, uint32_t& n_blocks) const;
  CardResult read(uint16_t number, uint32_t block_index, uint8_t data[kBlockBytes]) const;
  CardResult erase(uint16_t number);
  // A file as it lies on the medium, put there by hand.
  void put_file(uint16_t number, const std::vector<uint8_t>& bytes);
  std::vector<uint8_t> file(uint16_t number) const;
  // The first number from `from` on, whatever is wrong with the card; 0 after the last.
  uint16_t next_file(uint16_t from) const;

  // What a person or a bad card does.
  void set_defect(CardDefect defect) { defect_ = defect; }
  // Somebody else's files leave it so much room; more than it has: there are none.
  void fill_up_to(uint32_t free_blocks);
  void stall_until(uint64_t t_us);     // the next transfers find the card busy until then
  // From now on a block now and then keeps it busy for `stall_us`: the first, and then one each
  // `every_us`, give or take half. With 0 each block does. A `stall_us` of 0 ends it.
  void set_stalls(uint64_t stall_us, uint64_t every_us);
  // Out of its contacts the card has no supply: what it had not programmed is lost.
  void set_present(bool present);
  bool present() const { return present_; }
  // How often one was pushed in.
  uint32_t insertions() const { return insertions_; }
  void set_busy_us(uint32_t after_block_us, uint32_t after_sync_us) {
    parameters_.write_us = after_block_us;
    parameters_.sync_us = after_sync_us;
  }
  void set_mount_us(uint32_t mount_us) { parameters_.mount_us = mount_us; }
  void power_cut(PowerCut kind);

  const CardParameters& parameters() const { return parameters_; }
  // Of the newest file.
  uint32_t n_blocks() const { return static_cast<uint32_t>(medium_.size() / kBlockBytes); }
  size_t unsynced_blocks() const { return cache_.size(); }
  uint64_t blocks_written() const { return blocks_written_; }
  std::vector<uint8_t> bytes() const;  // as a reader finds them while the card keeps its power

  // The file on the PC. False, with the reason in `error`, when the system refuses; a file to load
  // must hold whole blocks.
  bool save(const std::string& path, std::string& error) const;
  bool load(const std::string& path, std::string& error);

 private:
  struct CachedBlock {
    uint32_t index;
    std::vector<uint8_t> data;
  };
  CardResult state() const;
  uint32_t used_blocks() const;
  const std::vector<uint8_t>* find_file(uint16_t number) const;
  uint64_t stall_of_block(uint64_t t_us);
  static void program(const CachedBlock& block, size_t n_bytes, std::vector<uint8_t>& medium);
  void flush();

  CardParameters parameters_;
  std::vector<uint8_t> medium_;                      // the newest file
  std::map<uint16_t, std::vector<uint8_t>> older_;  // the others
  uint16_t newest_ = 0;                              // its number; 0: there is none
  uint32_t foreign_blocks_ = 0;
  CardDefect defect_ = CardDefect::kNone;
  std::deque<CachedBlock> cache_;  // oldest first
  uint64_t busy_until_us_ = 0;
  uint64_t blocks_written_ = 0;
  bool present_ = true;
  uint32_t insertions_ = 1;
  uint64_t stall_us_ = 0;
  uint64_t stall_every_us_ = 0;
  uint64_t next_stall_us_ = 0;
  Noise stall_random_{0x57A11u};
};

}  // namespace emulator
}  // namespace tfsat
