// A card with RAM of its own, stalls, a contact that may be lost, and a medium that outlives the
// power.
#pragma once

#include "../../../firmware/teensy_logger/src/core/ports.h"
#include "clock.h"
#include "draw.h"
#include "scenario.h"
#include "truth.h"

namespace proof {

using tfsat::protocol::ErrorCode;

constexpr uint32_t kMediumBlocks = 8192;
constexpr uint32_t kBlockBytes = tfsat::protocol::kBlockBytes;

// What stays when the power goes.
struct Medium {
  uint8_t bytes[kMediumBlocks * kBlockBytes];
  uint32_t blocks;  // of all files
};

class Card final : public tfsat::logger::BlockSink, public tfsat::logger::LogArchive {
 public:
  Card(Medium& medium, const Scenario& scenario, Clock& clock, Truth& truth);

  ErrorCode open(uint32_t n_blocks) override;
  bool busy(uint64_t) override;
  ErrorCode prepare() override;
  uint32_t prepared_blocks() override { return prepared_; }
  ErrorCode recover(uint64_t) override;
  ErrorCode write(uint32_t index, const uint8_t* block) override;
  ErrorCode sync() override;
  ErrorCode close(uint32_t n_blocks) override;
  ErrorCode inspect(uint32_t) override { return ErrorCode::kNone; }
  uint32_t free_mib() override { return 1000; }

  bool find(uint16_t, uint16_t&, uint32_t&) override { return false; }
  ErrorCode read(uint16_t, uint32_t, uint8_t*) override { return ErrorCode::kNoSuchLog; }
  ErrorCode erase(uint16_t) override { return ErrorCode::kNoSuchLog; }

  // It loses its supply, with its contact or with everything: what its RAM holds meets its fate.
  void lose_supply();
  void pull() {
    lose_supply();
    present_ = false;
    lost_ = true;
  }
  void put_back() { present_ = true; }
  // Destroys the first header and one in twenty of the blocks that stand on the medium a second
  // time.
  uint32_t spoil();
  // Notes which of the blocks that were taken stand there whole.
  void settle_truth();
  uint32_t files() const { return truth_.head.file_count; }
  bool closed() const { return files() > 0 && file().closed != 0; }

 private:
  static constexpr uint32_t kCacheRoom = 65;
  struct Cached {
    uint32_t position;
    uint32_t record;  // in truth.writes
    uint8_t bytes[kBlockBytes];
  };

  FileTruth& file() const { return truth_.head.files[truth_.head.file_count - 1]; }
  bool usable() const { return present_ && !lost_ && !clock_.dead(); }
  void stall();
  void remember(uint32_t position, const uint8_t* block);
  void program(uint32_t slot);
  void tear(const Cached& cached);
  void forget(uint32_t slot);
  uint8_t* at(uint32_t position) { return medium_.bytes + position * kBlockBytes; }

  Medium& medium_;
  const Scenario& scenario_;
  Clock& clock_;
  Truth& truth_;
  Draw timing_;
  Draw fate_;
  Cached cache_[kCacheRoom];
  uint32_t cached_ = 0;
  uint32_t owner_[kMediumBlocks] = {};  // 1 + the record that stands there whole; 0: none
  uint32_t first_unsynced_ = 0;
  uint32_t prepared_ = 0;  // of the present file
  uint64_t busy_until_us_ = 0;
  bool present_ = true;
  bool lost_ = false;  // until recover()
};

}  // namespace proof
