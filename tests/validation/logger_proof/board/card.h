// A card with RAM of its own, stalls, a contact that may be lost, and a medium that outlives the
// power.
#pragma once

#include <string.h>

#include "../../../../firmware/teensy_logger/src/core/ports.h"
#include "scenario.h"
#include "truth.h"

namespace proof {

using tfsat::protocol::ErrorCode;

constexpr uint32_t kTransferUs = 30;
constexpr uint32_t kProgramUs = 40;
constexpr uint32_t kMetadataUs = 3000;
constexpr uint32_t kPreparedBlocks = 128;
constexpr uint32_t kMediumBlocks = 8192;
using tfsat::protocol::kBlockBytes;

// What stays when the power goes.
struct Medium {
  uint8_t bytes[kMediumBlocks * kBlockBytes];
  uint32_t blocks;  // of all files
};

// Virtual time. Only waiting moves it on, and whoever waits is interrupted by what comes meanwhile.
class Clock {
 public:
  virtual uint64_t now_us() const = 0;
  // The main loop waits: sampling ticks come in it, the card may lose its contact, the power may
  // go.
  virtual void pass(uint64_t us) = 0;
  // The power is gone: nothing that follows has any effect.
  virtual bool dead() const = 0;
  // The file is about to be closed.
  virtual void closing() = 0;

 protected:
  ~Clock() = default;
};

class Card final : public tfsat::logger::BlockSink, public tfsat::logger::LogArchive {
 public:
  Card(Medium& medium, const Scenario& scenario, Clock& clock, Truth& truth)
  : medium_(medium),
        scenario_(scenario),
        clock_(clock),
        truth_(truth),
        timing_(scenario.seed, 3),
        fate_(scenario.seed, 4) {}

  ErrorCode open(uint32_t n_blocks) override {
    clock_.pass(timing_.between(5000, 20000));
    if (!usable()) return ErrorCode::kNoCard;
    const uint32_t first = files() == 0 ? 0 : file().first_block + file().blocks;
    if (files() == kFiles || n_blocks > kMediumBlocks - first) return ErrorCode::kCardFull;
    ++truth_.head.file_count;
    file() = FileTruth{first, n_blocks, 0};
    medium_.blocks = first + n_blocks;
    if (!scenario_.holds_older) memset(at(first), 0, n_blocks * kBlockBytes);
    prepared_ = 0;
    return ErrorCode::kNone;
  }
  bool busy(uint64_t) override {
    if (lost_ || !present_) return scenario_.busy_when_gone;
    return clock_.now_us() < busy_until_us_;
  }
  // A piece is half of a step of the driver's; the medium had its zeros at open().
  ErrorCode prepare() override {
    clock_.pass(timing_.between(1000, 30000));
    if (!usable()) return ErrorCode::kCardWriteFailed;
    const uint32_t left = file().blocks - prepared_;
    prepared_ += left < kPreparedBlocks ? left : kPreparedBlocks;
    return ErrorCode::kNone;
  }
  uint32_t prepared_blocks() override { return prepared_; }
  ErrorCode recover(uint64_t) override {
    clock_.pass(timing_.between(2000, 20000));
    if (!present_ || clock_.dead()) return ErrorCode::kNoCard;
    lost_ = false;
    busy_until_us_ = 0;
    return ErrorCode::kNone;
  }
  ErrorCode write(uint32_t index, const uint8_t* block) override {
    clock_.pass(kTransferUs);
    if (!usable()) return ErrorCode::kCardWriteFailed;
    if (index >= prepared_) return ErrorCode::kCardFull;
    busy_until_us_ = clock_.now_us() + timing_.between(50, 400);
    if (scenario_.stall_one_in != 0 && timing_.one_in(scenario_.stall_one_in)) stall();
    if (!usable()) return ErrorCode::kCardWriteFailed;
    remember(file().first_block + index, block);
    return ErrorCode::kNone;
  }
  ErrorCode sync() override {
    while (usable() && cached_ > 0) {
      clock_.pass(kProgramUs);
      if (usable() && cached_ > 0) program(0);
    }
    clock_.pass(timing_.between(200, 2000));
    if (!usable()) return ErrorCode::kCardWriteFailed;
    for (; first_unsynced_ < truth_.writes.count; ++first_unsynced_) {
      truth_.writes.items[first_unsynced_].synced = 1;
    }
    return ErrorCode::kNone;
  }
  ErrorCode close(uint32_t n_blocks) override {
    clock_.closing();
    const ErrorCode error = sync();
    if (error != ErrorCode::kNone) return error;
    clock_.pass(kMetadataUs);
    if (!usable()) return ErrorCode::kCardWriteFailed;
    file().blocks = n_blocks;
    medium_.blocks = file().first_block + n_blocks;
    clock_.pass(kMetadataUs);
    file().closed = usable();
    return closed() ? ErrorCode::kNone : ErrorCode::kCardWriteFailed;
  }
  ErrorCode inspect(uint32_t) override { return ErrorCode::kNone; }
  uint32_t free_mib() override { return 1000; }

  bool find(uint16_t, uint16_t&, uint32_t&) override { return false; }
  ErrorCode read(uint16_t, uint32_t, uint8_t*) override { return ErrorCode::kNoSuchLog; }
  ErrorCode erase(uint16_t) override { return ErrorCode::kNoSuchLog; }

  // It loses its supply, with its contact or with everything: what its RAM holds meets its fate.
  void lose_supply() {
    uint32_t torn = scenario_.fate == Fate::kTorn && cached_ > 0 ? 1 : 0;
    if (scenario_.fate == Fate::kMixed && fate_.one_in(2)) torn = 1;
    while (cached_ > 0) {
      const uint32_t slot = fate_.next() % cached_;
      if (torn > 0) {
        --torn;
        tear(cache_[slot]);
        forget(slot);
      } else if (scenario_.fate == Fate::kMixed && fate_.one_in(2)) {
        program(slot);
      } else {
        forget(slot);
      }
    }
    first_unsynced_ = truth_.writes.count;  // no later sync speaks for what is lost
  }
  void pull() {
    lose_supply();
    present_ = false;
    lost_ = true;
  }
  void put_back() { present_ = true; }
  // Destroys the first header and one in twenty of the blocks that stand on the medium a second
  // time.
  uint32_t spoil() {
    static uint8_t copies[kMediumBlocks];
    memset(copies, 0, sizeof copies);
    for (uint32_t i = 0; i < medium_.blocks; ++i) {
      if (owner_[i] != 0) ++copies[truth_.writes.items[owner_[i] - 1].number % kMediumBlocks];
    }
    uint32_t spoiled = 0;
    for (uint32_t i = 0; i < medium_.blocks; ++i) {
      if (owner_[i] == 0) continue;
      uint8_t& left = copies[truth_.writes.items[owner_[i] - 1].number % kMediumBlocks];
      if (i != 0 && (left < 2 || !fate_.one_in(20))) continue;
      --left;
      owner_[i] = 0;
      ++spoiled;
      at(i)[fate_.next() % kBlockBytes] ^= static_cast<uint8_t>(1u << fate_.next() % 8);
    }
    return spoiled;
  }
  // Notes which of the blocks that were taken stand there whole.
  void settle_truth() {
    for (uint32_t i = 0; i < medium_.blocks; ++i) {
      if (owner_[i] != 0) truth_.writes.items[owner_[i] - 1].on_medium = 1;
    }
  }
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
  // Either the driver says that the card is busy, or it waits inside write().
  void stall() {
    const uint64_t took_us = timing_.between(50000, 500001);
    TroubleTruth& trouble = truth_.troubles.add();
    trouble.from_us = clock_.now_us();
    trouble.to_us = clock_.now_us() + took_us;
    if (scenario_.waits_inside) {
      clock_.pass(took_us);
    } else {
      busy_until_us_ = trouble.to_us;
    }
  }
  void remember(uint32_t position, const uint8_t* block) {
    tfsat::protocol::BlockHeader head;
    head.decode(block, tfsat::protocol::BlockHeader::kSize);
    WriteTruth& write = truth_.writes.add();
    write.t_us = clock_.now_us();
    write.position = position;
    write.file = static_cast<uint8_t>(files());
    write.session = head.session;
    write.number = head.block_number;
    write.first_sample = head.first_sample;
    write.kind = static_cast<uint8_t>(head.kind);
    write.samples = head.sample_count;
    Cached& cached = cache_[cached_++];
    cached.position = position;
    cached.record = truth_.writes.count - 1;
    memcpy(cached.bytes, block, kBlockBytes);
    if (cached_ <= scenario_.cache_blocks) return;
    program(scenario_.fate == Fate::kMixed ? fate_.next() % cached_ : 0);
  }
  void program(uint32_t slot) {
    const Cached& cached = cache_[slot];
    memcpy(at(cached.position), cached.bytes, kBlockBytes);
    owner_[cached.position] = cached.record + 1;
    forget(slot);
  }
  // Of the new block some bytes: the first, the last, every other stretch, or the first and then
  // noise.
  void tear(const Cached& cached) {
    uint8_t* medium = at(cached.position);
    uint8_t before[kBlockBytes];
    memcpy(before, medium, kBlockBytes);
    const uint32_t form = fate_.next() % 4;
    const uint32_t split = fate_.between(1, kBlockBytes);
    const uint32_t stretch = 8u << fate_.next() % 6;
    for (uint32_t i = 0; i < kBlockBytes; ++i) {
      const uint8_t fresh = cached.bytes[i];
      switch (form) {
        case 0: medium[i] = i < split ? fresh : medium[i]; break;
        case 1: medium[i] = i < split ? medium[i] : fresh; break;
        case 2: medium[i] = i / stretch % 2 == 0 ? fresh : medium[i]; break;
        default: medium[i] = i < split ? fresh : static_cast<uint8_t>(fate_.next()); break;
      }
    }
    if (memcmp(medium, cached.bytes, kBlockBytes) == 0) {
      owner_[cached.position] = cached.record + 1;
    } else if (memcmp(medium, before, kBlockBytes) != 0) {
      owner_[cached.position] = 0;
    }
  }
  void forget(uint32_t slot) {
    --cached_;
    memmove(cache_ + slot, cache_ + slot + 1, (cached_ - slot) * sizeof cache_[0]);
  }
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
